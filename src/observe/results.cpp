// Histories are collected in memory and added to the file at a flush: the file is copied, the copy
// grows and takes the old one's name. Costs a copy per flush, which is rare (checkpoints, ends of
// stages), and spares the run a file that a kill left half written.
// HDF5 alone gives no such promise: a kill between two of its writes can leave a file that no
// reader opens, and hours of histories with it. SWMR, its answer, does not work with parallel
// files.
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "observe/room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::observe {

namespace fs = std::filesystem;

namespace {

// About 1 MB with 30 columns, so that copying the file at a flush stays rare.
// Memory is the same on all ranks; a flush in between costs nothing but the copy.
constexpr std::size_t rows_in_memory = 4000;
constexpr double same_place = 1e-6;  // m, two nodes on one line along the track

// Names and units of the histories are what postproc/ and users' scripts read.
std::vector<Column> sleeper_columns() {
  return {
      {"history/sleeper/displacement", {"m", "vertical, of the centre, from where it was placed"}},
      {"history/sleeper/velocity", {"m/s", "vertical"}},
      {"history/sleeper/acceleration", {"m/s2", "vertical, in the last window, no filter"}},
      {"history/sleeper/seat_force", {"N", "vertical load on the rail seat, up positive"}},
      {"history/sleeper/reaction", {"N", "vertical, from stones, mean of the last window"}}};
}

std::vector<Column> energy_columns() {
  return {{"history/energy/kinetic", {"J", "of the stones"}},
          {"history/energy/potential", {"J", "of the stones, zero at z = 0"}},
          {"history/energy/elastic", {"J", "of the stones' contacts"}}};
}

// Of one region; a cell has one number in each, or the six of a tensor (xx yy zz xy xz yz).
std::vector<Column> region_columns(const std::string& name) {
  const std::string group = "history/region/" + name + "/";
  return {
      {group + "porosity", {"-", "share of voids in each cell, x fastest, then y"}},
      {group + "bulk_density", {"kg/m3", "mass of stones over volume of the cell"}},
      {group + "stones", {"-", "number of stones with their centre in the cell"}},
      {group + "coordination", {"-", "mean number of partners of such a stone"}},
      {group + "contacts", {"-", "number of contacts with their middle in the cell"}},
      {group + "contact_force", {"N", "mean size of their forces"}},
      {group + "stress", {"Pa", "Love-Weber, xx yy zz xy xz yz of each cell, tension positive"}},
      {group + "fabric", {"-", "mean n n^T of the contacts' normals, components as of stress"}}};
}

}  // namespace

// One line of top nodes along the track: the front face of a slice (its lowest y), or in space the
// line nearest to the middle, y = 0. Ties go to the line met last. Ascending x, so that figures
// need no sorting.
// The same on all ranks: each holds the whole top.
std::vector<std::int32_t> watched_nodes(fem::Ground& ground, Dimension dimension) {
  const auto& nodes = ground.top().position;
  const auto distance = [&](const Vec3& x) {
    return dimension == Dimension::plane ? x.y() : std::abs(x.y());
  };
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec3& node : nodes) nearest = std::min(nearest, distance(node));
  double line = 0;
  for (const Vec3& node : nodes)
    if (distance(node) == nearest) line = node.y();
  std::vector<std::int32_t> watched;
  for (std::size_t n = 0; n < nodes.size(); ++n)
    if (std::abs(nodes[n].y() - line) < same_place) watched.push_back(static_cast<std::int32_t>(n));
  std::sort(watched.begin(), watched.end(), [&](std::int32_t a, std::int32_t b) {
    return nodes[static_cast<std::size_t>(a)].x() < nodes[static_cast<std::size_t>(b)].x();
  });
  return watched;
}

Results::Results(const par::Comm& comm, const std::string& path, const About& about)
    : room_(std::make_unique<Room>(comm, path, about)) {}
Results::~Results() = default;
Results::Results(Results&&) noexcept = default;

