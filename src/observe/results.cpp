// Histories are collected in memory and added to the file at a flush (checkpoints, ends of stages).
// HDF5 alone does not keep a file whole: an interruption between two of its writes can leave one
// that cannot be opened, with the loss of hours of histories. SWMR, its solution, does not support
// parallel files. So there are two files. The twin has all but the rows of the last flush; these
// and the new ones are appended to it, and then the two exchange their names in one step. A reader
// opens a whole file at any time, and a flush writes each row twice instead of copying all rows
// before. Other changes (snapshots) are made to the twin, which then replaces the file; the next
// flush copies the file once to have a twin again.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>

#include "observe/column_writer.hpp"
#include "observe/impl.hpp"
#include "observe/layout.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::observe {

namespace fs = std::filesystem;

namespace {

// About 1 MB with 30 columns, and as much of the last flush. Memory is the same on all ranks.
constexpr std::size_t rows_in_memory = 4000;
constexpr double same_place = 1e-6;  // m, two nodes on one line along the track

// Names and units of the histories are read by postproc/ and by users' scripts.
std::vector<Column> sleeper_columns() {
  return {{"history/sleeper/displacement",
           {"m", "vertical, of the centre, since the sleeper was placed"}},
          {"history/sleeper/velocity", {"m/s", "vertical"}},
          {"history/sleeper/acceleration", {"m/s2", "vertical, in the last window, no filter"}},
          {"history/sleeper/seat_force",
           {"N", "vertical force on the rail seat, up positive (a load is negative)"}},
          {"history/sleeper/reaction", {"N", "vertical, of the stones, mean of the last window"}}};
}

// A number of each cell of a region, and its dataset.
struct CellColumn {
  const char* name;
  io::Label label;
  double Measurement::*number;
};

const std::vector<CellColumn>& cell_columns() {
  using M = Measurement;
  static const std::vector<CellColumn> columns{
      {"porosity", {"-", "volume fraction of voids in each cell, x fastest, then y"}, &M::porosity},
      {"bulk_density", {"kg/m3", "mass of stones divided by volume of the cell"}, &M::bulk_density},
      {"stones", {"-", "number of stones with their centre in the cell"}, &M::stones},
      {"coordination",
       {"-", "mean number of stones and surfaces that touch a stone with its centre in the cell"},
       &M::coordination},
      {"contacts",
       {"-", "number of contacts with their branch midpoint in the cell"},
       &M::contacts},
      {"contact_force", {"N", "mean magnitude of the contact forces"}, &M::contact_force},
      {"speed", {"m/s", "mean of the stones with their centre in the cell"}, &M::speed},
      {"speed_deviation",
       {"m/s", "standard deviation over these stones, divisor: their number"},
       &M::speed_deviation},
      {"largest_speed", {"m/s", "of these stones"}, &M::largest_speed},
      {"stone_force",
       {"N", "mean magnitude of the sum of the contact forces on one of these stones"},
       &M::stone_force},
      {"stone_force_deviation",
       {"N", "standard deviation of this magnitude over these stones, divisor: their number"},
       &M::stone_force_deviation},
      {"largest_stone_force", {"N", "largest magnitude of this sum"}, &M::largest_stone_force}};
  return columns;
}

// The tensors of each cell, six numbers.
struct TensorColumn {
  const char* name;
  io::Label label;
  Tensor Measurement::*tensor;
};

const std::array<TensorColumn, 2>& tensor_columns() {
  static const std::array<TensorColumn, 2> columns{
      TensorColumn{"stress",
                   {"Pa", "Love-Weber, xx yy zz xy xz yz of each cell, tension positive"},
                   &Measurement::stress},
      TensorColumn{"fabric",
                   {"-", "mean n n^T of the contacts' normals, components as of stress"},
                   &Measurement::fabric}};
  return columns;
}

// Columns of one region, in the order in which `sample_regions` fills them.
std::vector<Column> region_columns(const std::string& name) {
  const std::string group = "history/region/" + name + "/";
  std::vector<Column> columns;
  for (const CellColumn& one : cell_columns()) columns.push_back({group + one.name, one.label});
  for (const TensorColumn& one : tensor_columns()) columns.push_back({group + one.name, one.label});
  return columns;
}

}  // namespace

