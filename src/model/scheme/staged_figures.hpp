// Figures of a run in stages, for summary.json; names and units are fixed.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "model/coupling/wheel_extremes.hpp"
#include "model/scene/world.hpp"
#include "trackbed/core/timers.hpp"
#include "trackbed/model/course.hpp"

namespace trackbed::model {

// Counters at the time from which speeds are measured.
struct SpeedCounters {
  std::string stage;
  double dem_seconds = 0, neighbour_seconds = 0, cpu_seconds = 0;  // on this rank
  std::int64_t dem_steps = 0;
  double ground_seconds = 0;
  std::int64_t ground_steps = 0;
};
// Local.
SpeedCounters measure_from(const std::string& stage, const Timers& timers, const World& world);
// Collective.
StageRecord record_of(const Stage& stage, const Course& course, const World& world);

// References: valid only while the figures are computed.
struct FigureInput {
  const World& world;
  const Course& course;
  const Timers& timers;
  const SpeedCounters& measured;
  const WheelExtremes& wheels;
};

// The speed figures of `dem` and `ground` are those of the last stage alone, without the
// preparation of the bed. Collective.
void put_figures(const FigureInput& run, nlohmann::ordered_json& summary);

}  // namespace trackbed::model
