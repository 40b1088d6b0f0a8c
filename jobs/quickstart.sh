#!/usr/bin/env bash
# Installs missing packages (Debian 12), builds, runs a short transition zone with and without its
# wedge on two ranks and draws the figures. Replaces earlier results.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

deck=inputs/quickstart.toml
results=results/quickstart
part "Packages" install_packages
part "Build" build release trackbed
part "Run with wedge" run_model $deck $results/wedge --force
# The bed is built and bedded in on a ground at rest, so the variant can start from the same bed.
start=$(still_checkpoint $deck $results/wedge)
part "Run without wedge" run_model $deck $results/no_wedge --force \
  ground.block.wedge.present=false ground.block.wedge_surface.present=false \
  "start='$start'"
part "Figures" figures $results/wedge $results/no_wedge -o $results/figures

printf '\nDone in %d s. Figures:\n' $SECONDS
printf '  %s\n' "$PWD"/$results/figures/*.png
echo "Table: $PWD/$results/figures/table.txt"
echo "Results: $PWD/$results/{wedge,no_wedge}/results.h5; fields for ParaView in fields/ there"
