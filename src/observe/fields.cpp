// Field files for ParaView at one instant: stones in their shapes, contacts, ground, bodies,
// surfaces and the train. Every rank writes its own stones and contacts, so the order of rows
// depends on the ranks; what all ranks know is written by the root.
#include "trackbed/io/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "observe/impl.hpp"
#include "trackbed/track/rail.hpp"

namespace trackbed::observe {

namespace {

// Polyhedra as their faces, balls as points with a radius, which a viewer shows as spheres. Values
// are those of cells, since all corners of a stone have the same.
io::Grid stone_shapes(const dem::Particles& particles, double gravity) {
  io::Grid grid;
  io::FieldData radius{"radius", {"m", "of a ball; of the ball around a piece with faces"}, 1, {}},
      velocity{"velocity", {"m/s", "of the stone's centre of mass"}, 3, {}},
      force{"force", {"N", "sum of the contact forces on the stone"}, 3, {}},
      acceleration{
          "acceleration", {"m/s2", "of the centre of mass in the last sub-step, no filter"}, 3, {}},
      id{"stone", {"-", "number of the stone"}, 1, {}};
  std::vector<std::int64_t> nodes;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView stone = particles[i];
    const Vec3 accelerated = stone.acceleration(gravity);
    const auto add = [&](io::CellKind kind) {
      grid.add(kind, nodes);
      id.values.push_back(static_cast<double>(stone.id));
      for (int k = 0; k < 3; ++k) {
        velocity.values.push_back(stone.velocity[k]);
        force.values.push_back(stone.force[k]);
        acceleration.values.push_back(accelerated[k]);
      }
    };
    particles.outlines(i, [&](const dem::PieceOutline& piece) {
      const auto first = static_cast<std::int64_t>(grid.points.size());
      if (piece.faces.empty()) {
        grid.points.push_back(piece.centre);
        nodes.assign(1, first);
        add(io::CellKind::vertex);
      }
      grid.points.insert(grid.points.end(), piece.corners.begin(), piece.corners.end());
      for (const std::vector<int>& face : piece.faces) {
        nodes.clear();
        for (const int corner : face) nodes.push_back(first + corner);
        add(io::CellKind::polygon);
      }
      radius.values.resize(grid.points.size(), piece.radius);
    });
  }
  grid.point_data = {std::move(radius)};
  grid.cell_data = {std::move(velocity), std::move(force), std::move(acceleration), std::move(id)};
  return grid;
}

// One line per contact between the centres of the two pieces, which are not those of mass; the
// force is a vector on it, and its magnitude can be the width of a tube.
io::Grid contact_lines(const dem::Particles& particles) {
  io::Grid grid;
  grid.kind = io::CellKind::line;
  io::FieldData force{"force", {"N", "on the first of the two pieces"}, 3, {}},
      size{"force_size", {"N", "magnitude of the force"}, 1, {}},
      overlap{"overlap", {"m", "of the two pieces"}, 1, {}};
  particles.contacts([&](const dem::ContactView& contact) {
    const auto first = static_cast<std::int64_t>(grid.points.size());
    grid.points.insert(grid.points.end(), {contact.from, contact.to});
    grid.cells.insert(grid.cells.end(), {first, first + 1});
    for (int k = 0; k < 3; ++k) force.values.push_back(contact.force[k]);
    size.values.push_back(contact.force.norm());
    overlap.values.push_back(contact.overlap);
  });
  grid.cell_data = {std::move(force), std::move(size), std::move(overlap)};
  return grid;
}

// One line per bond between the centres of mass of both stones.
io::Grid bond_lines(const dem::Particles& particles) {
  io::Grid grid;
  grid.kind = io::CellKind::line;
  io::FieldData force{"force", {"N", "of the springs, on the first of the two stones"}, 3, {}},
      utilisation{"utilisation", {"-", "largest stress over its strength"}, 1, {}},
      damage{"damage", {"-", "part of the stiffness that is lost"}, 1, {}},
      kind{"kind", {"-", "number of the [[bond]]"}, 1, {}};
  particles.bonds([&](const dem::BondView& bond) {
    const auto first = static_cast<std::int64_t>(grid.points.size());
    grid.points.insert(grid.points.end(), {bond.first_centre, bond.second_centre});
    grid.cells.insert(grid.cells.end(), {first, first + 1});
    for (int k = 0; k < 3; ++k) force.values.push_back(bond.force[k]);
    utilisation.values.push_back(bond.utilisation), damage.values.push_back(bond.damage);
    kind.values.push_back(static_cast<double>(bond.kind));
  });
  grid.cell_data = {std::move(force), std::move(utilisation), std::move(damage), std::move(kind)};
  return grid;
}

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

// At the end of the last window. Known to all ranks: `own` is true on one.
io::Grid surface_triangles(const Scene& scene, bool own) {
  io::Grid grid;
  grid.kind = io::CellKind::triangle;
  io::FieldData number{"surface", {"-", "number of the surface"}, 1, {}},
      part{"part", {"-", "0 wall or floor, 1 plate or box, 2 sleeper, 3 platen, 4 tine"}, 1, {}};
  for (std::size_t n = 0; own && n < scene.surfaces.size(); ++n) {
    const Surface& surface = *scene.surfaces[n].surface;
    const auto first = static_cast<std::int64_t>(grid.points.size());
    for (std::size_t k = 0; k < surface.nodes(); ++k)
      grid.points.emplace_back(surface.position[k] + surface.motion[k]);
    for (const auto& triangle : surface.triangles) {
      for (const std::int32_t node : triangle) grid.cells.push_back(first + node);
      number.values.push_back(static_cast<double>(n));
      part.values.push_back(static_cast<double>(scene.surfaces[n].part));
    }
  }
  grid.cell_data = {std::move(number), std::move(part)};
  return grid;
}

// A rank that writes no cells still takes part in each collective call.
io::Grid empty_like(const io::Grid& grid) {
  io::Grid empty;
  empty.kind = grid.kind;
  empty.cell_data = grid.cell_data;
  for (io::FieldData& field : empty.cell_data) field.values.clear();
  return empty;
}

// Rails as lines above the sleepers, wheels as disks on them.
class TrainShape {
 public:
  TrainShape(const Scene& scene, const TrainView& train) : train_(train) {
    const track::Sleepers& sleepers = *scene.sleepers;
    std::vector<double> top;
    for (const SceneSurface& each : scene.surfaces)
      if (each.part == SceneSurface::Part::sleeper) {
        double highest = -std::numeric_limits<double>::infinity();
        for (const Vec3& node : each.surface->position) highest = std::max(highest, node.z());
        top.push_back(highest);
      }
    for (std::size_t side = 0; side < train.rails; ++side)
      for (std::size_t i = 0; i < sleepers.count(); ++i)
        rails_[side].emplace_back(sleepers.x(i), aside(side), top[i] + track::drawn_rail_height);
    for (std::size_t side = 0; side < train.rails; ++side) add_rail(rails_[side]);
    for (std::size_t i = 0; i < train.running.train().wheels().size(); ++i)
      add_wheel(i, i % train.rails);
    grid_.cell_data = {std::move(wheel_), std::move(force_)};
  }
  io::Grid take() { return std::move(grid_); }

