// summary.json: the figures of a run; names and units are fixed.
#pragma once

#include <string>

#include "app/coupling/wheel_extremes.hpp"
#include "app/run/course.hpp"
#include "app/run/progress.hpp"
#include "app/scene/world.hpp"
#include "trackbed/core/timers.hpp"

namespace trackbed::app {

// Counters from which the speed figures are computed. Local.
SpeedCounters measure_from(const std::string& stage, const Timers& timers, const World& world);
// Collective.
StageRecord record_of(const Stage& stage, const Course& course, const Model& model,
                      const World& world);

// References: valid only while the summary is written.
struct SummaryInput {
  const std::string& deck;
  const std::string& folder;
  const World& world;
  const Course& course;
  const std::vector<observe::Region>& regions;
  const Timers& timers;
  const SpeedCounters& measured;
  const std::vector<std::string>& deck_warnings;  // before the run began
  const WheelExtremes& wheels;
  double wall_time;  // s
  bool finished;
};

// Writes folder/summary.json. The speed figures of `dem` and `ground` are those of the last stage
// alone, without the preparation of the bed. Collective; throws RunError.
void write_summary(const SummaryInput& run);

}  // namespace trackbed::app
