#!/usr/bin/env bash
# Runs the decks whose pictures docs/gallery.md shows, and draws them.
#   jobs/gallery.sh DIR [PICTURES]   PICTURES: where the pictures go; default DIR/pictures
# Needs what jobs/quickstart.sh installs. RANKS=N sets the ranks. Existing results are replaced.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

results=${1:?give a folder for the results: jobs/gallery.sh DIR [PICTURES]}
pictures=${2:-$results/pictures}
mkdir -p "$pictures"

# The newest field file of a part: names begin with the stage, in no order of time.
last_field() {
  ls -t "$1"/fields/*_"$2".hdf | sed -n 1p
}
still() {
  local picture=$1 folder=$2 field=$3
  shift 3
  draw still "$(last_field "$folder" "$field")" -o "$pictures/$picture.png" "$@"
}

build release trackbed
run_model inputs/bed/repose.toml "$results/heap" --force output.fields=true
still heap "$results/heap" stones --view corner --array radius

# 50,000 stones as they are placed; their fall is not computed.
run_model inputs/bench/stones12.toml "$results/many" --force 'bed.x=[0,2.4]' 'bed.y=[-1.2,1.2]' \
  bed.height=0.424 output.fields=true stage.fill.duration=1e-4 stage.settle.duration=1e-4 \
  stage.rest.duration=1e-4
still many "$results/many" stones --view corner --array radius

run_model inputs/demfem/solids.toml "$results/solids" --force output.fields=true
still solids "$results/solids" solids --view corner --array displacement

run_model inputs/ground/strip.toml "$results/strip" --force
still strip "$results/strip" ground --view corner --array displacement

run_model inputs/ground/embankment.toml "$results/embankment" --force
draw still "$results/embankment" --parts ground,stones --view corner --array displacement \
  -o "$pictures/embankment.png"

run_model inputs/track/netirail_plain.toml "$results/plain" --force
draw figures "$results/plain" -o "$results/plain/figures"
cp "$results/plain/figures/track.png" "$pictures/track.png"