std::int64_t Results::rows() const { return room_->rows; }

// Collective. Places are written before the first row, so that a file without rows can be drawn,
// too.
void Results::watch(const Scene& scene, const std::vector<std::int32_t>& nodes,
                    std::span<const double> sleeper_x, const std::vector<Region>& regions) {
  Room& room = *room_;
  if (scene.stones) room.energy = energy_columns();
  room.regions = regions;
  for (const Region& region : regions)
    for (const Column& column : region_columns(region.name)) room.region.push_back(column);
  if (scene.ground) room.watch_ground(nodes, scene.particles.domain().dimension);
  // The columns above are needed in any case; the head and the places are in the file already.
  if (room.goes_on) return;
  room.begin_file();
  std::vector<double> x;
  if (scene.ground)
    for (const std::int32_t n : room.nodes)
      x.push_back(scene.ground->top().position[static_cast<std::size_t>(n)].x());
  const bool root = room.comm.root();
  room.replace([&](io::File& file) {
    if (!x.empty())
      file.write<double>("ground/x", std::span<const double>(x).first(root ? x.size() : 0), 1,
                         {"m", "top nodes at one face, along the track"});
    if (!sleeper_x.empty())
      file.write<double>("sleepers/x", sleeper_x.first(root ? sleeper_x.size() : 0), 1,
                         {"m", "centres of the sleepers, along the track"});
  });
}

// All ranks call it and hold the same rows: totals and sums are agreed, and one of them writes. A
// row is a few hundred numbers; a share per rank would cost more in order than in memory.
void Results::sample(const Scene& scene, const Instant& instant) {
  Room& room = *room_;
  room.times.push_back(instant.time);
  room.stages.push_back(instant.stage);
  if (scene.stones) room.sample_energy(scene.particles.totals());
  if (!instant.seat_force.empty()) room.sample_sleepers(scene.sleepers, instant.seat_force);
  if (scene.ground) room.sample_ground(*scene.ground);
  room.sample_walls(instant.walls);
  if (instant.platen) room.sample_platen(*instant.platen);
  if (instant.train) room.sample_train(*instant.train, instant.seat_force.size());
  if (instant.solids) room.sample_solids(*instant.solids);
  if (instant.placed) room.sample_placed(*instant.placed);
  room.sample_regions(scene.particles);
  ++room.rows;
  if (room.times.size() >= rows_in_memory) flush();
}

// Collective. After it the rows in the file are those that a checkpoint counts.
void Results::flush() {
  Room& room = *room_;
  if (room.times.empty()) return;
  room.replace([&](io::File& file) { room.append_to(file); });
}

// Makes no file: `watch` or `resume` does.
Results::Room::Room(const par::Comm& world, std::string file, About what)
    : comm(world), path(std::move(file)), about(std::move(what)) {}

// What a reader needs to know what made the file; the deck is the effective one.
void Results::Room::put_head(io::File& file) {
  file.attribute("/", "kind", std::string(results_kind));
  file.attribute("/", "version", about.version);
  file.attribute("/", "ranks", static_cast<std::int64_t>(comm.size()));
  file.attribute("/", "deck", about.deck);
  if (!about.grading.empty())
    file.write<double>(
        "bed/grading",
        std::span<const double>(about.grading).first(comm.root() ? about.grading.size() : 0), 4,
        {"m, %", "per sieve: opening; passing by mass as asked, least and most"});
}

// Replaces what is there: prepare_folder has asked before. Collective.
void Results::Room::begin_file() {
  io::File file(comm, path, io::Mode::create);
  put_head(file);
  file.close();
}

void Results::Room::take_name(const std::string& part) {
  std::error_code error;
  if (comm.root()) fs::rename(part, path, error);
  comm.agree(error ? path + ": cannot be replaced (" + error.message() + ")" : "");
}

