// The state of a run in a checkpoint: each module writes its own group; coupling state, averages,
// clock and finished stages are written here (groups coupling and run).
//
// Stored is the state that cannot be computed from the deck. Not stored are neighbour lists,
// matrices of the ground, and walls: they are built again and are bitwise identical. Nothing
// depends on the number of ranks: datasets are global, so a run can be resumed with another number.
// The layout is described in docs/checkpoint.md.
#include "trackbed/io/checkpoint.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>

#include "app/deck/deck_files.hpp"
#include "app/deck/deck_values.hpp"
#include "app/parameters/version.hpp"
#include "app/restart/compatible.hpp"
#include "app/run/result_folder.hpp"
#include "app/run/simulation.hpp"
#include "app/run/summary.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::app {

namespace {

// Records are rows of numbers, and their names a text attribute with one line each: a table of
// mixed types would need a compound type, which few readers support.
constexpr std::size_t record_columns = 10;

// Integers as numbers: all counts here are far below 2^53.
std::vector<double> pack(const std::vector<StageRecord>& records) {
  std::vector<double> rows;
  for (const StageRecord& r : records)
    rows.insert(rows.end(),
                {r.time, r.duration, r.window, r.substeps, r.particles, r.bulk_density, r.wall_time,
                 static_cast<double>(r.aim), r.platen_pressure, r.settlement});
  return rows;
}

// Inverse of `pack`. Stops at the shorter of names and rows.
std::vector<StageRecord> unpack(const std::string& names, const std::vector<double>& rows) {
  std::vector<StageRecord> records;
  std::istringstream words(names);
  std::string name;
  for (std::size_t i = 0; std::getline(words, name) && i + record_columns <= rows.size();
       i += record_columns)
    records.push_back({name, rows[i], rows[i + 1], rows[i + 2], rows[i + 3], rows[i + 4],
                       rows[i + 5], rows[i + 6], static_cast<Aim>(static_cast<int>(rows[i + 7])),
                       rows[i + 8], rows[i + 9]});
  return records;
}

std::string joined_names(const std::vector<StageRecord>& records) {
  std::string names;
  for (const StageRecord& record : records) names += record.name + "\n";
  return names;
}

// As characters in a dataset, since attributes of HDF5 are limited to 64 kB. Rank 0 supplies them.
// Collective.
void save_warnings(const par::Comm& comm, io::File& file, const std::vector<std::string>& all) {
  std::vector<std::uint8_t> letters;
  for (const std::string& sentence : all) {
    letters.insert(letters.end(), sentence.begin(), sentence.end());
    letters.push_back('\n');
  }
  file.write<std::uint8_t>("run/warnings",
                           std::span(letters).first(comm.root() ? letters.size() : 0), 1,
                           {"-", "warnings of the run, UTF-8, each with a line feed"});
}

// Collective.
std::vector<std::string> load_warnings(const io::File& file) {
  std::vector<std::string> all;
  const auto letters = file.read_all<std::uint8_t>("run/warnings");
  std::istringstream lines(std::string(letters.begin(), letters.end()));
  for (std::string line; std::getline(lines, line);) all.push_back(line);
  return all;
}

// Vectors per node as rows; rank 0 holds all of them, the argument of other ranks is ignored.
// Collective.
void write_nodes(const par::Comm& comm, io::File& file, const std::string& path,
                 const std::vector<Vec3>& all, const io::Label& label) {
  const double* first = all.empty() ? nullptr : all[0].data();
  file.write<double>(path, std::span(first, comm.root() ? 3 * all.size() : 0), 3, label);
}

// Every rank reads all nodes, since surfaces are replicated. Collective.
std::vector<Vec3> read_nodes(const io::File& file, const std::string& path) {
  const std::vector<double> values = file.read_all<double>(path);
  std::vector<Vec3> nodes(values.size() / 3);
  for (std::size_t n = 0; n < nodes.size(); ++n)
    nodes[n] = Vec3(values[3 * n], values[3 * n + 1], values[3 * n + 2]);
  return nodes;
}

// Each rank contributes the values of its own nodes and zero elsewhere, so the sum is exact. Ghost
// nodes of the argument hold copies and are left out, or a node would be counted once per rank that
// has it. Cost: one reduction over all top nodes; checkpoints are rare. Collective.
std::vector<Vec3> gathered(const par::Comm& comm, const fem::Ground& ground,
                           const std::vector<Vec3>& values) {
  std::vector<Vec3> all(values.size(), Vec3::Zero());
  for (const std::int32_t own : ground.own_top())
    all[static_cast<std::size_t>(own)] = values[static_cast<std::size_t>(own)];
  if (!all.empty()) comm.sum(std::span<double>(all[0].data(), 3 * all.size()));
  return all;
}

// Walls are built again from their height and displacement; ground, sleepers and platen store their
// own shape. The mean forces are state: they move the bodies in the next window. Collective.
void save_surfaces(World& world, io::File& file) {
  const par::Comm& comm = world.comm;
  world.walls.save(file, "run", comm);
  if (world.ground) {
    const Surface& top = world.ground->top();
    write_nodes(comm, file, "run/support", gathered(comm, *world.ground, world.support),
                {"N", "averaged load of the bed on the ground's top nodes"});
    write_nodes(comm, file, "run/top_position", gathered(comm, *world.ground, top.position),
                {"m", "ground's top nodes at the start of the last window"});
    write_nodes(comm, file, "run/top_motion", gathered(comm, *world.ground, top.motion),
                {"m", "their displacement in it"});
  }
  for (const World::Means& means : world.means())
    write_nodes(comm, file, "coupling/" + means.surface, means.force,
                {"N", "mean force of stones on the nodes in the last window"});
}

// Surfaces are registered first, since the coupler needs them before it can take their forces.
void load_surfaces(World& world, const io::File& file) {
  world.walls.load(file, "run");
  if (world.ground && file.has("run/support")) {
    world.support = read_nodes(file, "run/support");
    Surface& top = world.ground->top();
    top.position = read_nodes(file, "run/top_position");
    top.motion = read_nodes(file, "run/top_motion");
  }
  world.register_surfaces();
  // A model of placed stones without plates and boxes has no surface and no such group.
  if (!file.has("coupling")) return;
  std::vector<World::Means> means;
  for (const std::string& surface : file.names("coupling"))
    means.push_back({surface, read_nodes(file, "coupling/" + surface)});
  world.set_means(means);
}

}  // namespace

