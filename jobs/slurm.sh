#!/usr/bin/env bash
#SBATCH --job-name=trackbed
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:USR1@120
# A run in the queue of a cluster with Slurm, until it is finished:
#   sbatch -n 64 -t 24:00:00 jobs/slurm.sh DECK DIR [key=value...]
# A minute before its time ends, the run writes a checkpoint, and the job goes back into the queue
# and continues; likewise after the failure of a node. One job for each row of a table, whose first
# line names the parameters, with results in DIR/1, DIR/2 and so on:
#   sbatch --array=1-12 -n 8 -t 4:00:00 jobs/slurm.sh --table variants.csv DECK DIR [key=value...]
# `trackbed info DIR` tells how far a run is, `scancel` ends it; the same sbatch command continues
# it later. The program is build/release/trackbed in the folder of the submission, or $TRACKBED.
# Exit codes are those of the program: 3 if a job was ended early and does not go on by itself.
set -euo pipefail

table=
if [ "${1:-}" = --table ]; then
  table=${2:-}
  shift 2 || true
fi
if [ $# -lt 2 ] || [ -z "${SLURM_JOB_ID:-}" ]; then
  echo "usage: sbatch -n RANKS -t TIME [--array=1-ROWS] jobs/slurm.sh [--table FILE.csv] DECK DIR \
[key=value...]" >&2
  exit 2
fi
deck=$1 folder=$2
shift 2
program=${TRACKBED:-build/release/trackbed}
if [ ! -x "$program" ]; then
  echo "$program, in the folder of the submission, does not exist: build it there, or give its \
path in the environment variable TRACKBED" >&2
  exit 2
fi
job=$SLURM_JOB_ID
if [ -n "$table" ]; then
  row=${SLURM_ARRAY_TASK_ID:?"--table needs --array=1-ROWS"}
  job=${SLURM_ARRAY_JOB_ID}_$row
  folder=$folder/$row
  mapfile -d '' -t words < <(python3 - "$table" "$row" <<'END'
import csv
import sys

with open(sys.argv[1], newline="", encoding="utf-8") as file:
    rows = list(csv.DictReader(file))
number = int(sys.argv[2])
if not 1 <= number <= len(rows):
    sys.exit(f"{sys.argv[1]} has {len(rows)} rows, not row {number}: give --array=1-{len(rows)}")
for key, value in rows[number - 1].items():
    print(f"{key}={value}", end="\0")
END
  )
  wait $! || exit 2
  set -- "${words[@]}" "$@"
fi
if [ "$(id -u)" = 0 ]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi
export OMPI_MCA_mpi_yield_when_idle=1
# The program stops in time before it. Older versions of Slurm do not set it.
export SLURM_JOB_END_TIME=${SLURM_JOB_END_TIME:-$(date +%s -d "$(squeue -h -j "$job" -o %e)")}

before=$(cat "$folder/latest" 2>/dev/null || true)
mpirun -n "$SLURM_NTASKS" "$program" run "$deck" -o "$folder" --or-resume "$@" &
run=$! ended=
# USR1: Slurm, two minutes before the end; TERM: a job is taken away, and Slurm decides about it.
trap 'kill -USR1 $run 2>/dev/null || true' USR1
trap 'ended=1; kill -USR1 $run 2>/dev/null || true' TERM
code=0
wait $run || code=$?
while kill -0 $run 2>/dev/null; do  # a signal has ended `wait`, not the run
  code=0
  wait $run || code=$?
done
if [ $code = 3 ]; then
  echo "the run was stopped in time, with a checkpoint; mpirun's remarks on code 3 mean no more"
fi
if [ $code != 3 ] || [ -n "$ended" ]; then exit $code; fi
if [ "$(cat "$folder/latest" 2>/dev/null || true)" = "$before" ]; then
  echo "$folder: the job is too short for a checkpoint: give it more time (sbatch -t)" >&2
  exit 3
fi
scontrol requeue "$job" || {
  echo "the queue does not take the job back; submit it again to continue" >&2
  exit 3
}
