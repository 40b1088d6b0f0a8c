// Log lines and warnings on a track before it runs.
#include "model/coupling/track_built.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "model/coupling/train_words.hpp"
#include "model/track_rules/coarse_steps.hpp"
#include "model/track_rules/profile_warnings.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/model/log.hpp"

namespace trackbed::model {

namespace {

// km/h, each with the time at which it is reached.
std::string words_of_speed(const track::TrainParameters& train) {
  std::string text = fmt::format("{:.2f} km/h", train.speed * 3.6);
  for (std::size_t i = 0; i < train.times.size(); ++i)
    text += fmt::format(", at {:g} s {:.2f} km/h", train.times[i], train.speeds[i] * 3.6);
  return text;
}

// The value of the profile, and of its spectrum if it was drawn from one: profiles of a short track
// scatter.
std::string words_of_d1(const char* section, const track::IrregularityParameters& given,
                        const track::Irregularity& profile) {
  std::string text =
      fmt::format("  {}: root mean square of D1 (wavelengths of 3 to 25 m) {:.4f} mm", section,
                  1e3 * profile.d1_rms());
  if (given.kind == track::IrregularityKind::spectrum)
    text += fmt::format("; that of the given spectrum {:.4f} mm", 1e3 * profile.spectrum_d1_rms());
  return text;
}

void introduce_track(const par::Comm& comm, const TrackModel& model, const BuiltTrack& built) {
  const track::Beam rail = track::beam_of(model.line.rail);
  const std::string shear = rail.shear_stiffness > 0
                                ? fmt::format("k G A {:.5g} N", rail.shear_stiffness)
                                : "rigid in shear";
  say(comm, fmt::format("  rail: E I {:.5g} N m2, {}, {:.5g} kg/m", rail.bending_stiffness, shear,
                        rail.mass));
  say(comm, fmt::format("  track: {:g} m, {} rail{}, {} sleepers, {} unknowns", built.line.length(),
                        built.line.sides(), built.line.sides() > 1 ? "s" : "",
                        built.line.sleepers(), built.line.system().mass.rows()));
  if (built.line.sleepers_bend())
    say(comm, fmt::format(
                  "  bending sleepers: first natural frequency of a free slender sleeper {:.1f} Hz",
                  track::bending_frequency(model.line.track)));
  for (const std::string& line : lines_of_vehicles(built.train, built.line.sides() > 1))
    say(comm, line);
  if (!built.train.wheels().empty())
    say(comm,
        fmt::format("  train: {} vehicle{}, {} axles, {}; largest static wheel load {:.2f} kN",
                    built.train.vehicles().size(),
                    plural_ending(static_cast<std::int64_t>(built.train.vehicles().size())),
                    built.train.wheels().size() / built.line.sides(), words_of_speed(model.train),
                    built.train.largest_static_load() / 1e3));
  if (model.passage.loaded_by == track::LoadedBy::seats) {
    say(comm,
        fmt::format("  seat loads for {:.4g} s, without pads and rail", built.passage.duration()));
    return;
  }
  const bool hertz = model.wheel_rail.law == track::WheelRailLaw::hertz;
  say(comm, fmt::format("  wheel and rail: {} {:.5g} {}", hertz ? "constant C =" : "stiffness",
                        built.law.constant(), hertz ? "N/m^1.5" : "N/m"));
  if (model.irregularity.kind != track::IrregularityKind::none)
    say(comm, words_of_d1("irregularity", model.irregularity, built.irregularity));
  if (built.right)
    say(comm, words_of_d1("irregularity_right", model.irregularity_right, *built.right));
}

// Warnings of seat loads whose table begins or ends with a jump.
std::vector<std::string> warnings_of_seats(const TrackModel& model, const BuiltTrack& built) {
  std::vector<std::string> warnings;
  if (const std::optional<track::SeatLoad> seats = seats_of(model)) {
    const std::size_t last = built.line.sleepers() - 1;
    for (const std::string& jump : seats->jumps(built.line.sleeper_x(0), built.line.sleeper_x(last),
                                                built.passage.duration()))
      warnings.push_back(fmt::format("load.file: {}: {}", model.load.file, jump));
  }
  return warnings;
}

}  // namespace

TrackAssembly::TrackAssembly(const par::Comm& comm, const Model& model)
    : track(model.track), line(model.track.line) {
  line.pads = track.passage.loaded_by == track::LoadedBy::train;
  if (model.kind != ModelKind::track_on_ground) return;
  below.emplace(comm, model);
  line = line_on_ground(model);
  track.passage.step = below->step();
}

std::vector<std::string> introduce(const par::Comm& comm, const Model& model,
                                   const TrackAssembly& whole, const BuiltTrack& built) {
  if (!(built.passage.duration() > 0))
    throw InputError({fmt::format(
        "passage.duration: seat loads would last {:.4g} s, but their duration must be above 0 s: "
        "axles start beyond the track (load.start), or the rows of the table end before 0 s",
        built.passage.duration())});
  introduce_track(comm, whole.track, built);
  std::vector<std::string> warnings =
      warnings_of_profiles(whole.track, {built.irregularity, built.right});
  const std::vector<std::string> of_seats = warnings_of_seats(whole.track, built);
  warnings.insert(warnings.end(), of_seats.begin(), of_seats.end());
  if (whole.below)
    for (const std::string& warning :
         warnings_of_step(whole.track, whole.below->step(), model.output.history_interval))
      warnings.push_back(warning);
  for (const std::string& warning : warnings) say(comm, "warning: " + warning);
  if (!whole.below) return warnings;
  const nlohmann::ordered_json of = whole.below->figures();
  say(comm, fmt::format("  ground: {} elements, {} unknowns, below sleepers at {:g} to {:g} m",
                        of["elements"].get<std::int64_t>(), of["unknowns"].get<std::int64_t>(),
                        built.line.sleeper_x(built.line.first_moved()),
                        built.line.sleeper_x(built.line.first_moved() + built.line.moved() - 1)));
  if (model.ground.integrator != fem::Integrator::explicit_)
    say(comm, fmt::format("  step: {:.4g} s (passage.step), implicit ground: two solves of the "
                          "ground in each step, and {} solves before the first step",
                          whole.track.passage.step, whole.below->footprints()));
  if (whole.track.passage.step < model.track.passage.step)
    say(comm, fmt::format("  step: {:.4g} s, limited by {}", whole.track.passage.step,
                          whole.below->limit()));
  return warnings;
}

}  // namespace trackbed::model
