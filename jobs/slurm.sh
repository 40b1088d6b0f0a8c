#!/usr/bin/env bash
#SBATCH --job-name=trackbed
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:USR1@120
# A run in the queue of a cluster with Slurm, until it is finished:
#   sbatch -n 64 -t 24:00:00 jobs/slurm.sh DECK DIR [key=value...]
# Two minutes before its time ends, the run writes a checkpoint, and the job is requeued
# and continues; likewise after the failure of a node. One job for each row of a table, whose first
# line names the parameters, with results in DIR/1, DIR/2 and so on:
#   sbatch --array=1-12 -n 8 -t 4:00:00 jobs/slurm.sh --table variants.csv DECK DIR [key=value...]
# `trackbed info DIR` states how far a run is, `scancel` ends it; the same sbatch command continues
# it later. The program is build/release/trackbed in the folder of the submission, or $TRACKBED.
# Exit codes are those of the program: 3 if a job was ended early and does not go on by itself.
set -euo pipefail

refuse() {
  echo "$1" >&2
  exit 2
}

table=
if [ "${1:-}" = --table ]; then
  table=${2:-}
  shift 2 || true
fi
if [ $# -lt 2 ] || [ -z "${SLURM_JOB_ID:-}" ]; then
  refuse "usage: sbatch -n RANKS -t TIME [--array=1-ROWS] jobs/slurm.sh [--table FILE.csv] DECK \
DIR [key=value...]"
fi
deck=$1 folder=$2
shift 2
program=${TRACKBED:-build/release/trackbed}
[ -x "$program" ] || refuse "$program, in the folder of the submission, does not exist: build it \
there, or give its path in the environment variable TRACKBED"
job=$SLURM_JOB_ID
if [ -n "$table" ]; then
  row=${SLURM_ARRAY_TASK_ID:-}
  [ -n "$row" ] || refuse "--table $table: give the rows with sbatch --array=1-ROWS"
  job=${SLURM_ARRAY_JOB_ID}_$row
  folder=$folder/$row
  words=$(mktemp)
  python3 - "$table" "$row" >"$words" <<'END' || exit 2
import csv
import sys

table, number = sys.argv[1], int(sys.argv[2])
try:
    with open(table, newline="", encoding="utf-8-sig") as file:
        head, *rows = [[word.strip() for word in row] for row in csv.reader(file) if row]
except (OSError, ValueError) as error:
    sys.exit(f"{table}: {getattr(error, 'strerror', None) or 'has no line of names in UTF-8'}")
if not 1 <= number <= len(rows):
    sys.exit(f"{table} has {len(rows)} rows, not row {number}: give --array=1-{len(rows)}")
if len(rows[number - 1]) != len(head):
    sys.exit(f"{table}: row {number} has {len(rows[number - 1])} values, but {len(head)} names are "
             "given")
for key, value in zip(head, rows[number - 1]):
    print(f"{key}={value}", end="\0")
END
  mapfile -d '' -t of_row <"$words"
  rm -f "$words"
  set -- "${of_row[@]}" "$@"
fi
if [ "$(id -u)" = 0 ]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi
export OMPI_MCA_mpi_yield_when_idle=1
# The program stops in time before it. Values of the submission belong to another job, and older
# versions of Slurm set none; a job without a limit has no end.
unset TRACKBED_END_TIME SLURM_JOB_END_TIME
if end=$(date +%s -d "$(squeue -h -j "$job" -o %e)" 2>/dev/null); then
  export SLURM_JOB_END_TIME=$end
fi

# USR1: Slurm, two minutes before the end; TERM: a job is taken away, and Slurm decides about it. It
# is repeated, since mpirun loses it while it has no ranks.
asked= taken= run=
stop() {
  asked=1
  if [ -n "$run" ]; then (while kill -USR1 $run 2>/dev/null; do sleep 1; done) & fi
}
trap stop USR1
trap 'taken=1; stop' TERM
before=$(cat "$folder/latest" 2>/dev/null || true)
mpirun -n "${SLURM_NTASKS:-1}" "$program" run "$deck" -o "$folder" --or-resume "$@" &
run=$!
if [ -n "$asked" ]; then stop; fi
code=0
wait $run || code=$?
while kill -0 $run 2>/dev/null; do  # a signal has ended `wait`, not the run
  code=0
  wait $run || code=$?
done
# A signal in the moment in which the run ends: 128 and its number instead of the code of the run,
# which another `wait` returns. SIGUSR1 kills mpirun itself while it has no ranks.
if [ -n "$asked" ] && [ $code -gt 128 ]; then
  code=0
  wait $run 2>/dev/null || code=$?
  if [ $code = 138 ] || [ $code = 127 ]; then code=3; fi
fi
if [ $code != 3 ]; then exit $code; fi
if [ "$(cat "$folder/latest" 2>/dev/null || true)" = "$before" ]; then
  echo "$folder: the job ended before a new checkpoint: give it more time (sbatch -t)" >&2
  exit 3
fi
echo "the run was stopped in time, with a checkpoint; mpirun's remarks on code 3 mean no more"
if [ -n "$taken" ]; then exit 3; fi
scontrol requeue "$job" || {
  echo "the queue does not take the job back; submit it again to continue" >&2
  exit 3
}
