// A short run of the train of the deck on its track: it begins far enough before the place for the
// transient from the start on a slope to decay, and ends soon behind it. Costs some hundred
// steps. Rejected: P1 of dipped joints, 2 alpha v sqrt(k m) with the masses of wheel and rail in
// series (Jenkins and others 1974): 3 to 8 times the force of a run for a V of 0.1 m, at whose
// bottom the wheel loses contact.
#include "model/track_rules/strike.hpp"

#include <algorithm>

#include "trackbed/core/error.hpp"

namespace trackbed::model {

namespace {

constexpr double lead = 50e-3;    // s, before the place: two periods of a wheel on the track
constexpr double behind = 10e-3;  // s, behind the place: half a period of wheel and rail
constexpr double near = 1e-3;     // s, before the place: rows of a jump begin there

// The first wheel that rolls on this side, or none.
std::optional<std::size_t> first_wheel(const track::Train& train, std::size_t side) {
  for (std::size_t i = 0; i < train.wheels().size(); ++i)
    if (train.wheels()[i].unknown >= 0 && train.wheels()[i].side == side) return i;
  return {};
}

double largest_force(track::Passage& passage, std::size_t wheel, double from, double to) {
  double most = 0;
  while (passage.wheel_x(wheel) < to) {
    passage.advance();
    if (passage.wheel_x(wheel) >= from) most = std::max(most, passage.wheel_force(wheel));
  }
  return most;
}

}  // namespace

double largest_speed(const track::TrainParameters& train) {
  double speed = train.speed;
  for (const double later : train.speeds) speed = std::max(speed, later);
  return speed;
}

double step_of_strikes(const TrackModel& model) {
  constexpr double shortest = 20e-6;  // s: finer ones would take long
  return std::max(model.passage.step, shortest);
}

std::optional<double> strike_at(const TrackModel& model, const Profiles& profiles, std::size_t side,
                                double x) {
  track::TrainParameters motion = model.train;
  motion.speed = largest_speed(model.train);
  if (!(motion.speed > 0)) return {};
  motion.times = {}, motion.speeds = {};
  track::PassageParameters run = model.passage;
  run.forces = {}, run.loaded_by = track::LoadedBy::train;
  run.step = step_of_strikes(model);
  try {
    const track::Line line(model.line);
    const track::TrackParameters& track = model.line.track;
    const track::Train train(motion, model.vehicles, track.rails, track.wheel_gauge());
    const std::optional<std::size_t> wheel = first_wheel(train, side);
    if (!wheel) return {};
    motion.start = x - motion.speed * lead + train.wheels()[*wheel].behind;
    track::Passage passage(line, train, track::WheelRail(model.wheel_rail), profiles.left, motion,
                           run, profiles.right);
    return largest_force(passage, *wheel, x - motion.speed * near, x + motion.speed * behind);
  } catch (const InputError&) {
    return {};
  } catch (const RunError&) {
    return {};
  }
}

}  // namespace trackbed::model
