#!/usr/bin/env bash
# The first command: installs what is missing (Debian 12), builds, runs a short transition zone with
# and without its wedge on two ranks and draws the figures. Replaces the results of the last time.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

deck=inputs/quickstart.toml
results=results/quickstart
part "Packages" install_packages
part "Build" build release trackbed
part "Run with wedge" run_model $deck $results/wedge --force
# The bed is made and bedded in on a still ground, so it is the same bed: the variant begins there.
start=$(still_checkpoint $deck $results/wedge)
part "Run without wedge" run_model $deck $results/no_wedge --force \
  ground.block.wedge.present=false ground.block.wedge_surface.present=false \
  "start='$start'"
part "Figures" figures $results/wedge $results/no_wedge -o $results/figures

printf '\nDone in %d s. Figures:\n' $SECONDS
printf '  %s\n' "$PWD"/$results/figures/*.png
echo "Table: $PWD/$results/figures/table.txt"
echo "Results: $PWD/$results/{wedge,no_wedge}/results.h5; fields for ParaView in fields/ there"
