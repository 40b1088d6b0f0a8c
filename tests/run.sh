#!/usr/bin/env bash
# The second command: installs what is missing (Debian 12), builds everything and runs the tests.
#   tests/run.sh [PRESET] [long] [ctest option...]   PRESET: release (default), debug or sanitize
# e.g. `tests/run.sh sanitize -L unit`, `tests/run.sh release -R style`. `long`: the tests that the
# other call leaves out, with the wall time of each.
source "$(dirname "${BASH_SOURCE[0]}")/../jobs/common.sh"

preset=release
case "${1:-}" in
  release | debug | sanitize)
    preset=$1
    shift
    ;;
esac

part "Packages" install_packages
part "Build" build "$preset" -DTRACKBED_WERROR=ON
printf '\n== Tests\n'
if [ "${1:-}" = long ]; then
  shift
  # Presets leave this tier out.
  exec ctest --test-dir "build/$preset" -L study --output-on-failure "$@"
fi
ctest --preset "$preset" -j2 "$@"
