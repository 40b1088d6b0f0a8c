#!/usr/bin/env bash
# The second command: installs what is missing (Debian 12), builds everything and runs the tests.
#   tests/run.sh [PRESET] [long] [ctest option...]
# PRESET: release (default), debug, sanitize or thread
# e.g. `tests/run.sh sanitize -R _test_on_`, `tests/run.sh release -R style`. `long`: the tests that
# the other call leaves out, with the wall time of each.
source "$(dirname "${BASH_SOURCE[0]}")/../jobs/common.sh"

preset=release
case "${1:-}" in
  release | debug | sanitize | thread)
    preset=$1
    shift
    ;;
esac

# Runs of tests go to memory if 4 GB of it are free for files, and are removed at the end. To keep
# them in build/PRESET/tests/runs, call ctest itself.
runs=build/$preset/tests/runs
runs_in_memory() {
  local memory free
  free=$(df -k --output=avail /dev/shm 2>/dev/null | tail -n 1) || return 0
  if [ "${free:-0}" -lt 4000000 ]; then return; fi
  memory=$(mktemp -d /dev/shm/trackbed.XXXXXX)
  rm -rf "$runs"
  ln -s "$memory" "$runs"
  # shellcheck disable=SC2064  # the values of now
  trap "rm -rf '$memory' '$runs'; mkdir '$runs'" EXIT
}

if [ ! -e "$runs" ]; then rm -f "$runs"; fi  # a link left by a call that was killed
of_tier=()
if [ "${1:-}" = long ]; then
  of_tier=(clang-tidy mypy debootstrap dpkg-dev file python3-pip python3-setuptools python3-wheel
    mkdocs mkdocs-material chromium chromium-driver python3-selenium
    munge slurmctld slurmd slurm-client)
fi
part "Packages" install_packages "${of_tier[@]}"
# In CI warnings are errors. By default they are not: with another flag, what the first command has
# built would be compiled again, and other compilers may warn of more.
options=()
if [ -n "${TRACKBED_WERROR:-}" ]; then options=("-DTRACKBED_WERROR=$TRACKBED_WERROR"); fi
part "Build" build "$preset" "${options[@]}"
runs_in_memory
printf '\n== Tests\n'
if [ "${1:-}" = long ]; then
  shift
  # Presets leave this tier out.
  ctest --test-dir "build/$preset" -L study --output-on-failure "$@"
else
  # One test more than cores: most short runs wait for each other or for the disk at times.
  ctest --preset "$preset" -j$(($(nproc) + 1)) "$@"
fi