// One line of top nodes along the track: the front face of a slice (its lowest y), or in space the
// line nearest to the middle, y = 0, the last one of equal distance. In ascending x, so that plots
// need no sorting. The same on all ranks, since each holds the whole top.
std::vector<std::int32_t> monitored_nodes(fem::Ground& ground, Dimension dimension) {
  const auto& nodes = ground.top().position;
  const auto distance = [&](const Vec3& x) {
    return dimension == Dimension::plane ? x.y() : std::abs(x.y());
  };
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec3& node : nodes) nearest = std::min(nearest, distance(node));
  double line = 0;
  for (const Vec3& node : nodes)
    if (distance(node) == nearest) line = node.y();
  std::vector<std::int32_t> monitored;
  for (std::size_t n = 0; n < nodes.size(); ++n)
    if (std::abs(nodes[n].y() - line) < same_place)
      monitored.push_back(static_cast<std::int32_t>(n));
  std::sort(monitored.begin(), monitored.end(), [&](std::int32_t a, std::int32_t b) {
    return nodes[static_cast<std::size_t>(a)].x() < nodes[static_cast<std::size_t>(b)].x();
  });
  return monitored;
}

Results::Results(const par::Comm& comm, const std::string& path, const About& about)
    : impl_(std::make_unique<Impl>(comm, path, about)) {}
Results::~Results() = default;
Results::Results(Results&&) noexcept = default;

std::int64_t Results::rows() const { return impl_->rows; }

bool Results::Impl::records(std::string_view part) const {
  return std::find(recorded.parts.begin(), recorded.parts.end(), part) != recorded.parts.end();
}

// Collective. Positions are written before the first row, so that a file without rows can be
// plotted, too.
void Results::begin(const Scene& scene, const Recorded& recorded) {
  Impl& impl = *impl_;
  impl.recorded = recorded;
  for (const Region& region : recorded.regions)
    for (const Column& column : region_columns(region.name)) impl.region.push_back(column);
  if (scene.ground) impl.set_ground_columns(scene.particles.domain().dimension);
  // The columns above are needed in any case; header and positions are already in a resumed file.
  if (impl.resumed) return;
  std::vector<double> x;
  if (scene.ground)
    for (const std::int32_t n : recorded.nodes)
      x.push_back(scene.ground->top().position[static_cast<std::size_t>(n)].x());
  const std::span<const double> sleeper_x = recorded.sleeper_x;
  const bool root = impl.comm.root();
  impl.begin_file([&](io::File& file) {
    if (!x.empty())
      file.write<double>("ground/x", std::span<const double>(x).first(root ? x.size() : 0), 1,
                         {"m", "top nodes at one face, along the track"});
    if (!sleeper_x.empty())
      file.write<double>("sleepers/x", sleeper_x.first(root ? sleeper_x.size() : 0), 1,
                         {"m", "centres of the sleepers, along the track"});
  });
}

// All ranks call it and hold the same rows: totals and sums are agreed on, and one rank writes
// them. A row is a few hundred numbers, too few to distribute.
void Results::sample(const Scene& scene, const Instant& instant) {
  Impl& impl = *impl_;
  impl.times.push_back(instant.time);
  impl.stages.push_back(instant.stage);
  if (impl.records("energy")) impl.sample_energies(scene, instant.placed != nullptr);
  if (!instant.seat_force.empty() && impl.records("sleeper"))
    impl.sample_sleepers(scene.sleepers, instant.seat_force);
  if (scene.ground && impl.records("ground")) impl.sample_ground(*scene.ground);
  if (impl.records("wall")) impl.sample_walls(instant.walls);
  if (instant.platen && impl.records("platen")) impl.sample_platen(*instant.platen);
  if (instant.cycles >= 0 && impl.records("sleeper"))
    ColumnWriter(impl.traffic)
        .put("history/traffic/cycles",
             {"-", "complete cycles of load or trains, those of jumps included"}, instant.cycles);
  if (instant.train && impl.records("train"))
    impl.sample_train(*instant.train, instant.seat_force.size());
  if (instant.solids && impl.records("solid")) impl.sample_solids(*instant.solids);
  if (instant.placed && impl.records("stone")) impl.sample_placed(*instant.placed);
  if (impl.records("region")) impl.sample_regions(scene.particles);
  if (impl.records("sensor")) put_readings(impl.recorded.sensors, instant.sensors, impl.sensor);
  ++impl.rows;
  if (impl.times.size() >= rows_in_memory) flush();
}

// Collective. Afterwards the file has the number of rows that a checkpoint stores.
void Results::flush() {
  if (!impl_->times.empty()) impl_->flush();
}

// Creates no file: `begin` or `resume` does.
Results::Impl::Impl(const par::Comm& world, std::string file, About what)
    : comm(world), path(std::move(file)), about(std::move(what)) {}

