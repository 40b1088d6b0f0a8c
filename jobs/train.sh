#!/usr/bin/env bash
# A passenger vehicle at 160 km/h over a transition zone on stones: wheel forces and settlement
# under each axle in one figure. By default the 6 m of inputs/shi/short.toml (7 minutes on two busy
# cores); with `full` the 17 m of inputs/track/transition_train.toml (an hour and a half).
# Needs what jobs/quickstart.sh installs. RANKS=N sets the ranks. Existing results are
# kept and end the script; `--force` as the last argument replaces them.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

size=short
if [ "${1:-}" = full ]; then size=full && shift; fi
results=results/train/$size
part "Build" build release trackbed
if [ $size = full ]; then
  part "Run" run_model inputs/track/transition_train.toml "$results" "$@"
else
  part "Run" run_model inputs/shi/short.toml "$results" "$@" stage.passage.train=true \
    train.start=0 train.speed=44.4 seat.before=16 track.length=24 track.sleeper_mass=400
fi
draw figures "$results" --kind train -o "$results/figures"

printf '\nDone in %d s. Figure: %s\n' $SECONDS "$PWD/$results/figures/train.png"
