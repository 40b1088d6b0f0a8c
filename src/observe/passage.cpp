// Rows of a passage. All ranks hold the same ones; rank 0 writes.
#include "trackbed/observe/passage.hpp"

#include <algorithm>
#include <limits>

#include "observe/column_writer.hpp"
#include "observe/impl.hpp"
#include "observe/layout.hpp"
#include "trackbed/io/replace.hpp"
#include "trackbed/track/vehicle_layout.hpp"

namespace trackbed::observe {

namespace {

// Order of `columns_`.
struct PassageColumn {
  enum : std::size_t {
    wheel_force,
    wheel_x,
    rail_displacement,
    sleeper_displacement,
    sleeper_acceleration,
    seat_force,
    body_displacement,
    body_acceleration,
    rail_force,
    body_roll,
    wheel_height,
    ground_displacement,
    ground_force,
    sleeper_moment
  };
};

}  // namespace

// Columns have the order of `PassageColumn`. Points may have the same nearest sleeper, which is
// kept once.
PassageHistories::PassageHistories(const track::Line& line, const track::Train& train,
                                   PassageRecorded recorded)
    : line_(line), train_(train), recorded_(std::move(recorded)), envelope_(line) {
  for (const double x : recorded_.points)
    if (line.sleepers() > 0) sleepers_.push_back(line.nearest_sleeper(x));
  std::sort(sleepers_.begin(), sleepers_.end());
  sleepers_.erase(std::unique(sleepers_.begin(), sleepers_.end()), sleepers_.end());
  const std::size_t wheels = train.wheels().size(), bodies = train.vehicles().size();
  const std::size_t sides = line.sides(), points_each = sides * recorded_.points.size(),
                    sleepers_each = sides * sleepers_.size();
  lowest_.assign(points_each, std::numeric_limits<double>::infinity());
  columns_ = {
      {"history/wheel/force", {"N", "of one wheel on the rail, down positive"}, wheels, {}},
      {"history/wheel/x", {"m", "position along the track"}, wheels, {}},
      {"history/rail/displacement", {"m", "vertical, up positive"}, points_each, {}},
      {"history/sleeper/displacement", {"m", "vertical, up positive"}, sleepers_each, {}},
      {"history/sleeper/acceleration", {"m/s2", "vertical, no filter"}, sleepers_each, {}},
      {"history/sleeper/seat_force",
       {"N", "force of the pad on the sleeper, or the seat load, down positive"},
       sleepers_each,
       {}},
      {"history/body/displacement",
       {"m", "vertical, up positive, relative to unloaded springs; 0 for vehicles of kind forces"},
       bodies,
       {}},
      {"history/body/acceleration", {"m/s2", "vertical, no filter"}, bodies, {}},
      {"history/rail/force", {"N", "of [[force]], down positive"}, recorded_.forces, {}},
      {"history/body/roll", {"rad", "left side up positive"}, sides > 1 ? bodies : 0, {}},
      {"history/wheel/height",
       {"m",
        "height of the wheel, up positive, zero at first contact with the even, undeflected rail"},
       wheels,
       {}},
      {"history/ground/displacement",
       {"m", sides > 1
                 ? "vertical, up positive: below the ballast spring of each sleeper end (from "
                   "the mean displacement and transverse slope of the footprint); 0 on rigid "
                   "ground"
                 : "vertical, up positive: mean below the ballast of a sleeper; 0 on rigid "
                   "ground"},
       on_ground() ? sleepers_each : 0,
       {}},
      {"history/ground/force",
       {"N", sides > 1 ? "force of the ballast on the ground, per sleeper end, compression positive"
                       : "force of the ballast on the ground, per sleeper and rail, compression "
                         "positive"},
       on_ground() ? sleepers_each : 0,
       {}},
      {"history/sleeper/moment",
       {"N m",
        "in a sleeper: below the left rail, in the middle, below the right rail (half sleeper: "
        "only the first two); positive (sagging) if the ends bend upwards"},
       line.sleepers_bend() ? (sides + 1) * sleepers_.size() : 0,
       {}}};
  // Columns without rows, which a resume reads.
  put_energies({});
  put_readings(recorded_.sensors, std::vector<SensorReading>(recorded_.sensors.size()), sensor_);
  for (std::vector<Column>* group : {&energy_, &sensor_})
    for (Column& column : *group) column.values.clear();
}

bool PassageHistories::on_ground() const {
  return line_.moved() > 0 && line_.moves() == track::MovedPart::ground;
}

void PassageHistories::put_energies(const PassageEnergies& energies) {
  ColumnWriter to(energy_);
  to.put("history/energy/track",
         {"J", "kinetic and elastic, of rails, sleepers and all springs below them"},
         energies.track);
  if (!on_ground()) return;
  to.put("history/energy/given_to_ground", {"J", "work of the track on the ground up to now"},
         energies.given_to_ground);
  observe::put_energies(energies.ground, to);
}

// All values at the end of the step. Left before right.
void PassageHistories::sample(const track::Passage& passage, const PassageEnergies& energies,
                              std::span<const SensorReading> readings) {
  times_.push_back(passage.time());
  put_energies(energies);
  put_readings(recorded_.sensors, readings, sensor_);
  for (std::size_t i = 0; i < train_.wheels().size(); ++i) {
    put(PassageColumn::wheel_force, passage.wheel_force(i));
    put(PassageColumn::wheel_x, passage.wheel_x(i));
    put(PassageColumn::wheel_height, passage.wheel_height(i));
  }
  for (const double x : recorded_.points)
    for (std::size_t side = 0; side < line_.sides(); ++side)
      put(PassageColumn::rail_displacement, passage.rail_displacement(x, side));
  const track::Newmark& rail = passage.line_motion();
  for (const std::size_t i : sleepers_)
    for (std::size_t side = 0; side < line_.sides(); ++side) {
      const std::int32_t unknown = line_.sleeper_unknown(i, side);
      put(PassageColumn::sleeper_displacement, rail.displacement[unknown]);
      put(PassageColumn::sleeper_acceleration, rail.acceleration[unknown]);
      put(PassageColumn::seat_force, passage.on_sleeper(i, side));
    }
  for (const std::size_t i : sleepers_)
    if (columns_[PassageColumn::sleeper_moment].width > 0)
      for (std::size_t place = 0; place <= line_.sides(); ++place)
        put(PassageColumn::sleeper_moment,
            line_.sleeper_moment(i, line_.gauge() / 2 * (1 - static_cast<double>(place)),
                                 rail.displacement));
  for (const std::size_t i : sleepers_)
    for (std::size_t side = 0;
         columns_[PassageColumn::ground_force].width > 0 && side < line_.sides(); ++side) {
      put(PassageColumn::ground_displacement, passage.ground_below(i, side).height);
      put(PassageColumn::ground_force, passage.ground_force(i, side));
    }
  const track::Newmark& train = passage.train_motion();
  for (std::size_t i = 0; i < train_.vehicles().size(); ++i) {
    const bool forces = track::layout_of(train_.vehicles()[i].kind).constant;
    const std::int32_t body = train_.first_unknown()[i];
    put(PassageColumn::body_displacement, forces ? 0 : train.displacement[body]);
    put(PassageColumn::body_acceleration, forces ? 0 : train.acceleration[body]);
    if (const std::int32_t roll = train_.roll_unknown()[i]; line_.sides() > 1)
      put(PassageColumn::body_roll, roll < 0 ? 0 : train.displacement[roll]);
  }
  for (std::size_t i = 0; i < recorded_.forces; ++i)
    put(PassageColumn::rail_force, passage.rail_force(i));
}

void PassageHistories::update_extremes(const track::Passage& passage) {
  for (std::size_t i = 0; i < lowest_.size(); ++i) {
    const double down =
        passage.rail_displacement(recorded_.points[i / line_.sides()], i % line_.sides());
    lowest_[i] = std::min(lowest_[i], down);
  }
  envelope_.update(passage);
}

// As in results.h5: a checkpoint contains its rows, so that no other file is needed for a restart.
void PassageHistories::archive(io::Archive& a) {
  a("history/time", times_, {"s", "simulated time"});
  if (!lowest_.empty())
    a.rows("extreme/rail/displacement", lowest_,
           {"m", "lowest of all time steps up to now, including those without a history row"});
  envelope_.archive(a);
  for (std::vector<Column>* group : {&columns_, &energy_, &sensor_})
    for (Column& column : *group) {
      if (column.width == 0) continue;
      column.values.resize(column.width * times_.size());
      a.table(column.path, column.values, column.width, column.label);
    }
}

// Written under another name first, so that a reader opens either the old file or the complete new
// one; by one rank, which can compress it.
void PassageHistories::write(const par::Comm& comm, const std::string& path, const About& about,
                             bool compress) {
  // On two rails each place is listed twice, left before right.
  std::vector<double> sleeper_x, rail_x;
  for (const std::size_t i : sleepers_)
    sleeper_x.insert(sleeper_x.end(), line_.sides(), line_.sleeper_x(i));
  for (const double x : recorded_.points) rail_x.insert(rail_x.end(), line_.sides(), x);
  io::replace_file_on_root(comm, path, [&](const std::string& part) {
    const par::Comm self = par::Comm::self();
    io::File file(self, part, io::Mode::create);
    if (compress) file.compress();
    put_origin(comm, file, about);
    file.write<double>("rail/x", rail_x, 1, {"m", "monitored points of the rail"});
    if (!sleeper_x.empty())
      file.write<double>("sleepers/x", sleeper_x, 1, {"m", "monitored sleepers"});
    io::Archive a = io::Archive::writer(self, file);
    archive(a);
    set_axes(self, file);
    file.close();
  });
}

}  // namespace trackbed::observe
