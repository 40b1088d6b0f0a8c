// Where a run is: everything besides the parts of the model that a run needs to go on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/limits.hpp"
#include "trackbed/core/clock.hpp"

namespace trackbed::app {

// Whether a stage that ends early once its aim is reached did so, or its time was over first.
enum class Aim { none, missed, reached };

// What a finished stage left behind, for summary.json.
// Numbers as double, so that a record is a row of a dataset.
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
  double platen_pressure = -1;  // Pa, averaged; below 0: the stage does not press
  double settlement = -1;       // m, largest of a sleeper in the last cycle; below 0: no cycles
};

// Small, and the same on all ranks. What of it the deck does not give is in the checkpoint.
struct Course {
  std::size_t stage = 0;     // number in the deck
  bool begun = false;        // the stage is under way: its `begin` is done
  Clock clock{1, 0};         // of the stage
  Steps steps;               // of the stage
  std::int64_t windows = 0;  // of the whole run
  std::vector<StageRecord> done;
  std::vector<std::string> warnings;  // of the whole run, a sentence each
};

}  // namespace trackbed::app
