// summary.json: the figures of a run, a contract with whoever reads them.
#pragma once

#include <string>

#include "app/course.hpp"
#include "app/progress.hpp"
#include "app/wheel_extremes.hpp"
#include "app/world.hpp"
#include "trackbed/core/timers.hpp"

namespace trackbed::app {

// Where the speed figures begin to count. Local.
Measured measure_from(const std::string& stage, const Timers& timers, const World& world);
// Collective.
StageRecord record_of(const Stage& stage, const Course& course, const Model& model,
                      const World& world);

// References: for the moment of writing only.
struct SummaryOf {
  const std::string& deck;
  const std::string& folder;
  const World& world;
  const Course& course;
  const std::vector<observe::Region>& regions;
  const Timers& timers;
  const Measured& measured;
  const std::vector<std::string>& said;  // warnings before the run began
  const WheelExtremes& wheels;
  double wall_time;  // s
  bool finished;
};

// Writes folder/summary.json. The speed figures of `dem` and `ground` are those of the last stage
// alone, so that preparation does not blur them. Collective; throws RunError.
void write_summary(const SummaryOf& run);

}  // namespace trackbed::app
