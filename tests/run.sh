#!/usr/bin/env bash
# The second command: installs what is missing (Debian 12), builds everything and runs every test.
#   tests/run.sh [PRESET] [ctest option...]      PRESET: release (default), debug or sanitize
# e.g. `tests/run.sh sanitize -L unit`, `tests/run.sh release -R style`.
source "$(dirname "${BASH_SOURCE[0]}")/../jobs/common.sh"

preset=release
case "${1:-}" in
  release | debug | sanitize)
    preset=$1
    shift
    ;;
esac

part "Packages" install_packages
part "Build" build "$preset"
printf '\n== Tests\n'
ctest --preset "$preset" -j2 "$@"
