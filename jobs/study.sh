#!/usr/bin/env bash
# Repeats a published study and compares it with the publication, target by target.
#   jobs/study.sh NAME [short|full] [FOLDER]
# NAME: netirail, shi, demfem, chen, crossing. short (default): at most 10 minutes on two cores
# (chen: 30), fails if the sign of a main target is wrong; full: everything that docs/studies/NAME
# shows, see there for the time.
# Results, numbers.csv, figures and a document (README.md) go to FOLDER (default
# results/studies/NAME/FORM, below the project's folder). Finished runs there are kept and a stopped
# one is resumed, so that the same command continues a study. Needs what jobs/quickstart.sh needs.
# RANKS=N sets the ranks; runs of fewer ranks take place side by side.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

name=${1:-} form=${2:-short}
if [ ! -f "jobs/studies/${name}_document.py" ] || [[ " short full " != *" $form "* ]]; then
  echo "usage: jobs/study.sh NAME [short|full] [FOLDER]; NAME: netirail, shi, demfem, chen, \
crossing" >&2
  exit 2
fi
build release trackbed
PYTHONDONTWRITEBYTECODE=1 "$python" jobs/study.py build/release/trackbed "$name" "$form" \
  "${3:-results/studies/$name/$form}"
