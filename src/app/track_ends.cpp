// Bounds here are no physics of their own: beyond them nothing that was meant is left of wheels
// that roll, of contact that stays elastic or of small deflections. They are wide: flats and dips
// lift wheels for a short time, and blows of ten times the load are computed of sound decks.
#include "app/track_ends.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trackbed/track/motion.hpp"

namespace trackbed::app {

namespace {

constexpr double often_off = 0.1;     // of the steps that wheels stand on the track
constexpr double off_by_flats = 0.5;  // a flat may lift its wheel at each turn
constexpr double far_above = 100;     // static loads
constexpr double far_down = 0.1;      // m, of a rail on a bed
constexpr double far_of_span = 0.01;  // of the span of a beam that is held at its ends alone

// Steps of all rolling wheels on the track, as Passage::lost counts those off the rail.
double steps_on_track(const TrackModel& model, const Built& built) {
  const track::Motion motion(model.train);
  const double now = built.passage.time();
  double time = 0;
  for (const track::Train::Wheel& wheel : built.train.wheels())
    if (wheel.unknown >= 0)
      time += std::min(now, motion.time_at(built.line.length() + wheel.behind)) -
              std::min(now, motion.time_at(wheel.behind));
  return time / model.passage.step;
}

// N, of a wheel that rolls, in the mean of them; 0: there is none.
double mean_load(const Built& built) {
  const auto& wheels = built.train.wheels();
  const auto rolling = std::count_if(wheels.begin(), wheels.end(),
                                     [](const auto& wheel) { return wheel.unknown >= 0; });
  return rolling > 0 ? std::abs(built.train.weight().sum()) / static_cast<double>(rolling) : 0;
}

}  // namespace

std::vector<std::string> doubts_of_passage(const TrackModel& model, const Built& built,
                                           const WheelExtremes& wheels,
                                           const std::vector<double>& lowest) {
  std::vector<std::string> doubts;
  const double on = steps_on_track(model, built), off = static_cast<double>(built.passage.lost());
  const bool flat = model.wheel_rail.flat_axle > 0;
  if (off > (flat ? off_by_flats : often_off) * on)
    doubts.push_back(
        fmt::format("wheels were off the rail in {:.0f} % of their steps on the track: can they be "
                    "meant to follow this profile, or this track, at such a speed?",
                    100 * off / on));
  if (const double load = mean_load(built); load > 0 && wheels.most > far_above * load)
    doubts.push_back(
        fmt::format("a wheel pressed the rail with {:.3g} kN, {:.3g} times what wheels carry at "
                    "rest: steel would not stay elastic, as it does here",
                    wheels.most / 1e3, wheels.most / load));
  const bool beam = model.line.track.support == track::Support::none;
  const double bound = beam ? far_of_span * built.line.length() : far_down;
  const auto worst = std::min_element(lowest.begin(), lowest.end());
  if (worst != lowest.end() && -*worst > bound && std::isfinite(*worst))
    doubts.push_back(fmt::format(
        "the rail at {:g} m went down by {:.4g} m: deflections are computed as small ones, here up "
        "to about {:.3g} m; are rail and support as stiff in the deck as they are meant?",
        model.passage.points[static_cast<std::size_t>(worst - lowest.begin()) / built.line.sides()],
        -*worst, bound));
  return doubts;
}

}  // namespace trackbed::app
