#!/bin/sh
# The commands of the package in share/trackbed/postproc, with the Python of Debian's packages.
exec "${TRACKBED_PYTHON:-/usr/bin/python3}" \
  "$(dirname "$(readlink -f "$0")")/../share/trackbed/postproc" "$@"