void put_origin(const par::Comm& comm, io::File& file, const About& about) {
  file.attribute("/", "kind", std::string(results_kind));
  file.attribute("/", "version", about.version);
  file.attribute("/", "build", about.build);
  file.attribute("/", "ranks", static_cast<std::int64_t>(comm.size()));
  file.attribute("/", "deck", about.deck);
}

void Results::Impl::put_head(io::File& file) {
  put_origin(comm, file, about);
  if (!about.grading.empty())
    file.write<double>(
        "bed/grading",
        std::span<const double>(about.grading).first(comm.root() ? about.grading.size() : 0), 4,
        {"m, %", "per sieve: opening; specified passing by mass, lowest and highest allowed"});
}

// Replaces an existing file; prepare_folder has checked that it may. Under another name until it is
// complete: a run that is killed at once leaves no file that cannot be opened. Collective.
void Results::Impl::begin_file(const std::function<void(io::File&)>& write_positions) {
  io::File file(comm, twin_path(), io::Mode::create);
  put_head(file);
  write_positions(file);
  file.close();
  take_name(twin_path());
}

void Results::Impl::take_name(const std::string& part) {
  std::error_code error;
  if (comm.root()) fs::rename(part, path, error);
  comm.agree(error ? path + ": cannot be replaced (" + error.message() + ")" : "");
}

namespace {

// Copies a file; returns why it failed, or nothing. On rank 0.
// The library reports "Input/output error" for a full disk, but errno has the actual reason.
std::string copied(const std::string& from, const std::string& to) {
  std::error_code error;
  errno = 0;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (!error) return "";
  const bool known = errno == ENOSPC || errno == EDQUOT || errno == EFBIG;
  return to + ": cannot be written (" + (known ? std::strerror(errno) : error.message()) + ")";
}

// Whether a reader has opened the file, which was the file of results before the last flush:
// readers of HDF5 hold a lock on it. Without one, changes could reach a reader in the middle of its
// work.
bool is_being_read(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY);
  if (descriptor < 0) return true;
  const bool free = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  ::close(descriptor);  // and the lock
  return !free;
}

}  // namespace

Results::Impl::~Impl() {
  std::error_code ignored;
  if (has_twin && comm.root()) fs::remove(twin_path(), ignored);
}

// A twin that is being read is left to its reader.
void Results::Impl::prepare_twin() {
  const std::string twin = twin_path();
  if (has_twin) {
    const bool in_use = comm.root() && is_being_read(twin);
    has_twin = comm.broadcast(in_use ? "in use" : "").empty();
  }
  if (has_twin) return;
  std::error_code ignored;
  if (comm.root()) fs::remove(twin, ignored);  // not overwritten: a reader keeps its contents
  comm.agree(comm.root() ? copied(path, twin) : "");
}

// Rank 0 copies; all ranks open the twin together. An incomplete one is removed, so that it does
// not fill the disk.
void Results::Impl::change_twin(const std::function<void(io::File&)>& change) {
  try {
    prepare_twin();
    io::File file(comm, twin_path(), io::Mode::append);
    if (has_twin) append_last_to(file);
    change(file);
    file.close();
  } catch (const RunError&) {  // the same on all ranks
    std::error_code ignored;
    if (comm.root()) fs::remove(twin_path(), ignored);
    has_twin = false;
    throw;
  }
}

// The old file remains valid until the rename, which is atomic (POSIX).
void Results::Impl::replace(const std::function<void(io::File&)>& change) {
  change_twin(change);
  take_name(twin_path());
  has_twin = false;
}

// Not all file systems can exchange names: then the old file is lost as in `replace`, and each
// flush copies the file.
void Results::Impl::flush() {
  change_twin([&](io::File& file) { append_to(file); });
  const std::string twin = twin_path();
  const bool exchanged = comm.root() && ::renameat2(AT_FDCWD, twin.c_str(), AT_FDCWD, path.c_str(),
                                                    RENAME_EXCHANGE) == 0;
  has_twin = !comm.broadcast(exchanged ? "exchanged" : "").empty();
  if (!has_twin) take_name(twin);
}

