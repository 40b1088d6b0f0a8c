# Shared by the scripts in jobs/ and tests/; sourced, not run. Afterwards the working directory is
# the project's folder, Open MPI accepts root if that is who we are, and these functions exist:
#   install_packages           Debian packages of cmake/packages.txt that are missing
#   build PRESET [TARGET...]   configures build/PRESET and builds the targets (default: all)
#   part "TEXT" COMMAND...     runs a command and says how long it took
#   run_model DECK DIR [key=value...]   the program on $RANKS ranks (default 2)
#   figures DIR [DIR] -o DIR   draws
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

python=/usr/bin/python3  # Debian's: only it has the modules of cmake/packages.txt

if [ "$(id -u)" = 0 ]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi

# Ranks that wait give their core to others: costs nothing on free cores, saves much on shared ones.
export OMPI_MCA_mpi_yield_when_idle=1

install_packages() {
  local missing=() package
  while read -r package; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' ||
      missing+=("$package")
  done < <(grep -v '^#' cmake/packages.txt)
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
  local preset=$1 targets=()
  shift
  if [ $# -gt 0 ]; then targets=(--target "$@"); fi
  cmake --preset "$preset"
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
  local deck=$1 folder=$2
  shift 2
  mkdir -p "$folder"
  mpirun -n "${RANKS:-2}" --oversubscribe --bind-to none \
    build/release/trackbed run "$deck" -o "$folder" "$@"
}

figures() {
  PYTHONDONTWRITEBYTECODE=1 MPLBACKEND=Agg "$python" postproc/figures.py "$@"
}
