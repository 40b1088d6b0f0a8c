// Progress of a run, whatever its scheme.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/core/clock.hpp"
#include "trackbed/io/archive.hpp"

namespace trackbed::model {

// A window is `substeps` sub-steps of equal length, each at most the stable one.
struct Steps {
  double window = 0;  // s
  int substeps = 1;
  std::string limit;  // description of what limits them
};

// Whether a stage with an aim ended early because it reached it, or ran out of time.
enum class Aim { none, missed, reached };

// Figures of a finished stage, for summary.json.
struct StageRecord {
  std::string name;
  double time = 0;      // s of simulated time at its end
  double duration = 0;  // s of simulated time
  double window = 0;    // s
  double substeps = 0;
  double particles = 0;
  double bulk_density = 0;  // kg/m^3: mass over footprint times twice the mean height of the stones
  double wall_time = 0;     // s
  double aim = 0;           // an Aim
  double platen_pressure = -1;  // Pa, averaged; below 0: the platen does not load the bed
  double settlement = -1;       // m, largest of a sleeper in the last cycle; below 0: no cycles
  // s, longest sub-step up to that of the stage that the contacts at its end allow; 0: no stones
  double stable_step = 0;

  double step() const { return window / substeps; }  // s
  void set(Aim reached) { aim = static_cast<double>(reached); }
  bool has(Aim one) const { return aim == static_cast<double>(one); }
};

// Small, and the same on all ranks but for wall times; stored in checkpoints.
struct Course {
  std::size_t stage = 0;     // number in the deck
  bool begun = false;        // the stage has begun: its `begin` is done
  Clock clock{1, 0};         // of the stage
  Steps steps;               // of the stage
  std::int64_t windows = 0;  // of the whole run
  std::vector<StageRecord> done;
  std::vector<std::string> warnings;  // of the whole run, a sentence each
  double earlier_wall_time = 0;       // s, of the parts of the run before the last resume

  void tick() { clock.tick(), ++windows; }
  void archive(io::Archive& a);
};

// The course stored in a checkpoint. Collective.
Course course_in(const io::File& checkpoint);

}  // namespace trackbed::model
