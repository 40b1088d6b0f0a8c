#include "observe/field_series.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

namespace trackbed::observe {

namespace {

// Enters a file of the series' folder in the list of files and times that ParaView reads. Entries
// of this time and later ones are those of an earlier run from the same checkpoint. On rank 0;
// returns a problem or nothing.
std::string enter_in_series(const std::string& path, const std::string& name, double time) {
  using Json = nlohmann::ordered_json;
  Json files = Json::array();
  if (std::ifstream given(path); given) {
    const Json old = Json::parse(given, nullptr, false);  // a damaged list is replaced
    if (old.is_object() && old.contains("files") && old["files"].is_array())
      for (const Json& file : old["files"])
        if (file.is_object() && file.value("time", time) < time) files.push_back(file);
  }
  files.push_back({{"name", name}, {"time", time}});
  const std::string part = path + ".part";
  std::ofstream(part) << Json{{"file-series-version", "1.0"}, {"files", files}}.dump(1) << '\n';
  std::error_code error;
  std::filesystem::rename(part, path, error);
  return error ? path + " cannot be written: " + error.message() : "";
}

// A rank that writes no cells still takes part in each collective call.
io::Grid empty_like(const io::Grid& grid) {
  io::Grid empty;
  empty.kind = grid.kind;
  empty.point_data = grid.point_data, empty.cell_data = grid.cell_data;
  for (std::vector<io::FieldData>* data : {&empty.point_data, &empty.cell_data})
    for (io::FieldData& field : *data) field.values.clear();
  return empty;
}

constexpr double distance_of_rail_points = 0.15;  // m, a quarter of the usual spacing of sleepers

class TrainGrid {
 public:
  // Points of one rail and their upward displacements, which the points contain, m.
  void add_rail(const std::vector<Vec3>& points, const std::vector<double>& displacement) {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      add_cell(io::CellKind::line, {points[i], points[i + 1]}, -1, 0);
      for (std::size_t end = i; end < i + 2; ++end) add_displacement(displacement[end]);
    }
  }
  // A wheel of `radius` (m) that stands on the rail at `foot`; `force`, N, on the rail.
  void add_wheel(const Vec3& foot, double radius, std::size_t wheel, double force,
                 double displacement) {
    constexpr int corners = 32;
    std::vector<Vec3> rim;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * std::numbers::pi * k / corners;
      rim.emplace_back(foot.x() + radius * std::cos(angle), foot.y(),
                       foot.z() + radius * (1 + std::sin(angle)));
      add_displacement(displacement);
    }
    add_cell(io::CellKind::polygon, rim, static_cast<double>(wheel), force);
  }
  io::Grid take() {
    grid_.cell_data = {std::move(wheel_), std::move(force_)};
    grid_.point_data = {std::move(moved_)};
    return std::move(grid_);
  }

 private:
  void add_cell(io::CellKind kind, const std::vector<Vec3>& corners, double wheel, double force) {
    std::vector<std::int64_t> nodes(corners.size());
    std::iota(nodes.begin(), nodes.end(), static_cast<std::int64_t>(grid_.points.size()));
    grid_.points.insert(grid_.points.end(), corners.begin(), corners.end());
    grid_.add(kind, nodes);
    wheel_.values.push_back(wheel);
    force_.values.push_back(force);
  }
  void add_displacement(double up) { moved_.values.insert(moved_.values.end(), {0, 0, up}); }

  io::Grid grid_;
  io::FieldData moved_{
      "displacement", {"m", "x y z, of rails and wheels, contained in the shape"}, 3, {}},
      wheel_{"wheel", {"-", "number, front first; -1: rail"}, 1, {}, true},
      force_{"wheel_force", {"N", "of the wheel on the rail, down positive; 0: rail"}, 1, {}};
};

}  // namespace

FieldSeries::FieldSeries(const par::Comm& comm, const FieldFiles& files)
    : comm_(comm), files_(files) {
  std::error_code error;
  if (comm.root()) std::filesystem::create_directories(files.folder, error);
  comm.agree(error ? "cannot create " + files.folder + ": " + error.message() : "");
}

void FieldSeries::write(std::string_view part, const std::function<io::Grid()>& grid) {
  if (std::find(files_.parts.begin(), files_.parts.end(), part) == files_.parts.end()) return;
  const std::string name = fmt::format("{}_{}.hdf", files_.name, part);
  io::write_fields(comm_, files_.folder + "/" + name, grid(), files_.origin, files_.time);
  const std::string series = fmt::format("{}/{}.hdf.series", files_.folder, part);
  comm_.agree(comm_.root() ? enter_in_series(series, name, files_.time) : "");
}

void FieldSeries::write_on_root(std::string_view part, const std::function<io::Grid()>& grid) {
  write(part, [&] {
    io::Grid whole = grid();
    return comm_.root() ? std::move(whole) : empty_like(whole);
  });
}

io::Grid rails_and_wheels(const track::Passage& passage, const track::Train& train,
                          const TrainPlace& place) {
  TrainGrid grid;
  const double length = passage.line().length();
  const auto parts = static_cast<int>(std::ceil(length / distance_of_rail_points));
  for (std::size_t side = 0; side < passage.line().sides(); ++side) {
    std::vector<Vec3> points;
    std::vector<double> up;
    for (int k = 0; k <= parts; ++k) {
      const double x = length * k / parts;
      up.push_back(passage.rail_displacement(x, side));
      points.emplace_back(place.origin + x, place.across(side), place.level + up.back());
    }
    grid.add_rail(points, up);
  }
  for (std::size_t i = 0; i < train.wheels().size(); ++i) {
    const track::Train::Wheel& wheel = train.wheels()[i];
    const double x = passage.wheel_x(i);
    if (x < 0 || x > length) continue;  // on the rigid rail before and behind the track
    // An axle of constant force has no height of its own.
    const double up =
        wheel.unknown >= 0 ? passage.wheel_height(i) : passage.rail_displacement(x, wheel.side);
    grid.add_wheel({place.origin + x, place.across(wheel.side), place.level + up},
                   place.wheel_radius, i, passage.wheel_force(i), up);
  }
  return grid.take();
}

}  // namespace trackbed::observe