 private:
  double aside(std::size_t side) const {
    return train_.rails == 1 ? 0 : (side == 0 ? 0.5 : -0.5) * train_.gauge;
  }
  void add_cell(io::CellKind kind, const std::vector<Vec3>& corners, double wheel, double force) {
    std::vector<std::int64_t> nodes(corners.size());
    std::iota(nodes.begin(), nodes.end(), static_cast<std::int64_t>(grid_.points.size()));
    grid_.points.insert(grid_.points.end(), corners.begin(), corners.end());
    grid_.add(kind, nodes);
    wheel_.values.push_back(wheel);
    force_.values.push_back(force);
  }
  void add_rail(const std::vector<Vec3>& rail) {
    for (std::size_t i = 0; i + 1 < rail.size(); ++i)
      add_cell(io::CellKind::line, {rail[i], rail[i + 1]}, -1, 0);
  }
  // Beyond the bed the rail is as high as above its last sleeper.
  double height(const std::vector<Vec3>& rail, double x) const {
    const auto after =
        std::find_if(rail.begin(), rail.end(), [x](const Vec3& point) { return point.x() > x; });
    if (after == rail.begin()) return rail.front().z();
    if (after == rail.end()) return rail.back().z();
    const Vec3 &a = *(after - 1), &b = *after;
    return a.z() + (b.z() - a.z()) * (x - a.x()) / (b.x() - a.x());
  }
  void add_wheel(std::size_t i, std::size_t side) {
    constexpr int corners = 32;
    const double x = train_.running.wheel_x(i), r = train_.wheel_radius;
    const double z = height(rails_[side], x) + r;
    std::vector<Vec3> rim;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * std::numbers::pi * k / corners;
      rim.emplace_back(x + r * std::cos(angle), aside(side), z + r * std::sin(angle));
    }
    add_cell(io::CellKind::polygon, rim, static_cast<double>(i),
             train_.running.passage().wheel_force(i));
  }

  const TrainView& train_;
  std::array<std::vector<Vec3>, 2> rails_;
  io::Grid grid_;
  io::FieldData wheel_{"wheel", {"-", "number, front first; -1: rail"}, 1, {}},
      force_{"force", {"N", "of the wheel on the rail, down positive; 0: rail"}, 1, {}};
};

}  // namespace

// Collective. Files are written one by one under their final names: an interruption may leave one
// incomplete.
void write_fields(const par::Comm& comm, const FieldFiles& files, const Scene& scene,
                  const TrainView* train) {
  std::error_code error;
  if (comm.root()) std::filesystem::create_directories(files.folder, error);
  comm.agree(error ? "cannot create " + files.folder + ": " + error.message() : "");
  const auto write = [&](std::string_view part, const auto& grid) {
    if (std::find(files.parts.begin(), files.parts.end(), part) == files.parts.end()) return;
    const std::string name = fmt::format("{}_{}.vtkhdf", files.name, part);
    io::write_fields(comm, files.folder + "/" + name, grid(), files.origin);
    const std::string series = fmt::format("{}/{}.vtkhdf.series", files.folder, part);
    comm.agree(comm.root() ? enter_in_series(series, name, files.time) : "");
  };
  if (scene.stones) {
    write("stones", [&] { return stone_shapes(scene.particles, scene.gravity); });
    write("contacts", [&] { return contact_lines(scene.particles); });
  }
  if (scene.bonds) write("bonds", [&] { return bond_lines(scene.particles); });
  if (scene.ground) write("ground", [&] { return scene.ground->fields(); });
  if (!scene.surfaces.empty())
    write("surfaces", [&] { return surface_triangles(scene, comm.root()); });
  if (train && scene.sleepers)
    write("train", [&] {
      io::Grid grid = TrainShape(scene, *train).take();
      return comm.root() ? std::move(grid) : empty_like(grid);
    });
  if (scene.bodies) write("solids", [&] { return scene.bodies->fields(comm); });
}

}  // namespace trackbed::observe
