// Progress of a run: all state besides the parts of the model that a run needs to continue.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/scene/steps.hpp"
#include "trackbed/core/clock.hpp"

namespace trackbed::app {

// Whether a stage with an aim ended early because it reached it, or ran out of time.
enum class Aim { none, missed, reached };

// Figures of a finished stage, for summary.json. All are double, so that a record is a row of a
// dataset.
struct StageRecord {
  std::string name;
  double time = 0;      // s of simulated time at its end
  double duration = 0;  // s of simulated time
  double window = 0;    // s
  double substeps = 0;
  double particles = 0;
  double bulk_density = 0;  // kg/m^3: mass over footprint times twice the mean height of the stones
  double wall_time = 0;     // s
  Aim aim = Aim::none;
  double platen_pressure = -1;  // Pa, averaged; below 0: the platen does not load the bed
  double settlement = -1;       // m, largest of a sleeper in the last cycle; below 0: no cycles
};

// Small, and the same on all ranks. What does not follow from the deck is in the checkpoint.
struct Course {
  std::size_t stage = 0;     // number in the deck
  bool begun = false;        // the stage has begun: its `begin` is done
  Clock clock{1, 0};         // of the stage
  Steps steps;               // of the stage
  std::int64_t windows = 0;  // of the whole run
  std::vector<StageRecord> done;
  std::vector<std::string> warnings;  // of the whole run, a sentence each
};

}  // namespace trackbed::app