// "results/mine/", "results/mine" and "results/mine/stage_fill.h5" mean the same folder. The
// checkpoint itself need not exist.
std::string folder_of_checkpoint(const std::string& checkpoint) {
  namespace fs = std::filesystem;
  fs::path folder(checkpoint);
  if (!folder.has_filename()) folder = folder.parent_path();
  if (!fs::is_directory(folder)) folder = folder.parent_path();
  return folder.empty() ? "." : folder.string();
}

// Histories are written first: a checkpoint must not count rows that are not in the file yet. Its
// name is written to `latest` once the file is complete.
void Simulation::checkpoint(const std::string& name) {
  const auto timing = timers_.scope(Verb::output);
  results_.flush();
  io::write_checkpoint(comm_, folder_, name, [&](io::File& file) { save(file); });
  last_checkpoint_ = folder_ + "/" + name;
}

// Parts that do not exist yet are not written, and `load` leaves them in their initial state.
// Collective, as is everything that it calls.
void Simulation::save(io::File& file) {
  file.attribute("/", "version", version());
  // The whole input with its defaults: `resume` needs no deck, and later versions with other
  // defaults continue the run as this one would.
  file.attribute("/", "deck", effective_deck(model_));
  if (!files_.empty()) file.attribute("/", "files", files_);
  file.attribute("/", "deck_name", name_);
  file.attribute("/", "stage", stage().name);
  file.attribute("/", "stage_finished", static_cast<std::int64_t>(!course_.begun));
  file.attribute("/", "stages_done", joined_names(course_.done));
  file.attribute("/", "time", course_.clock.time());
  file.attribute("/", "particles", world_.particles.totals().particles);
  // The course is the same on all ranks; rank 0 supplies the rows, the others empty ones.
  const bool root = comm_.root();
  const Clock& clock = course_.clock;
  const std::vector<double> times{clock.start(), clock.dt()};
  file.write<double>("run/clock", std::span(times).first(root ? times.size() : 0), 1,
                     {"s", "start of the stage, length of a window"});
  // Read by position in `load` and `resume`: new entries go to the end.
  const std::vector<std::int64_t> counts{static_cast<std::int64_t>(course_.stage),
                                         clock.window(),
                                         clock.windows(),
                                         course_.steps.substeps,
                                         course_.windows,
                                         results_.rows(),
                                         world_.ground_settled ? 1 : 0};
  file.write<std::int64_t>("run/counts", std::span(counts).first(root ? counts.size() : 0), 1,
                           {"-",
                            "stage, window of the stage, windows of the stage, sub-steps, "
                            "windows of the run, history rows, ground in static equilibrium"});
  const couple::Balance& b = world_.coupler.balance();
  const std::vector<double> balance{b.force, b.moment, b.impulse, b.work};
  file.write<double>("run/balance", std::span(balance).first(root ? 4 : 0), 1,
                     {"-", "largest relative imbalance of force, moment, impulse, work"});
  const std::vector<double> records = root ? pack(course_.done) : std::vector<double>{};
  file.write<double>("run/stages", records, record_columns,
                     {"SI",
                      "finished stages: time, duration, window, sub-steps, particles, bulk "
                      "density, wall time, aim (0 none, 1 missed, 2 reached), mean pressure of "
                      "the platen (below 0: none), settlement in the last cycle (below 0: none)"});
  save_warnings(comm_, file, course_.warnings);
  world_.particles.save(file, "particles");
  if (world_.sleepers && world_.sleepers->placed()) world_.sleepers->save(file, "sleepers", comm_);
  if (world_.ground && world_.ground_settled) world_.ground->save(file, "ground");
  if (world_.platen) world_.platen->save(file, "platen", comm_);
  if (world_.tines) world_.tines->save(file, "tines", comm_);
  if (world_.placement) world_.placement->save(file);
  actions_.save(file);
  save_surfaces(world_, file);
}

