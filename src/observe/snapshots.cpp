// The contact network and the stones at one instant, as tables for plots and as field files for
// ParaView.
// Every rank writes its own stones and contacts, so the order of rows depends on the ranks.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "observe/impl.hpp"
#include "trackbed/io/fields.hpp"

namespace trackbed::observe {

namespace {

// Plots are in the plane of the track, x and z, also for a bed in space. Field files contain all
// three coordinates.
struct Network {
  std::vector<double> segments, force;  // x0 z0 x1 z1 of the two centres; |F|
};

// N and m, on this rank. A contact between two ranks is included on one of them only.
Network network_of(const dem::Particles& particles) {
  Network network;
  particles.contacts([&](const dem::ContactView& contact) {
    network.segments.insert(network.segments.end(),
                            {contact.from.x(), contact.from.z(), contact.to.x(), contact.to.z()});
    network.force.push_back(contact.force.norm());
  });
  return network;
}

// Pebbles, m, since plots show disks; for polyhedra the bounding spheres of their pieces.
struct Stones {
  std::vector<double> centre, radius;
};

Stones stones_of(const dem::Particles& particles) {
  Stones stones;
  for (std::size_t i = 0; i < particles.size(); ++i)
    particles.pieces(i, [&](const Vec3& centre, double radius) {
      stones.centre.insert(stones.centre.end(), {centre.x(), centre.z()});
      stones.radius.push_back(radius);
    });
  return stones;
}

// Points with a radius, which a viewer shows as spheres: for polyhedra the bounding spheres of
// their pieces.
io::Grid stone_points(const dem::Particles& particles) {
  io::Grid grid;
  io::FieldData radius{"radius", {"m", "of the piece"}, 1, {}},
      velocity{"velocity", {"m/s", "of the stone"}, 3, {}},
      id{"stone", {"-", "number of the stone"}, 1, {}};
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView stone = particles[i];
    particles.pieces(i, [&](const Vec3& centre, double r) {
      grid.cells.push_back(static_cast<std::int64_t>(grid.points.size()));
      grid.points.push_back(centre);
      radius.values.push_back(r);
      id.values.push_back(static_cast<double>(stone.id));
      for (int k = 0; k < 3; ++k) velocity.values.push_back(stone.velocity[k]);
    });
  }
  grid.point_data = {std::move(radius), std::move(velocity), std::move(id)};
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

}  // namespace

// Collective.
void Results::snapshot(const std::string& stage, const Scene& scene, double cell) {
  const Network network = network_of(scene.particles);
  const Stones stones = stones_of(scene.particles);
  std::vector<double> sieved;
  for (std::size_t i = 0; i < scene.particles.size(); ++i) {
    const dem::ParticleView stone = scene.particles[i];
    sieved.insert(sieved.end(), {stone.size, stone.mass});
  }
  // The same on all ranks; rank 0 writes it.
  const std::vector<double> surface =
      cell > 0 ? surface_of(impl_->comm, scene.particles, cell) : std::vector<double>{};
  const std::span<const double> own(surface.data(), impl_->comm.root() ? surface.size() : 0);
  impl_->replace([&](io::File& file) {
    // One group per stage: names of stages are unique.
    const std::string chains = "chains/" + stage, pebbles = "stones/" + stage;
    file.write<double>(chains + "/segments", network.segments, 4,
                       {"m", "x and z of the centres of the two pieces of each contact"});
    file.write<double>(chains + "/force", network.force, 1,
                       {"N", "magnitude of each contact force"});
    file.write<double>(pebbles + "/centre", stones.centre, 2, {"m", "x and z of each pebble"});
    file.write<double>(pebbles + "/sieved", sieved, 2,
                       {"m, kg", "of each stone: smallest opening that it passes, and mass"});
    if (cell > 0)
      file.write<double>("surface/" + stage + "/top", own, 3,
                         {"m", "x, y of each cell, and z of the highest stone in the cell"});
    file.write<double>(pebbles + "/radius", stones.radius, 1, {"m", "of each pebble"});
    if (!impl_->times.empty()) impl_->append_to(file);  // saves a flush
  });
}

// Collective. Files are written one by one under their final names: an interruption may leave one
// incomplete.
void write_pictures(const par::Comm& comm, const FieldFiles& files, const Scene& scene) {
  std::error_code error;
  if (comm.root()) std::filesystem::create_directories(files.folder, error);
  comm.agree(error ? "cannot create " + files.folder + ": " + error.message() : "");
  const auto write = [&](std::string_view part, const auto& grid) {
    if (std::find(files.parts.begin(), files.parts.end(), part) == files.parts.end()) return;
    const std::string name = fmt::format("{}_{}.vtkhdf", files.name, part);
    io::write_fields(comm, files.folder + "/" + name, grid());
    const std::string series = fmt::format("{}/{}.vtkhdf.series", files.folder, part);
    comm.agree(comm.root() ? enter_in_series(series, name, files.time) : "");
  };
  if (scene.stones) {
    write("stones", [&] { return stone_points(scene.particles); });
    write("contacts", [&] { return contact_lines(scene.particles); });
  }
  if (scene.ground) write("ground", [&] { return scene.ground->fields(); });
  if (scene.bodies) write("solids", [&] { return scene.bodies->fields(comm); });
}

}  // namespace trackbed::observe
