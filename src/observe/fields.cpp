// Field files for ParaView at one instant: stones in their shapes, contacts, ground, bodies,
// surfaces and the train. Every rank writes its own stones and contacts, so the order of rows
// depends on the ranks; what all ranks know is written by the root.
#include "trackbed/io/fields.hpp"

#include <algorithm>
#include <limits>

#include "observe/field_series.hpp"
#include "trackbed/track/rail.hpp"

namespace trackbed::observe {

namespace {

// Polyhedra as their faces, balls as points with a radius, which a viewer shows as spheres. Values
// are those of cells, since all corners of a stone have the same.
io::Grid stone_shapes(const dem::Particles& particles, double gravity) {
  io::Grid grid;
  io::FieldData radius{"radius", {"m", "of a ball; of the ball around a piece with faces"}, 1, {}},
      velocity{"velocity", {"m/s", "of the stone's centre of mass"}, 3, {}},
      force{"force", {"N", "sum of the contact forces on the stone, dashpots included"}, 3, {}},
      acceleration{
          "acceleration", {"m/s2", "of the centre of mass in the last sub-step, no filter"}, 3, {}},
      id{"stone", {"-", "number of the stone"}, 1, {}, true};
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
// force is a vector on it, and its magnitude can be the width of a tube. Warp By Vector of
// `to_centre` moves the ends to the centres of mass of the stones.
io::Grid contact_lines(const dem::Particles& particles) {
  io::Grid grid;
  grid.kind = io::CellKind::line;
  io::FieldData force{"force", {"N", "of the springs, on the first of the two pieces"}, 3, {}},
      size{"force_size", {"N", "magnitude of the force"}, 1, {}},
      overlap{"overlap", {"m", "of the two pieces"}, 1, {}},
      stone{"stone",
            {"-", "number of the stone at this end; a surface: -1 - its number"},
            1,
            {},
            true},
      to_centre{"to_centre",
                {"m", "from this end to the centre of mass of its stone; surface: 0"},
                3,
                {}};
  particles.contacts([&](const dem::ContactView& contact) {
    const auto first = static_cast<std::int64_t>(grid.points.size());
    grid.points.insert(grid.points.end(), {contact.from, contact.to});
    grid.cells.insert(grid.cells.end(), {first, first + 1});
    for (int k = 0; k < 3; ++k) force.values.push_back(contact.force[k]);
    stone.values.push_back(static_cast<double>(contact.first));
    stone.values.push_back(static_cast<double>(contact.second));
    for (const Vec3& way :
         {Vec3(contact.first_centre - contact.from), Vec3(contact.second_centre - contact.to)})
      for (int k = 0; k < 3; ++k) to_centre.values.push_back(way[k]);
    size.values.push_back(contact.force.norm());
    overlap.values.push_back(contact.overlap);
  });
  grid.point_data = {std::move(stone), std::move(to_centre)};
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
      kind{"kind", {"-", "number of the [[bond]]"}, 1, {}, true};
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

// At the end of the last window. Known to all ranks.
io::Grid surface_triangles(const Scene& scene) {
  io::Grid grid;
  grid.kind = io::CellKind::triangle;
  io::FieldData number{"surface", {"-", "number of the surface"}, 1, {}, true},
      part{"part",
           {"-", "0 wall or floor, 1 plate or box, 2 sleeper, 3 platen, 4 tine"},
           1,
           {},
           true};
  for (std::size_t n = 0; n < scene.surfaces.size(); ++n) {
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

// m, to the left.
double aside(const TrainView& train, std::size_t side) {
  return train.rails == 1 ? 0 : (side == 0 ? 0.5 : -0.5) * train.gauge;
}

// Points of a rail above the sleepers, as the surfaces are drawn: without the pads' compression.
std::vector<Vec3> rail_above(const Scene& scene, double y) {
  std::vector<Vec3> points;
  for (const SceneSurface& each : scene.surfaces)
    if (each.part == SceneSurface::Part::sleeper) {
      double highest = -std::numeric_limits<double>::infinity();
      const Surface& sleeper = *each.surface;
      for (std::size_t k = 0; k < sleeper.nodes(); ++k)
        highest = std::max(highest, sleeper.position[k].z() + sleeper.motion[k].z());
      points.emplace_back(scene.sleepers->x(points.size()), y, highest + track::drawn_rail_height);
    }
  return points;
}

io::Grid rails_and_wheels(const Scene& scene, const TrainView& train) {
  TrainGrid grid;
  std::vector<std::vector<Vec3>> rails;
  for (std::size_t side = 0; side < train.rails; ++side) {
    rails.push_back(rail_above(scene, aside(train, side)));
    grid.add_rail(rails.back());
  }
  for (std::size_t i = 0; i < train.running.train().wheels().size(); ++i) {
    const std::size_t side = i % train.rails;
    const double x = train.running.wheel_x(i);
    grid.add_wheel({x, aside(train, side), height_of_rail(rails[side], x)}, train.wheel_radius, i,
                   train.running.passage().wheel_force(i));
  }
  return grid.take(false);
}

}  // namespace

// Collective. Files are written one by one under their final names: an interruption may leave one
// incomplete.
void write_fields(const par::Comm& comm, const FieldFiles& files, const Scene& scene,
                  const TrainView* train) {
  FieldSeries series(comm, files);
  if (scene.stones) {
    series.write("stones", [&] { return stone_shapes(scene.particles, scene.gravity); });
    series.write("contacts", [&] { return contact_lines(scene.particles); });
  }
  if (scene.bonds) series.write("bonds", [&] { return bond_lines(scene.particles); });
  if (scene.ground) series.write("ground", [&] { return scene.ground->fields(); });
  if (!scene.surfaces.empty())
    series.write_on_root("surfaces", [&] { return surface_triangles(scene); });
  if (train && scene.sleepers)
    series.write_on_root("train", [&] { return rails_and_wheels(scene, *train); });
  if (scene.bodies) series.write("solids", [&] { return scene.bodies->fields(comm); });
}

}  // namespace trackbed::observe
