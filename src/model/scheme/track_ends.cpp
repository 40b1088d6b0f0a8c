// The bounds are not part of the model: beyond them the assumptions of rolling wheels, elastic
// contact and small deflections do not hold. They are wide: flats and dips lift wheels for a short
// time, and impacts of ten times the static load occur in reasonable decks.
#include "model/scheme/track_ends.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trackbed/track/motion.hpp"

namespace trackbed::model {

namespace {

constexpr double often_off = 0.1;     // of the steps that wheels are on the track
constexpr double off_by_flats = 0.5;  // the same with a flat, which may lift its wheel at each turn
constexpr double far_above = 100;     // static wheel loads
constexpr double far_down = 0.1;      // m, of a rail on a bed
constexpr double far_of_span = 0.01;  // of the span of a beam that is supported only at its ends

// Steps of all rolling wheels on the track; Passage::lost counts those off the rail in the same
// way.
double steps_on_track(const TrackModel& model, const BuiltTrack& built) {
  const track::Motion motion(model.train);
  const double now = built.passage.time();
  double time = 0;
  for (const track::Train::Wheel& wheel : built.train.wheels())
    if (wheel.unknown >= 0)
      time += std::min(now, motion.time_at(built.line.length() + wheel.behind)) -
              std::min(now, motion.time_at(wheel.behind));
  return time / model.passage.step;
}

// N, mean static load of the wheels that roll; 0: there are none.
double mean_load(const BuiltTrack& built) {
  const auto& wheels = built.train.wheels();
  const auto rolling = std::count_if(wheels.begin(), wheels.end(),
                                     [](const auto& wheel) { return wheel.unknown >= 0; });
  return rolling > 0 ? std::abs(built.train.weight().sum()) / static_cast<double>(rolling) : 0;
}

}  // namespace

std::vector<std::string> warnings_of_passage(const TrackModel& model, const BuiltTrack& built,
                                             const WheelExtremes& wheels,
                                             const std::vector<double>& lowest) {
  std::vector<std::string> warnings;
  const double on = steps_on_track(model, built), off = static_cast<double>(built.passage.lost());
  const double most_off = model.wheel_rail.flat_axle > 0 ? off_by_flats : often_off;
  if (off > most_off * on)
    warnings.push_back(
        fmt::format("wheels were off the rail in {:.0f} % of their time steps on the track (limit "
                    "{:.0f} %): check irregularity, track and speed",
                    100 * off / on, 100 * most_off));
  if (const double load = mean_load(built); load > 0 && wheels.most > far_above * load)
    warnings.push_back(
        fmt::format("the largest wheel force is {:.3g} kN, {:.3g} times the static load (limit "
                    "{:g} times): the contact is assumed to be elastic, but steel would yield; "
                    "check irregularity, speed and passage.step",
                    wheels.most / 1e3, wheels.most / load, far_above));
  const bool beam = model.line.track.support == track::Support::none;
  const double bound = beam ? far_of_span * built.line.length() : far_down;
  const auto worst = std::min_element(lowest.begin(), lowest.end());
  if (worst != lowest.end() && -*worst > bound && std::isfinite(*worst))
    warnings.push_back(fmt::format(
        "the rail at {:g} m has deflected by {:.4g} m: the model assumes small deflections, here "
        "up to about {:.3g} m; check the stiffness of rail and support",
        model.passage.points[static_cast<std::size_t>(worst - lowest.begin()) / built.line.sides()],
        -*worst, bound));
  return warnings;
}

}  // namespace trackbed::model