namespace {

// Columns that were not sampled have width 0 and no dataset; a new dataset gets its axes. All ranks
// have all rows; one writes them.
template <class Groups>
void append_rows(const par::Comm& comm, io::File& file, const std::vector<double>& times,
                 const std::vector<std::int64_t>& stages, const std::vector<std::string>& names,
                 const Groups& groups, std::vector<double> Column::*rows) {
  const auto own = [&](const auto& values) {
    return std::span(values).first(comm.root() ? values.size() : 0);
  };
  const auto append = [&]<class T>(const std::string& path, const std::vector<T>& values,
                                   std::size_t width, const io::Label& label) {
    const bool fresh = !file.has(path);
    file.append<T>(path, own(values), width, label);
    if (fresh) set_axes_of_history(comm, file, path);
  };
  append("history/time", times, 1, {"s", "simulated time"});
  append("history/stage", stages, 1, {"-", "number of the stage"});
  name_stages(file, names);
  for (const auto* group : groups)
    for (const Column& column : *group)
      if (column.width > 0) append(column.path, column.*rows, column.width, column.label);
}

}  // namespace

void Results::Impl::append_last_to(io::File& file) const {
  append_rows(comm, file, last_times, last_stages, recorded.stages, groups_of(*this),
              &Column::last);
}

void Results::Impl::append_to(io::File& file) {
  append_rows(comm, file, times, stages, recorded.stages, groups_of(*this), &Column::values);
  last_times.swap(times), last_stages.swap(stages);
  times.clear(), stages.clear();
  for (auto* group : groups_of(*this))
    for (Column& column : *group) column.last.swap(column.values), column.values.clear();
}

void Results::Impl::sample_energies(const Scene& scene, bool placed_stones) {
  ColumnWriter to(energy);
  if (scene.ground) put_energies(scene.ground->energies(), to);
  if (!scene.stones) return;
  const dem::Energies energies = scene.particles.energies();
  to.put("history/energy/kinetic", {"J", "of the stones"}, energies.kinetic);
  to.put("history/energy/potential", {"J", "of the stones, zero at z = 0"}, energies.potential);
  to.put("history/energy/elastic", {"J", "of the stones' contacts"}, energies.elastic);
  if (!energies.account) return;
  to.put("history/energy/friction",
         {"J",
          "dissipated by sliding, torsion and rolling, and by springs of Hertz contacts as they "
          "change, up to now"},
         energies.account->friction);
  to.put("history/energy/contact_damping", {"J", "dissipated by dashpots up to now"},
         energies.account->contact_damping);
  to.put("history/energy/local_damping", {"J", "dissipated by local damping up to now"},
         energies.account->local_damping);
  const dem::BreakTotals broken = scene.particles.broken();
  const double bonds = scene.bonds ? scene.particles.bonded().released : 0;
  to.put("history/energy/breakage",
         {"J", "elastic energy released and kinetic energy lost by breakage, up to now"},
         broken.released + broken.lost + bonds);
  // Placed stones and surfaces are driven: their histories have the work of all drives.
  if (!placed_stones)
    to.put("history/energy/supplied", {"J", "work of surfaces on the stones up to now"},
           energies.account->supplied);
}

// Columns are zero until the sleepers are placed.
void Results::Impl::sample_sleepers(const track::Sleepers* sleepers,
                                    std::span<const double> seat_force) {
  if (sleeper.empty()) sleeper = sleeper_columns();
  for (Column& column : sleeper) column.width = seat_force.size();
  for (std::size_t i = 0; i < seat_force.size(); ++i) {
    const bool placed = sleepers != nullptr;
    const track::SleeperState state =
        placed ? sleepers->state(i)
               : track::SleeperState{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(),
                                     Vec3::Zero()};
    // Forces are positive upwards as in the rest of the file; seat loads are positive downwards.
    const double values[] = {state.displacement.z(), state.velocity.z(), state.acceleration.z(),
                             placed ? -seat_force[i] : 0, placed ? sleepers->reaction(i).z() : 0};
    for (std::size_t k = 0; k < 5; ++k) sleeper[k].values.push_back(values[k]);
  }
}

// In the order of region_columns.
void Results::Impl::sample_regions(const dem::Particles& particles) {
  auto column = region.begin();
  for (const Region& one : recorded.regions) {
    const std::vector<Measurement> cells = measure(comm, particles, one);
    const auto put = [&](std::size_t numbers, const auto& of) {
      column->width = cells.size() * numbers;
      for (const Measurement& cell : cells) {
        const double* first = of(cell);
        column->values.insert(column->values.end(), first, first + numbers);
      }
      ++column;
    };
    for (const CellColumn& each : cell_columns())
      put(1, [&](const Measurement& cell) { return &(cell.*each.number); });
    for (const TensorColumn& each : tensor_columns())
      put(6, [&](const Measurement& cell) { return (cell.*each.tensor).data(); });
  }
}

}  // namespace trackbed::observe
