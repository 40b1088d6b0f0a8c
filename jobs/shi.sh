#!/usr/bin/env bash
# The full transition zone (17 m, 27 sleepers) with and without its wedge; takes long, see the head
# of inputs/shi/transition.toml. Needs what jobs/quickstart.sh installs. RANKS=N sets the ranks.
# Existing results are kept and end the script; `jobs/shi.sh --force` replaces them.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

deck=inputs/shi/transition.toml
results=results/shi
part "Build" build release trackbed
part "Run with wedge" run_model $deck $results/wedge "$@"
# The bed is built and bedded in on a ground at rest, so the variant can start from the same bed.
start=$(still_checkpoint $deck $results/wedge)
part "Run without wedge" run_model $deck $results/no_wedge "$@" \
  ground.block.wedge.present=false ground.block.wedge_surface.present=false \
  "start='$start'"
part "Figures" draw compare $results/wedge $results/no_wedge -o $results/figures

printf '\nDone in %d s. Figures:\n' $SECONDS
printf '  %s\n' "$PWD"/$results/figures/*.png
