// The profile below a wheel is evaluated only at the end of each step. Measured on the deck plain
// at 50 m/s, against steps a tenth as long: with 10 steps per length of waves and joints the force
// has an error of 1 to 5 %, with 5 steps up to 20 %, and with one step a wave has no effect.
#include "model/track_rules/coarse_steps.hpp"

#include <fmt/format.h>

#include "model/track_rules/strike.hpp"

namespace trackbed::model {

namespace {

using Kind = track::IrregularityKind;

// Steps that are needed to resolve a length.
constexpr double enough = 10, same_step = 1e-9;

struct Length {
  std::string key;
  double size;  // m
};

// Profiles that no wheel passes are reported elsewhere.
void add_profile(const track::IrregularityParameters& p, const std::string& section,
                 const Range& range, std::vector<Length>& to) {
  if (p.kind == Kind::spectrum) to.push_back({section + ".shortest", p.shortest});
  const bool waves = p.kind == Kind::waves;
  if (!waves && p.kind != Kind::versine && p.kind != Kind::vee && p.kind != Kind::joint) return;
  const double begin = waves ? p.at : p.at - p.length / 2;
  const double end = begin + p.length * (waves ? static_cast<double>(p.waves) : 1);
  if (end > range.from && begin < range.to) to.push_back({section + ".length", p.length});
}

std::vector<Length> lengths_of(const TrackModel& model) {
  std::vector<Length> lengths;
  std::optional<Range> range = range_of_wheels(model);
  if (!range || model.passage.loaded_by != track::LoadedBy::train) return lengths;
  range->from = std::max(range->from, 0.0),
  range->to = std::min(range->to, model.line.track.length);
  add_profile(model.irregularity, "irregularity", *range, lengths);
  add_profile(model.irregularity_right, "irregularity_right", *range, lengths);
  const track::WheelRailParameters& flat = model.wheel_rail;
  const std::optional<track::Train> train = train_of(model);
  const auto axle = static_cast<std::size_t>(flat.flat_axle);
  if (train && axle > 0 && axle <= train->wheels().size() && train->wheels()[axle - 1].unknown >= 0)
    lengths.push_back({"wheel_rail.flat_length", flat.flat_length});
  return lengths;
}

// Forces on a track whose step is limited by the ground; otherwise rules of the deck check them.
void add_forces(const TrackModel& model, double step, std::vector<CoarseStep>& to) {
  constexpr double needed = 8;  // steps
  for (std::size_t i = 0; i < model.passage.forces.size(); ++i) {
    const track::RailForce& force = model.passage.forces[i];
    const bool impact = force.kind == track::ForceKind::impact;
    if (force.duration() >= needed * step * (1 - same_step)) continue;
    to.push_back({fmt::format("force[{}].{}", i, impact ? "length" : "frequency"),
                  impact ? force.length : force.frequency,
                  fmt::format("gives {} of {:.3g} s: steps of {:.4g} s resolve {} poorly (fewer "
                              "than {:g} steps); give a shorter passage.step",
                              impact ? "an impact" : "periods", force.duration(), step,
                              impact ? "it" : "them", needed)});
  }
}

}  // namespace

std::vector<CoarseStep> coarse_steps(const TrackModel& model, double step) {
  std::vector<CoarseStep> found;
  if (model.on_ground) add_forces(model, step, found);
  if (model.train.vehicles.empty()) return found;
  const track::TrackParameters& track = model.line.track;
  const double element = track.least_spacing() / static_cast<double>(track.elements);
  const double travel = largest_speed(model.train) * step;
  if (travel > element * (1 + same_step))
    found.push_back({"passage.step", step,
                     fmt::format("lets wheels travel {:.3g} m in a step, more than an element of "
                                 "the rail ({:g} m); give a shorter step",
                                 travel, element)});
  for (const Length& length : lengths_of(model))
    if (length.size < enough * travel * (1 - same_step))
      found.push_back(
          {length.key, length.size,
           fmt::format("is only {:.2g} times the travel of wheels in a step ({:.3g} m at {:g} m/s "
                       "in {:.4g} s) and therefore resolved poorly: at least {:g} times are "
                       "needed; give a shorter passage.step",
                       length.size / travel, travel, largest_speed(model.train), step, enough)});
  return found;
}

void declare_coarse_steps(const TrackModel& model, double step, input::Section& s) {
  for (const CoarseStep& one : coarse_steps(model, step))
    s.rule(one.key, false, one.words,
           {.severity = input::Severity::warning,
            .reads = {"passage", "train", "vehicle", "track", "irregularity", "irregularity_right",
                      "wheel_rail"}});
}

std::vector<std::string> warnings_of_step(const TrackModel& model, double step,
                                          double history_interval) {
  std::vector<CoarseStep> found = coarse_steps(model, step);
  if (history_interval > 0 && history_interval < step)
    found.push_back(
        {"output.history_interval", history_interval,
         fmt::format("is less than a time step of {:.4g} s: a row is then written after every step",
                     step)});
  std::vector<std::string> warnings;
  for (const CoarseStep& one : found)
    warnings.push_back(fmt::format("{} = {:.4g}: {}", one.key, one.value, one.words));
  return warnings;
}

}  // namespace trackbed::model
