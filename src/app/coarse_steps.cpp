// A wheel meets a profile only where it stands at the end of a step. Measured on the deck plain at
// 50 m/s, against steps a tenth as long: the force over waves and joints is off by 1 to 5 % with 10
// steps to their length, by up to 20 % with 5, and with one a wave is not there at all.
#include "app/coarse_steps.hpp"

#include <fmt/format.h>

#include "app/strike.hpp"

namespace trackbed::app {

namespace {

using Kind = track::IrregularityKind;

// Steps that a length must take to be seen.
constexpr double enough = 10, rounding = 1e-9;

struct Length {
  std::string key;
  double size;  // m
};

// What no wheel meets is told elsewhere.
void add_profile(const track::IrregularityParameters& p, const std::string& section, const Way& way,
                 std::vector<Length>& to) {
  if (p.kind == Kind::spectrum) to.push_back({section + ".shortest", p.shortest});
  const bool waves = p.kind == Kind::waves;
  if (!waves && p.kind != Kind::versine && p.kind != Kind::vee && p.kind != Kind::joint) return;
  const double begin = waves ? p.at : p.at - p.length / 2;
  const double end = begin + p.length * (waves ? static_cast<double>(p.waves) : 1);
  if (end > way.from && begin < way.to) to.push_back({section + ".length", p.length});
}

std::vector<Length> lengths_of(const TrackModel& model) {
  std::vector<Length> lengths;
  std::optional<Way> way = way_of_wheels(model);
  if (!way || model.passage.loaded_by != track::LoadedBy::train) return lengths;
  way->from = std::max(way->from, 0.0), way->to = std::min(way->to, model.line.track.length);
  add_profile(model.irregularity, "irregularity", *way, lengths);
  add_profile(model.irregularity_right, "irregularity_right", *way, lengths);
  const track::WheelRailParameters& flat = model.wheel_rail;
  const std::optional<track::Train> train = train_of(model);
  const auto axle = static_cast<std::size_t>(flat.flat_axle);
  if (train && axle > 0 && axle <= train->wheels().size() && train->wheels()[axle - 1].unknown >= 0)
    lengths.push_back({"wheel_rail.flat_length", flat.flat_length});
  return lengths;
}

// Forces of their own time on a track whose ground says the step; elsewhere rules of the deck.
void add_forces(const TrackModel& model, double step, std::vector<CoarseStep>& to) {
  constexpr double seen = 8;  // steps
  for (std::size_t i = 0; i < model.passage.forces.size(); ++i) {
    const track::RailForce& force = model.passage.forces[i];
    const bool impact = force.kind == track::ForceKind::impact;
    if (force.lasts() >= seen * step * (1 - rounding)) continue;
    to.push_back({fmt::format("force[{}].{}", i, impact ? "length" : "frequency"),
                  impact ? force.length : force.frequency,
                  fmt::format("makes {} of {:.3g} s, in steps of {:.4g} s: they hardly see it",
                              impact ? "an impact" : "periods", force.lasts(), step)});
  }
}

}  // namespace

std::vector<CoarseStep> coarse_steps(const TrackModel& model, double step) {
  std::vector<CoarseStep> found;
  if (model.on_ground) add_forces(model, step, found);
  if (model.train.vehicles.empty()) return found;
  const track::TrackParameters& track = model.line.track;
  const double element = track.spacing / static_cast<double>(track.elements);
  const double way = largest_speed(model.train) * step;
  if (way > element * (1 + rounding))
    found.push_back({"passage.step", step,
                     fmt::format("lets wheels go {:.3g} m in a step, further than an element of "
                                 "the rail ({:g} m)",
                                 way, element)});
  for (const Length& length : lengths_of(model))
    if (length.size < enough * way * (1 - rounding))
      found.push_back(
          {length.key, length.size,
           fmt::format("is {:.2g} times what wheels go in a step, which is {:.3g} m at "
                       "{:g} m/s in {:.4g} s: steps hardly see what is not {:g} times "
                       "as long (passage.step)",
                       length.size / way, way, largest_speed(model.train), step, enough)});
  return found;
}

void declare_coarse_steps(const TrackModel& model, double step, input::Section& s) {
  for (const CoarseStep& one : coarse_steps(model, step))
    s.rule(one.key, false, one.words,
           {.weight = input::Weight::warning,
            .reads = {"passage", "train", "vehicle", "track", "irregularity", "irregularity_right",
                      "wheel_rail"}});
}

std::vector<std::string> doubts_of_step(const TrackModel& model, double step) {
  std::vector<CoarseStep> found = coarse_steps(model, step);
  if (const double interval = model.passage.history_interval; interval < step)
    found.push_back(
        {"passage.history_interval", interval,
         fmt::format("is less than a time step of {:.4g} s; every step makes a row", step)});
  std::vector<std::string> doubts;
  for (const CoarseStep& one : found)
    doubts.push_back(fmt::format("{} = {:.4g}: {}", one.key, one.value, one.words));
  return doubts;
}

}  // namespace trackbed::app