namespace {

// Why `from` could not be copied, or nothing. On rank 0.
// The library says "Input/output error" of a full disk, but leaves the system's reason behind.
std::string copied(const std::string& from, const std::string& to) {
  std::error_code error;
  errno = 0;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (!error) return "";
  const bool known = errno == ENOSPC || errno == EDQUOT || errno == EFBIG;
  return to + ": cannot be written (" + (known ? std::strerror(errno) : error.message()) + ")";
}

}  // namespace

// The copy keeps to rank 0 and the file system; ranks open it together. The old file stays valid
// until the rename, which replaces it at one instant (POSIX). A copy that could not be finished
// goes: what fills a disk must not stay there.
void Results::Room::replace(const std::function<void(io::File&)>& change) {
  const std::string part = path + ".part";
  try {
    comm.agree(comm.root() ? copied(path, part) : "");
    io::File file(comm, part, io::Mode::append);
    change(file);
    file.close();
  } catch (const RunError&) {  // the same on all ranks
    std::error_code ignored;
    if (comm.root()) fs::remove(part, ignored);
    throw;
  }
  take_name(part);
}

// Groups that were never sampled have width 0 and no dataset. Collective.
void Results::Room::append_to(io::File& file) {
  const bool root = comm.root();  // all ranks have all rows; one writes them
  const auto own = [&](const auto& values) {
    return std::span(values).first(root ? values.size() : 0);
  };
  file.append<double>("history/time", own(times), 1, {"s", "simulated time"});
  file.append<std::int64_t>("history/stage", own(stages), 1, {"-", "number of the stage"});
  for (const auto* group : groups())
    for (const Column& column : *group)
      if (column.width > 0)
        file.append<double>(column.path, own(column.values), column.width, column.label);
  times.clear(), stages.clear();
  for (auto* group : groups())
    for (Column& column : *group) column.values.clear();
}

// In the order of energy_columns. Work against friction and dashpots is not among them.
void Results::Room::sample_energy(const dem::Totals& totals) {
  const double values[] = {totals.kinetic, totals.potential, totals.elastic};
  for (std::size_t k = 0; k < 3; ++k) {
    energy[k].width = 1;
    energy[k].values.push_back(values[k]);
  }
}

// Sleepers that are not placed yet have columns of zeros.
void Results::Room::sample_sleepers(const track::Sleepers* sleepers,
                                    std::span<const double> seat_force) {
  if (sleeper.empty()) sleeper = sleeper_columns();
  for (Column& column : sleeper) column.width = seat_force.size();
  for (std::size_t i = 0; i < seat_force.size(); ++i) {
    const bool there = sleepers != nullptr;
    const track::SleeperState state =
        there ? sleepers->state(i)
              : track::SleeperState{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(),
                                    Vec3::Zero()};
    // Forces up positive as in the rest of the file; seat loads are given downwards.
    const double values[] = {state.displacement.z(), state.velocity.z(), state.acceleration.z(),
                             there ? -seat_force[i] : 0, there ? sleepers->reaction(i).z() : 0};
    for (std::size_t k = 0; k < 5; ++k) sleeper[k].values.push_back(values[k]);
  }
}

// In the order of region_columns.
void Results::Room::sample_regions(const dem::Particles& particles) {
  auto column = region.begin();
  for (const Region& one : regions) {
    const std::vector<Measured> cells = measure(comm, particles, one);
    const auto put = [&](std::size_t numbers, const auto& of) {
      column->width = cells.size() * numbers;
      for (const Measured& cell : cells) {
        const double* first = of(cell);
        column->values.insert(column->values.end(), first, first + numbers);
      }
      ++column;
    };
    for (const auto figure :
         {&Measured::porosity, &Measured::bulk_density, &Measured::stones, &Measured::coordination,
          &Measured::contacts, &Measured::contact_force})
      put(1, [&](const Measured& cell) { return &(cell.*figure); });
    for (const auto tensor : {&Measured::stress, &Measured::fabric})
      put(6, [&](const Measured& cell) { return (cell.*tensor).data(); });
  }
}

}  // namespace trackbed::observe
