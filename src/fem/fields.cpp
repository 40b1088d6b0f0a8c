// The ground as a picture: elements with what a viewer colours them by.
//
// Stress since settling and at rest stay apart, so that a reader may add both; what is not additive
// (principal stresses, shear, extremes) is of their sum.
#include <array>

#include "room.hpp"

namespace trackbed::fem {

namespace {

// `room` below is the ground's, whose type only its members may name.

// Corners in VTK's order, as bits x, y, z.
constexpr std::array<int, 8> vtk_corner = {0, 1, 3, 2, 4, 5, 7, 6};

// Points are all nodes this rank holds; those of ghosts that no own cell uses do no harm.
void add_points(const auto& room, const Nodal& velocity_everywhere,
                const Nodal& acceleration_everywhere, io::Grid& grid) {
  const Mesh& mesh = room.mesh;
  const Lattice& lattice = mesh.lattice;
  io::FieldData displacement{"displacement (m)", 3, {}}, velocity{"velocity (m/s)", 3, {}},
      acceleration{"acceleration (m/s^2)", 3, {}};
  const std::size_t faces = lattice.plane ? 2 : 1;  // a plane node stands on both faces
  for (std::size_t n = 0; n < mesh.nodes(); ++n)
    for (std::size_t face = 0; face < faces; ++face) {
      const auto node = static_cast<std::int32_t>(n);
      Vec3 x = mesh.position(node);
      if (lattice.plane) x.y() = lattice.low.y() + static_cast<double>(face) * lattice.size.y();
      const Vec3 u = room.vector(room.state.displacement, node);
      const Vec3 v = room.vector(velocity_everywhere, node);
      const Vec3 a = room.vector(acceleration_everywhere, node);
      grid.points.push_back(x);
      displacement.values.insert(displacement.values.end(), u.begin(), u.end());
      velocity.values.insert(velocity.values.end(), v.begin(), v.end());
      acceleration.values.insert(acceleration.values.end(), a.begin(), a.end());
    }
  grid.point_data = {displacement, velocity, acceleration};
}

void add_cell(const Mesh& mesh, std::size_t zone, io::Grid& grid) {
  if (mesh.imported) {  // in VTK's order as they are
    for (const std::int32_t node : mesh.imported->corner[zone]) grid.cells.push_back(node);
    return;
  }
  const Lattice& lattice = mesh.lattice;
  const std::int64_t faces = lattice.plane ? 2 : 1;
  for (const int k : vtk_corner) {
    const int corner = lattice.plane ? (k & 1) | (k >> 2) << 1 : k;
    const std::int64_t face = lattice.plane ? k >> 1 & 1 : 0;
    grid.cells.push_back(mesh.corner(zone, corner) * faces + face);
  }
}

template <class Numbers>
void put(io::FieldData& field, const Numbers& numbers) {
  field.values.insert(field.values.end(), numbers.begin(), numbers.end());
}

// Whether an element yields by itself does not decide which fields there are: every rank has the
// same.
void add_plastic(const auto& room, io::Grid& grid) {
  io::FieldData strain{"equivalent plastic strain", 1, {}}, work{"plastic work (J)", 1, {}};
  for (std::size_t z = 0; z < room.mesh.zone.size(); ++z) {
    if (!room.mesh.writes(z)) continue;
    strain.values.push_back(room.plasticity->sheared(z));
    work.values.push_back(room.plasticity->lost(z));
  }
  grid.cell_data.push_back(std::move(strain));
  grid.cell_data.push_back(std::move(work));
}

void add_extremes(const auto& room, io::Grid& grid) {
  for (std::size_t q = 0; q < Extremes::count; ++q) {
    io::FieldData field{std::string("so far: ") + Extremes::quantities()[q].name + " (Pa)", 1, {}};
    for (std::size_t z = 0; z < room.mesh.zone.size(); ++z)
      if (room.mesh.writes(z))
        field.values.push_back(room.extremes->values[z * Extremes::count + q]);
    grid.cell_data.push_back(std::move(field));
  }
}

}  // namespace

void Ground::begin_extremes() {
  room_->extremes = std::make_unique<Extremes>(room_->mesh.zone.size());
}

// Not one more picture or checkpoint shows what no instant adds to.
void Ground::end_extremes() { room_->extremes.reset(); }

// Of all zones held: those of others at rank borders are never looked at, and cheap.
void Ground::take_extremes() {
  if (!room_->extremes) begin_extremes();  // asked for amid a stage
  for (std::size_t z = 0; z < room_->mesh.zone.size(); ++z)
    room_->extremes->take(z,
                          room_->stress(z, Plasticity::Where::centre, Plasticity::When::rest) +
                              room_->stress(z, Plasticity::Where::centre, Plasticity::When::since));
}

// Collective because of velocities and accelerations of ghosts, which do not matter to the run;
// points of zones at rank borders show them.
io::Grid Ground::fields() const {
  const Mesh& mesh = room_->mesh;
  io::Grid grid;
  grid.kind = mesh.imported ? io::CellKind::quadratic_tetrahedron : io::CellKind::hexahedron;
  Nodal velocity = room_->state.velocity, acceleration = room_->state.acceleration;
  room_->mesh.exchange(velocity);
  room_->mesh.exchange(acceleration);
  add_points(*room_, velocity, acceleration, grid);
  io::FieldData stress{"stress since settling, xx yy zz xy yz zx (Pa)", 6, {}};
  io::FieldData rest{"stress at rest, xx yy zz xy yz zx (Pa)", 6, {}}, solid{"solid", 1, {}};
  io::FieldData principals{"principal stresses, rest and since, largest first (Pa)", 3, {}};
  io::FieldData shear{"largest shear stress, rest and since (Pa)", 1, {}};
  for (std::size_t z = 0; z < mesh.zone.size(); ++z) {
    if (!mesh.writes(z)) continue;
    add_cell(mesh, z, grid);
    const Vec6 now = room_->stress(z, Plasticity::Where::centre, Plasticity::When::since);
    const Vec6 then = room_->stress(z, Plasticity::Where::centre, Plasticity::When::rest);
    const Vec3 values = principal(now + then).value;
    put(stress, now);
    put(rest, then);
    put(principals, values);
    shear.values.push_back(0.5 * (values.x() - values.z()));
    solid.values.push_back(mesh.solids.region[static_cast<std::size_t>(mesh.solid[z])]);
  }
  grid.cell_data = {stress, rest, solid, principals, shear};
  if (room_->plasticity) add_plastic(*room_, grid);
  if (room_->extremes) add_extremes(*room_, grid);
  return grid;
}

}  // namespace trackbed::fem
