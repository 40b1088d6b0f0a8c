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

TrainGrid::TrainGrid()
    : wheel_{"wheel", {"-", "number, front first; -1: rail"}, 1, {}, true},
      force_{"wheel_force", {"N", "of the wheel on the rail, down positive; 0: rail"}, 1, {}} {}

void TrainGrid::add_cell(io::CellKind kind, const std::vector<Vec3>& corners, double wheel,
                         double force) {
  std::vector<std::int64_t> nodes(corners.size());
  std::iota(nodes.begin(), nodes.end(), static_cast<std::int64_t>(grid_.points.size()));
  grid_.points.insert(grid_.points.end(), corners.begin(), corners.end());
  grid_.add(kind, nodes);
  wheel_.values.push_back(wheel);
  force_.values.push_back(force);
}

void TrainGrid::add_rail(const std::vector<Vec3>& points, const std::vector<double>& displacement) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    add_cell(io::CellKind::line, {points[i], points[i + 1]}, -1, 0);
    for (std::size_t end = i; end < i + 2; ++end)
      displacement_.push_back(displacement.empty() ? 0 : displacement[end]);
  }
}

void TrainGrid::add_wheel(const Vec3& foot, double radius, std::size_t wheel, double force,
                          double displacement) {
  constexpr int corners = 32;
  std::vector<Vec3> rim;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * std::numbers::pi * k / corners;
    rim.emplace_back(foot.x() + radius * std::cos(angle), foot.y(),
                     foot.z() + radius * (1 + std::sin(angle)));
  }
  add_cell(io::CellKind::polygon, rim, static_cast<double>(wheel), force);
  displacement_.insert(displacement_.end(), corners, displacement);
}

io::Grid TrainGrid::take(bool with_displacements) {
  grid_.cell_data = {std::move(wheel_), std::move(force_)};
  if (with_displacements) {
    io::FieldData moved{
        "displacement", {"m", "x y z, of rails and wheels, contained in the shape"}, 3, {}};
    for (const double up : displacement_) moved.values.insert(moved.values.end(), {0, 0, up});
    grid_.point_data = {std::move(moved)};
  }
  return std::move(grid_);
}

double height_of_rail(const std::vector<Vec3>& points, double x) {
  const auto after =
      std::find_if(points.begin(), points.end(), [x](const Vec3& point) { return point.x() > x; });
  if (after == points.begin()) return points.front().z();
  if (after == points.end()) return points.back().z();
  const Vec3 &a = *(after - 1), &b = *after;
  return a.z() + (b.z() - a.z()) * (x - a.x()) / (b.x() - a.x());
}

}  // namespace trackbed::observe
