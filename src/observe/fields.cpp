// Field files for ParaView at one instant: stones in their shapes, contacts, ground, bodies,
// surfaces and the train. Every rank writes its own stones and contacts, so the order of rows
// depends on the ranks; what all ranks know is written by the root.
#include "trackbed/io/fields.hpp"

#include "observe/field_series.hpp"
#include "trackbed/track/rail.hpp"

namespace trackbed::observe {

namespace {

// Polyhedra as their faces, all balls of a stone as points of one cell, with a radius, which a
// viewer shows as spheres. Values are those of cells, since all points of a stone have the same.
io::Grid stone_shapes(const dem::Particles& particles, double gravity) {
  io::Grid grid;
  io::FieldData radius{"radius", {"m", "of a ball; of the ball around a piece with faces"}, 1, {}},
      velocity{"velocity", {"m/s", "of the stone's centre of mass"}, 3, {}},
      rotation{"angular_velocity", {"rad/s", "of the stone"}, 3, {}},
      force{"force", {"N", "sum of the contact forces on the stone, dashpots included"}, 3, {}},
      acceleration{
          "acceleration", {"m/s2", "of the centre of mass in the last sub-step, no filter"}, 3, {}},
      mass{"mass", {"kg", "of the whole stone; plane: over the thickness"}, 1, {}},
      id{"stone", {"-", "number of the stone"}, 1, {}, true};
  std::vector<std::int64_t> nodes, balls;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView stone = particles[i];
    const Vec3 accelerated = stone.acceleration(gravity);
    const auto add = [&](io::CellKind kind, std::span<const std::int64_t> of) {
      grid.add(kind, of);
      id.values.push_back(static_cast<double>(stone.id));
      mass.values.push_back(stone.mass);
      for (int k = 0; k < 3; ++k) {
        velocity.values.push_back(stone.velocity[k]);
        rotation.values.push_back(stone.spin[k]);
        force.values.push_back(stone.force[k]);
        acceleration.values.push_back(accelerated[k]);
      }
    };
    balls.clear();
    particles.outlines(i, [&](const dem::PieceOutline& piece) {
      const auto first = static_cast<std::int64_t>(grid.points.size());
      if (piece.faces.empty()) {
        grid.points.push_back(piece.centre);
        balls.push_back(first);
      }
      grid.points.insert(grid.points.end(), piece.corners.begin(), piece.corners.end());
      for (const std::vector<int>& face : piece.faces) {
        nodes.clear();
        for (const int corner : face) nodes.push_back(first + corner);
        add(io::CellKind::polygon, nodes);
      }
      radius.values.resize(grid.points.size(), piece.radius);
    });
    if (!balls.empty()) add(io::CellKind::poly_vertex, balls);
  }
  grid.point_data = {std::move(radius)};
  grid.cell_data = {std::move(velocity),     std::move(rotation), std::move(force),
                    std::move(acceleration), std::move(mass),     std::move(id)};
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
  io::FieldData number{"surface", {"-", "number of the surface, as in the contacts"}, 1, {}, true},
      part{"part",
           {"-", "0 wall or floor, 1 plate or box, 2 sleeper, 3 platen, 4 tine"},
           1,
           {},
           true},
      moved{"sleeper_displacement",
            {"m", "of a sleeper's centre since it was placed, contained in the shape; others: 0"},
            3,
            {}};
  std::size_t sleeper = 0;
  for (const SceneSurface& shown : scene.surfaces) {
    const Surface& surface = *shown.surface;
    const bool is_sleeper = shown.part == SceneSurface::Part::sleeper && scene.sleepers;
    const Vec3 displacement =
        is_sleeper ? scene.sleepers->state(sleeper++).displacement : Vec3(Vec3::Zero());
    const auto first = static_cast<std::int64_t>(grid.points.size());
    for (std::size_t k = 0; k < surface.nodes(); ++k)
      grid.points.emplace_back(surface.position[k] + surface.motion[k]);
    for (const auto& triangle : surface.triangles) {
      for (const std::int32_t node : triangle) grid.cells.push_back(first + node);
      number.values.push_back(static_cast<double>(shown.number));
      part.values.push_back(static_cast<double>(shown.part));
      for (int k = 0; k < 3; ++k) moved.values.push_back(displacement[k]);
    }
  }
  grid.cell_data = {std::move(number), std::move(part), std::move(moved)};
  return grid;
}

// The model's rail is even whatever the heights of the sleepers: it is drawn on the highest, as if
// the seats of the others were packed up.
io::Grid train_over_bed(const TrainView& train) {
  const double level = train.sleeper_top + train.running.highest_seat() + track::drawn_rail_height;
  return rails_and_wheels(train.running.passage(), train.running.train(),
                          {.origin = train.running.origin(),
                           .wheel_radius = train.wheel_radius,
                           .level = level,
                           .across = [&train](std::size_t side) {
                             return train.rails == 1 ? 0 : (side == 0 ? 0.5 : -0.5) * train.gauge;
                           }});
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
  if (train) series.write_on_root("train", [&] { return train_over_bed(*train); });
  if (scene.bodies) series.write("solids", [&] { return scene.bodies->fields(comm); });
}

}  // namespace trackbed::observe
