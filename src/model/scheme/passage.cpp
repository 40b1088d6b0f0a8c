#include "model/scheme/passage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "model/scheme/track_ends.hpp"
#include "model/track_rules/track_rules.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/core/whole_steps.hpp"
#include "trackbed/model/effective.hpp"

namespace trackbed::model {

namespace {

using Json = nlohmann::ordered_json;

// The last step may go a little beyond the duration.
std::int64_t steps_of(const TrackModel& model, const BuiltTrack& built) {
  return steps_covering(built.passage.duration(), model.passage.step);
}

// Describes the lowest position of a rail, m.
std::string words_of_lowest(double lowest) {
  const std::string far = fmt::format("{:.4f} mm", std::abs(1e3 * lowest));
  return lowest > 0 && far != "0.0000 mm" ? "lowest position " + far + " above its unloaded level"
                                          : "lowest position " + far + " below its unloaded level";
}

// Prints the results of a finished run; wheel forces only if a wheel was on the track.
void print_results(const par::Comm& comm, const TrackModel& model, const BuiltTrack& built,
                   const WheelExtremes& wheels, const std::vector<double>& lowest) {
  const std::size_t sides = built.line.sides();
  const bool by_train = model.passage.loaded_by == track::LoadedBy::train;
  for (std::size_t i = 0; by_train && i < lowest.size(); ++i)
    say(comm, fmt::format("  {}rail at {:g} m: {}",
                          sides == 1   ? ""
                          : i % 2 == 0 ? "left "
                                       : "right ",
                          model.passage.points[i / sides], words_of_lowest(lowest[i])));
  if (!wheels.any) return;
  const Range open = between_run_ins(model.line.track);
  say(comm, fmt::format("  wheel forces: {:.2f}{} to {:.2f} kN{}", wheels.least / 1e3,
                        wheels.least > 0 ? "" : " (off the rail)", wheels.most / 1e3,
                        open.from > 0 ? fmt::format(", between the run-ins ({:g} to {:g} m)",
                                                    open.from, open.to)
                                      : ""));
}

// Hash of the whole motion, to compare runs bitwise.
std::string state_hash(const track::Passage& passage) {
  std::uint64_t hash = 0;
  for (const track::Newmark* motion : {&passage.line_motion(), &passage.train_motion()})
    for (const track::Vector* values :
         {&motion->displacement, &motion->velocity, &motion->acceleration})
      hash = mix(hash + hash_bytes(values->data(),
                                   sizeof(double) * static_cast<std::size_t>(values->size())));
  return fmt::format("{:016x}", hash);
}

// Of the profile itself, and of its spectrum if it was drawn from one.
void put_d1(Json& json, const std::string& section, const track::IrregularityParameters& given,
            const track::Irregularity& profile) {
  json[section + "_d1_rms_m"] = profile.d1_rms();
  if (given.kind == track::IrregularityKind::spectrum)
    json[section + "_spectrum_d1_rms_m"] = profile.spectrum_d1_rms();
}

// Names are those of summary.json of other runs where the meaning is the same; a window is a step.
Json figures(const TrackModel& model, const BuiltTrack& built, const WheelExtremes& wheels,
             const std::vector<double>& lowest) {
  const track::Passage& passage = built.passage;
  const auto steps = static_cast<double>(std::max<std::int64_t>(passage.steps(), 1));
  Json json{{"unknowns", built.line.system().mass.rows()},
            {"sleepers", built.line.sleepers()},
            {"wheels", built.train.wheels().size()},
            {"steps", passage.steps()},
            {"iterations_mean", static_cast<double>(passage.iterations()) / steps},
            {"wheel_rail_constant", built.law.constant()},
            {"wheel_steps_off_rail", passage.lost()},
            {"rail_lowest_m", lowest},
            {"state_hash", state_hash(passage)}};
  if (wheels.any) json["wheel_force_max_n"] = wheels.most, json["wheel_force_min_n"] = wheels.least;
  if (model.irregularity.kind != track::IrregularityKind::none)
    put_d1(json, "irregularity", model.irregularity, built.irregularity);
  if (built.right) put_d1(json, "irregularity_right", model.irregularity_right, *built.right);
  return json;
}

}  // namespace

PassageScheme::PassageScheme(RunContext& run)
    : run_(run),
      whole_(run.comm, run.model),
      built_(whole_.track, whole_.line),
      sensors_(run.comm, run.model.sensors, run.model.dem.gravity),
      histories_(built_.line, built_.train,
                 {.points = whole_.track.passage.points,
                  .forces = whole_.track.passage.forces.size(),
                  .sensors = run.model.sensors}) {
  if (whole_.below) {
    whole_.below->time_with(run.timers);
    sensors_.locate(whole_.below->ground());
  }
  say(run.comm, fmt::format("trackbed: {} on {}{}", run.name, ranks_in_words(run.comm),
                            run.comm.size() == 1 ? ""
                            : whole_.below       ? "; the ground is distributed over them"
                                                 : ", each of which computes the whole track"));
  for (const std::string& warning : introduce(run.comm, run.model, whole_, built_))
    run.course.warnings.push_back(warning);
}

Clock PassageScheme::clock() const {
  return Clock(whole_.track.passage.step, steps_of(whole_.track, built_));
}

bool PassageScheme::begin_stage() {
  run_.course.clock = clock();
  run_.course.steps = {.window = clock().dt(), .substeps = 1, .limit = ""};
  sample();
  record_step();
  return true;
}

void PassageScheme::advance() {
  if (whole_.below) {
    whole_.below->advance(built_.passage);
  } else {
    const auto timing = run_.timers.scope(Phase::track);
    built_.passage.advance();
  }
  run_.course.tick();
}

std::string PassageScheme::problem() { return whole_.below ? whole_.below->trouble() : ""; }

// Rows are counted in steps from the start: a resumed run has them at the same steps.
void PassageScheme::record() {
  {
    const auto timing = run_.timers.scope(Phase::observe);
    record_step();
    const std::int64_t between = run_.windows_in(run_.model.output.history_interval);
    if (run_.course.clock.window() % between == 0) sample();
  }
  if (run_.model.output.fields && run_.ends(run_.model.output.fields_interval)) write_fields();
}

void PassageScheme::sample() {
  std::vector<observe::SensorReading> readings;
  if (!sensors_.empty()) readings = sensors_.read(nullptr, &whole_.below->ground());
  histories_.sample(built_.passage, energies(), readings);
}

// A track alone has the modelled rails only.
observe::PassageEnergies PassageScheme::energies() const {
  if (whole_.below) return whole_.below->energies(built_.passage);
  return {.track = built_.passage.track_energy()};
}

void PassageScheme::write_fields() {
  const auto timing = run_.timers.scope(Phase::output);
  observe::write_fields(run_.comm,
                        run_.field_files(fmt::format("{}_{:06d}", stage(), built_.passage.steps()),
                                         run_.model.output.fields_parts),
                        built_.passage, built_.train, shape_of_track(run_.model),
                        whole_.below ? &whole_.below->ground() : nullptr);
}

// In every step, so that extremes do not depend on the interval of the histories. Wheels on the
// rigid rails before and behind the track, and in the run-ins, are left out.
void PassageScheme::record_step() {
  const Range open = between_run_ins(whole_.track.line.track);
  for (std::size_t i = 0; i < built_.train.wheels().size(); ++i)
    if (const double x = built_.passage.wheel_x(i); x >= open.from && x <= open.to)
      wheels_.add(built_.passage.wheel_force(i));
  histories_.update_extremes(built_.passage);
}

Status PassageScheme::status() {
  if (built_.train.wheels().empty()) return {};
  const double force = built_.passage.wheel_force(0), x = built_.passage.wheel_x(0);
  return {.words = fmt::format("first wheel at {:.2f} m, {}", x,
                               force > 0 ? fmt::format("{:.2f} kN", force / 1e3) : "off the rail"),
          .figures = {{"first_wheel_x_m", x}, {"first_wheel_force_n", force}}};
}

void PassageScheme::end_stage() {
  if (run_.model.output.fields) write_fields();
  const auto timing = run_.timers.scope(Phase::output);
  flush();
  print_results(run_.comm, whole_.track, built_, wheels_, histories_.lowest());
}

// All rows: they are few, and are stored in the checkpoint as well.
void PassageScheme::flush() {
  histories_.write(
      run_.comm, run_.folder + "/results.h5",
      {.deck = effective_deck(run_.model), .version = version(), .build = build_description()},
      run_.model.output.compress);
}

std::string PassageScheme::rescue() noexcept {
  try {
    flush();
  } catch (const std::exception&) {  // for example a full disk; the first error is reported
  }
  return {};
}

std::vector<std::string> PassageScheme::warnings_at_end() {
  return warnings_of_passage(whole_.track, built_, wheels_, histories_.lowest());
}

void PassageScheme::summarize(Json& summary) {
  summary["track"] = figures(whole_.track, built_, wheels_, histories_.lowest());
  const observe::PassageEnergies energies = this->energies();
  summary["energy"] = {{"track_j", energies.track}};
  if (!whole_.below) return;
  summary["ground"] = whole_.below->figures();
  summary["coupling"] = whole_.below->balance();
  summary["energy"]["given_to_ground_j"] = energies.given_to_ground;
  summary["energy"]["ground_kinetic_j"] = energies.ground.kinetic;
  summary["energy"]["ground_elastic_j"] = energies.ground.elastic;
}

// The duration may have changed.
void PassageScheme::archive(io::Archive& a) {
  a.part("train", built_.passage);
  if (whole_.below) whole_.below->archive(a);
  histories_.archive(a);
  a.part("run/wheels", wheels_);
  if (!a.reads()) return;
  run_.course.clock = clock();
  run_.course.clock.set(0, built_.passage.steps());
}

// Measured on some steps from the start, where most wheels may still be on rigid rails: their cost
// is the same. The first step, in which solvers are set up, does not count.
void check_track(const par::Comm& comm, const Model& model) {
  TrackAssembly whole(comm, model);
  BuiltTrack built(whole.track, whole.line);
  introduce(comm, model, whole, built);
  constexpr int most_tried = 50;
  constexpr double longest = 2;  // s of wall time; only large grounds take as long
  const std::int64_t steps = steps_of(whole.track, built);
  const auto advance = [&] {
    if (whole.below)
      whole.below->advance(built.passage);
    else
      built.passage.advance();
  };
  advance();
  const auto begin = std::chrono::steady_clock::now();
  int tried = 0;
  double taken = 0;
  while (tried < most_tried && taken < longest) {
    advance();
    ++tried;
    taken =
        comm.max(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  const double each = taken / tried;
  say(comm, fmt::format("  passage: {:.4g} s in {} steps, about {:.0f} s of wall time",
                        built.passage.duration(), steps, each * static_cast<double>(steps)));
}

}  // namespace trackbed::model
