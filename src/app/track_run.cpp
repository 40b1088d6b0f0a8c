// A train over a track from equilibrium to the end of the passage. Every rank computes the same
// numbers from the same input; rank 0 prints and writes. More ranks bring nothing, and change
// nothing.
#include "app/track_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/commands.hpp"
#include "app/result_folder.hpp"
#include "app/version.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/observe/passage.hpp"

namespace trackbed::app {

namespace {

using Json = nlohmann::ordered_json;
using Watch = std::chrono::steady_clock;
constexpr double seconds_between_lines = 5;

void say(const par::Comm& comm, const std::string& line) {
  if (!comm.root()) return;
  std::fputs((line + "\n").c_str(), stdout);
  std::fflush(stdout);
}

double seconds_since(Watch::time_point begin) {
  return std::chrono::duration<double>(Watch::now() - begin).count();
}

// The model built from its parameters. Members stand in the order they need each other: the passage
// keeps references to line and train.
struct Built {
  explicit Built(const TrackModel& m)
      : line(m.line),
        train(m.train, m.vehicles, m.line.track.rails),
        law(m.wheel_rail),
        irregularity(m.irregularity, m.line.track.length),
        passage(line, train, law, irregularity, m.train, m.passage) {}
  track::Line line;
  track::Train train;
  track::WheelRail law;
  track::Irregularity irregularity;
  track::Passage passage;
};

// Frequencies show at once whether a mass or a spring was meant per side, per axle or in all.
std::string words_of(const track::VehicleParameters& vehicle) {
  std::string text = fmt::format("  vehicle {}:", vehicle.name);
  if (vehicle.kind == track::VehicleKind::forces)
    return text + fmt::format(" {} axles of constant force", vehicle.axles.size());
  const std::vector<double> frequencies = track::natural_frequencies(vehicle);
  if (!frequencies.empty())
    text += fmt::format(" natural frequencies {:.4g} Hz, wheelsets held;",
                        fmt::join(frequencies, ", "));
  return text + fmt::format(" wheelset {:g} kg", vehicle.wheelset_mass);
}

// What a user checks first: is this the model that was meant?
void introduce(const par::Comm& comm, const TrackModel& model, const Built& built) {
  const track::Beam rail = track::beam_of(model.line.rail);
  say(comm, fmt::format("  rail: E I {:.5g} N m2, k G A {:.5g} N{}, {:.5g} kg/m",
                        rail.bending_stiffness, rail.shear_stiffness,
                        rail.shear_stiffness > 0 ? "" : " (rigid in shear)", rail.mass));
  say(comm, fmt::format("  track: {:g} m, {} sleepers, {} unknowns", built.line.length(),
                        built.line.sleepers(), built.line.system().mass.rows()));
  std::vector<std::string> said;
  for (const track::VehicleParameters& vehicle : built.train.vehicles()) {
    if (std::find(said.begin(), said.end(), vehicle.name) != said.end()) continue;
    said.push_back(vehicle.name);
    say(comm, words_of(vehicle));
  }
  say(comm,
      fmt::format("  train: {} vehicles, {} axles, {:.2f} km/h; first wheel {:.2f} kN at rest",
                  built.train.vehicles().size(), built.train.wheels().size(),
                  model.train.speed * 3.6, built.passage.wheel_force(0) / 1e3));
  const bool hertz = model.wheel_rail.law == track::WheelRailLaw::hertz;
  say(comm, fmt::format("  wheel and rail: {} {:.5g} {}", hertz ? "C_H" : "stiffness",
                        built.law.constant(), hertz ? "N/m^1.5" : "N/m"));
  if (model.irregularity.kind == track::IrregularityKind::spectrum)
    say(comm, fmt::format("  irregularity: D1 (3 to 25 m) root mean square {:.4f} mm; of the whole "
                          "spectrum {:.4f} mm",
                          1e3 * built.irregularity.d1_rms(),
                          1e3 * track::rms_of(model.irregularity.spectrum, 3, 25)));
}

// Whole steps: the last one may go a little beyond the duration.
std::int64_t steps_of(const TrackModel& model, const Built& built) {
  return static_cast<std::int64_t>(std::ceil(built.passage.duration() / model.passage.step - 1e-9));
}

// Largest and least force of any wheel while it is on the track, N.
struct Extremes {
  double most = 0, least = 0;
  bool any = false;
  void see(const track::Passage& passage, const Built& built) {
    for (std::size_t i = 0; i < built.train.wheels().size(); ++i) {
      const double x = passage.wheel_x(i), force = passage.wheel_force(i);
      if (x < 0 || x > built.line.length()) continue;
      most = any ? std::max(most, force) : force;
      least = any ? std::min(least, force) : force;
      any = true;
    }
  }
};

// All that moves, to tell whether two runs did the same to the last bit.
std::string state_hash(const track::Passage& passage) {
  std::uint64_t hash = 0;
  for (const track::Newmark* motion : {&passage.line_motion(), &passage.train_motion()})
    for (const track::Vector* values :
         {&motion->displacement, &motion->velocity, &motion->acceleration})
      hash = mix(hash + hash_bytes(values->data(),
                                   sizeof(double) * static_cast<std::size_t>(values->size())));
  return fmt::format("{:016x}", hash);
}

// Names as in summary.json of other runs where they mean the same; a window is a step.
Json figures(const TrackModel& model, const Built& built, const Extremes& wheels,
             const std::vector<double>& lowest) {
  const track::Passage& passage = built.passage;
  const auto steps = static_cast<double>(std::max<std::int64_t>(passage.steps(), 1));
  Json json{{"unknowns", built.line.system().mass.rows()},
            {"sleepers", built.line.sleepers()},
            {"wheels", built.train.wheels().size()},
            {"steps", passage.steps()},
            {"iterations_mean", static_cast<double>(passage.iterations()) / steps},
            {"wheel_rail_constant", built.law.constant()},
            {"wheel_force_max_n", wheels.most},
            {"wheel_force_min_n", wheels.least},
            {"wheel_steps_off_rail", passage.lost()},
            {"rail_lowest_m", lowest},
            {"state_hash", state_hash(passage)}};
  if (model.irregularity.kind == track::IrregularityKind::spectrum)
    json["irregularity_d1_rms_m"] = built.irregularity.d1_rms();
  return json;
}

// Steps, with a row of the histories when one is due and a line for those who wait.
Extremes pass(const par::Comm& comm, const TrackModel& model, Built& built,
              observe::PassageHistories& histories) {
  Extremes wheels;
  const std::int64_t steps = steps_of(model, built);
  const auto every =
      std::max<std::int64_t>(1, std::llround(model.passage.history_interval / model.passage.step));
  const Watch::time_point begin = Watch::now();
  double said = 0;
  histories.sample(built.passage);
  for (std::int64_t i = 1; i <= steps; ++i) {
    built.passage.advance();
    wheels.see(built.passage, built);
    if (i % every == 0) histories.sample(built.passage);
    const double wall = seconds_since(begin);
    if (!comm.root() || wall < said + seconds_between_lines) continue;
    said = wall;
    const double left = wall * static_cast<double>(steps - i) / static_cast<double>(i);
    say(comm, fmt::format("  {:>8.4f} s | left {:.0f} s | first wheel at {:.2f} m, {:.2f} kN",
                          built.passage.time(), left, built.passage.wheel_x(0),
                          built.passage.wheel_force(0) / 1e3));
  }
  return wheels;
}

}  // namespace

// Read again when the model is built: they are small.
void require_files(const TrackModel& model) {
  if (model.irregularity.kind == track::IrregularityKind::file)
    track::Irregularity(model.irregularity, model.line.track.length);
}

// Histories and summary come at the end: a run that is killed has left nothing, and is repeated.
void run_track(const par::Comm& comm, const TrackModel& model, const TrackRunOf& run) {
  const Watch::time_point begin = Watch::now();
  say(comm, fmt::format("trackbed: {} on {} rank{}", run.deck, comm.size(),
                        comm.size() > 1 ? "s, each of which computes the whole track" : ""));
  Built built(model);
  introduce(comm, model, built);
  observe::PassageHistories histories(built.line, built.train, model.passage.points);
  const Watch::time_point moving = Watch::now();
  const Extremes wheels = pass(comm, model, built, histories);
  const double stepping = seconds_since(moving);
  histories.write(comm, run.folder + "/results.h5", {.deck = run.effective, .version = version()});
  const double wall = comm.max(seconds_since(begin));
  const std::vector<double> lowest = histories.lowest();
  Json json{{"deck", run.deck},
            {"model", "track"},
            {"finished", true},
            {"ranks", comm.size()},
            {"simulated_time_s", built.passage.time()},
            {"wall_time_s", wall},
            {"windows", built.passage.steps()}};
  json["track"] = figures(model, built, wheels, lowest);
  json["share"] = {{"track", comm.max(stepping) / wall}, {"other", 1 - comm.max(stepping) / wall}};
  json["energy"] = {{"track_j", built.passage.line_motion().energy()}};
  json["warnings"] = Json::array();
  write_summary_file(comm, run.folder, json.dump(2));
  for (std::size_t i = 0; i < lowest.size(); ++i)
    say(comm, fmt::format("  rail at {:g} m: down to {:.4f} mm", model.passage.points[i],
                          -1e3 * lowest[i]));
  say(comm, fmt::format("  wheels: {:.2f} to {:.2f} kN; {} steps of {:g} s, {:.2f} s of wall time "
                        "for {:.4g} s",
                        wheels.least / 1e3, wheels.most / 1e3, built.passage.steps(),
                        model.passage.step, wall, built.passage.time()));
  say(comm, "results: " + run.folder);
}

// Some steps from the begin, where most wheels may still be on rigid rails: they cost the same.
void check_track(const par::Comm& comm, const TrackModel& model) {
  Built built(model);
  introduce(comm, model, built);
  constexpr int tried = 50;
  const std::int64_t steps = steps_of(model, built);
  const Watch::time_point begin = Watch::now();
  for (int i = 0; i < tried; ++i) built.passage.advance();
  const double each = seconds_since(begin) / tried;
  say(comm, fmt::format("  passage: {:.4g} s in {} steps, about {:.0f} s of wall time",
                        built.passage.duration(), steps, each * static_cast<double>(steps)));
}

// Rank 0 looks; the summary says what kind of run it was. A file that is no summary says nothing.
void refuse_to_resume_track(const par::Comm& comm, const std::string& path) {
  namespace fs = std::filesystem;
  std::string found;
  if (comm.root()) {
    const fs::path folder = fs::is_directory(path) ? fs::path(path) : fs::path(path).parent_path();
    std::stringstream text;
    text << std::ifstream(folder / "summary.json").rdbuf();
    const Json summary = Json::parse(text.str(), nullptr, false);
    if (summary.is_object() && summary.value("model", "") == "track") found = folder.string();
  }
  found = comm.broadcast(found);
  if (!found.empty())
    throw InputError({found + ": holds a run of a track alone; these are not resumed, since they "
                              "take seconds: run the deck again"});
}

}  // namespace trackbed::app
