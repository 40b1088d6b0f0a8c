# Shared by the scripts in jobs/ and tests/; sourced, not run. Afterwards the working directory is
# the project's folder, Open MPI accepts root if the user is root, and these functions exist:
#   install_packages [NAME...]   Debian packages that are missing: of cmake/packages.txt, and these
#   build PRESET [-DOPTION=VALUE...] [TARGET...]   configures build/PRESET, builds (default: all)
#   part "TEXT" COMMAND...     runs a command and prints its wall time
#   run_model DECK DIR [--force] [key=value...]   the program on $RANKS ranks (default 2)
#   still_checkpoint DECK DIR   prints DIR's checkpoint of the last stage before the ground moves
#   draw COMMAND WORD...   a command of postproc/
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

python=/usr/bin/python3  # Debian's: only it has the modules of cmake/packages.txt

if [ "$(id -u)" = 0 ]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi

# Waiting ranks yield their core: no cost on free cores, a large saving on shared ones.
export OMPI_MCA_mpi_yield_when_idle=1

install_packages() {
  local missing=() package
  while read -r package; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' ||
      missing+=("$package")
  done < <(grep -v '^#' cmake/packages.txt; [ $# = 0 ] || printf '%s\n' "$@")
  if [ ${#missing[@]} = 0 ]; then
    echo "All packages of cmake/packages.txt are installed."
    return
  fi
  echo "Installing: ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" != 0 ]; then as_root=(sudo); fi
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends "${missing[@]}"
}

build() {
  local preset=$1 options=() targets=()
  shift
  while [[ "${1:-}" == -D* ]]; do
    options+=("$1")
    shift
  done
  if [ $# -gt 0 ]; then targets=(--target "$@"); fi
  cmake --preset "$preset" "${options[@]}"
  cmake --build --preset "$preset" "${targets[@]}"
}

part() {
  local text=$1 begin=$SECONDS
  shift
  printf '\n== %s\n' "$text"
  # No `if` or `||` around the command: bash would switch `set -e` off inside it.
  "$@"
  printf -- '-- %s: %d s\n' "$text" $((SECONDS - begin))
}

run_model() {
  local deck=$1 folder=$2 run code=0 stop_requested=0
  shift 2
  # On SIGTERM mpirun kills the ranks a second later; SIGUSR1 it passes on and then waits for their
  # checkpoint. In a session of its own it does not receive Ctrl-C from the terminal.
  setsid mpirun -n "${RANKS:-2}" --oversubscribe --bind-to none \
    build/release/trackbed run "$deck" -o "$folder" "$@" &
  run=$!
  # Repeated each second until it ends: without ranks mpirun does not pass the signal on.
  trap 'stop_requested=1; while kill -USR1 $run 2>/dev/null; do sleep 1; done &' TERM INT HUP
  wait $run || code=$?
  while kill -0 $run 2>/dev/null; do  # a signal has ended `wait`, not the run
    code=0
    wait $run || code=$?
  done
  trap - TERM INT HUP
  # SIGUSR1 kills mpirun itself (128 + 10) before it has ranks and after they have ended; 129, 130
  # and 143 are codes of `wait` if the run has ended in the meantime.
  if [ $stop_requested = 1 ] && [[ " 0 129 130 138 143 " == *" $code "* ]]; then code=3; fi
  return $code
}

# All stages before the first with ground_moves depend only on the flat top of the ground: a variant
# with another ground can start after them, with exactly the same stones.
still_checkpoint() {
  local deck=$1 folder=$2 stage file
  stage=$("$python" - "$deck" <<'END'
import sys
import tomllib

with open(sys.argv[1], "rb") as file:
    stages = tomllib.load(file)["stage"]
moving = [number for number, stage in enumerate(stages) if stage.get("ground_moves")]
if not moving:
    sys.exit(f"{sys.argv[1]}: no stage has ground_moves = true")
if moving[0] == 0:
    sys.exit(f"{sys.argv[1]}: the first stage already has ground_moves = true: "
             "no stage comes before it")
print(stages[moving[0] - 1]["name"])
END
  ) || return 1
  file=$PWD/$folder/stage_$stage.h5
  if [ ! -f "$file" ]; then
    echo "$file, from which the run without wedge starts, is missing; create it with:" \
      "build/release/trackbed run $deck -o $folder" >&2
    return 1
  fi
  printf '%s\n' "$file"
}

draw() {
  PYTHONDONTWRITEBYTECODE=1 "$python" postproc "$@"
}
