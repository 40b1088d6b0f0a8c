#!/usr/bin/env bash
# Installs missing packages (Debian 12), builds, runs a vehicle over a transition zone with and
# without its wedge on two ranks, draws the figures and a film. Replaces earlier results.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

deck=inputs/quickstart.toml
results=results/quickstart
part "Packages" install_packages
part "Build" build release trackbed
part "Run of the cell of ballast" run_model inputs/quickstart_cell.toml $results/cell --force
part "Run with wedge" run_model $deck $results/wedge --force
# The bed is built and bedded in on a ground at rest, so the variant can start from the same bed.
start=$(still_checkpoint $deck $results/wedge)
part "Run without wedge" run_model $deck $results/no_wedge --force \
  ground.block.wedge.present=false ground.block.wedge_surface.present=false \
  "start='$start'"
part "Figures" draw compare $results/wedge $results/no_wedge --kind transition \
  -o $results/figures
part "Film" draw film $results/wedge $results/no_wedge -o $results/figures/film.gif

printf '\nDone in %d s. Figures and film:\n' $SECONDS
printf '  %s\n' "$PWD"/$results/figures/{model,transition}.png "$PWD/$results/figures/film.gif"
echo "Table: $PWD/$results/figures/transition.txt"
echo "Results: $PWD/$results/{wedge,no_wedge}/results.h5; for ParaView: fields/"