// In the order of dependence: the course states whether the ground has moved, then the modules load
// their bodies, and surfaces are registered last, when all of them are at their stored positions.
void Simulation::load(const io::File& file) {
  const auto times = file.read_all<double>("run/clock");
  const auto counts = file.read_all<std::int64_t>("run/counts");
  const auto balance = file.read_all<double>("run/balance");
  course_.stage = static_cast<std::size_t>(counts.at(0));
  course_.begun = file.integer_attribute("/", "stage_finished") == 0;
  course_.clock = Clock(times.at(1), counts.at(2));
  course_.clock.set(times.at(0), counts.at(1));
  course_.steps = {.window = times.at(1), .substeps = static_cast<int>(counts.at(3)), .limit = ""};
  course_.windows = counts.at(4);
  course_.done =
      unpack(file.text_attribute("/", "stages_done"), file.read_all<double>("run/stages"));
  course_.warnings = load_warnings(file);
  world_.ground_settled = counts.at(6) != 0;
  world_.coupler.set_balance({balance.at(0), balance.at(1), balance.at(2), balance.at(3)});
  world_.particles.load(file, "particles");
  if (world_.sleepers && file.has("sleepers")) world_.sleepers->load(file, "sleepers");
  if (world_.ground && world_.ground_settled) world_.ground->load(file, "ground");
  if (file.has("platen")) {
    world_.platen.emplace(model_.platen, model_.container(), model_.material(model_.wall_material));
    if (course_.begun)
      world_.platen->set_target(model_.pressure_in(stage()), stage().kind == StageKind::shear);
    world_.platen->load(file, "platen");
  }
  if (file.has("tines")) {
    world_.tines.emplace(world_.make_tines());
    world_.tines->load(file, "tines");
    world_.tines->show_at_rest(static_cast<double>(course_.clock.window()) * course_.clock.dt());
  }
  if (world_.placement) {
    world_.placement->load(file);
    world_.placement->update(course_.clock.time(), 0);
  }
  if (course_.begun) actions_.load(file, course_.steps.window);
  actions_.load_done(file);
  load_surfaces(world_, file);
  if (world_.platen) world_.platen->set_area(world_.walls.area());
}

// Histories are continued in the file beside the checkpoint, or begin again if it does not exist.
// Partly written files of a killed run are removed: they are as large as the finished files.
// The steps of the present stage are those of the checkpoint and are not chosen again: limits may
// have changed with the stones, and an uninterrupted run would not have chosen new ones either.
void Simulation::resume(const std::string& checkpoint) {
  remove_parts(comm_, folder_);
  const io::File file = io::open_checkpoint(comm_, checkpoint);
  load(file);
  last_checkpoint_ = checkpoint;
  // The deck in the results is that of the whole run; changes of it are reported here.
  const std::string effective = effective_deck(model_);
  const Values then =
      with_moved_files(comm_, file, values_of(file.text_attribute("/", "deck")), effective);
  for (const std::string& change : changes(then, values_of(effective)))
    warn(fmt::format("from {:.6g} s on, where the run was resumed: {}", course_.clock.time(),
                     change));
  std::vector<std::string> finished;
  for (const StageRecord& record : course_.done) finished.push_back(record.name);
  const auto rows = file.read_all<std::int64_t>("run/counts").at(5);
  results_.resume(folder_of_checkpoint(checkpoint) + "/results.h5", rows, finished);
  // The checkpoint was written at the end of a stage: the run continues with the next one.
  if (!course_.begun) {
    ++course_.stage;
    return;
  }
  resume_extremes(file.has("ground/extremes/element"));
  // Settings of `begin` that are not part of the stored state.
  world_.particles.set_local_damping(stage().local_damping);
  world_.particles.set_friction(stage().friction);
  // The seat forces of the window before the checkpoint, as in an uninterrupted run: the next
  // history row contains them until the sleepers move again.
  const double mid_window =
      (static_cast<double>(course_.clock.window()) - 0.5) * course_.clock.dt();
  seat_force_ =
      world_.solids ? world_.solids->seat_forces() : actions_.seat_forces(stage(), mid_window);
  measured_ = measure_from(stage().name, timers_, world_);
}

// This is another run than the one that wrote the file: windows count from 0, and results begin
// again. The simulated time continues, so that histories of both runs can be joined.
void Simulation::start_from(const std::string& checkpoint) {
  const io::File file = io::open_checkpoint(comm_, checkpoint);
  load(file);
  course_.windows = 0;
  course_.stage = stage_after(file, checkpoint, model_, deck_);
  started_from_ = checkpoint;
}

}  // namespace trackbed::app
