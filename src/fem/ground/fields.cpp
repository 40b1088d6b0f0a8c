// Field output of the ground: elements with their results.
//
// Stress since settling and static stress are separate, so that a reader can add them; quantities
// that are not additive (principal stresses, shear, extremes) are of their sum.
#include <algorithm>
#include <array>

#include "fem/ground/impl.hpp"

namespace trackbed::fem {

namespace {

// The `impl` arguments below are `auto` because Ground::Impl may be named by members only.

// Points are all nodes that this rank holds; unused ghost nodes are harmless.
void add_points(const auto& impl, const Nodal& velocity_everywhere,
                const Nodal& acceleration_everywhere, io::Grid& grid) {
  const Mesh& mesh = impl.mesh;
  const Lattice& lattice = mesh.lattice;
  io::FieldData displacement{"displacement", {"m", "of each node"}, 3, {}},
      velocity{"velocity", {"m/s", "of each node"}, 3, {}},
      acceleration{"acceleration", {"m/s2", "of each node"}, 3, {}};
  const std::size_t faces = lattice.plane ? 2 : 1;  // a plane node is on both faces
  for (std::size_t n = 0; n < mesh.nodes(); ++n)
    for (std::size_t face = 0; face < faces; ++face) {
      const auto node = static_cast<std::int32_t>(n);
      Vec3 x = mesh.position(node);
      if (lattice.plane) x.y() = lattice.low.y() + static_cast<double>(face) * lattice.size.y();
      const Vec3 u = impl.vector(impl.state.displacement, node);
      const Vec3 v = impl.vector(velocity_everywhere, node);
      const Vec3 a = impl.vector(acceleration_everywhere, node);
      grid.points.push_back(x);
      displacement.values.insert(displacement.values.end(), u.begin(), u.end());
      velocity.values.insert(velocity.values.end(), v.begin(), v.end());
      acceleration.values.insert(acceleration.values.end(), a.begin(), a.end());
    }
  grid.point_data = {displacement, velocity, acceleration};
}

void add_cell(const Mesh& mesh, std::size_t element, io::Grid& grid) {
  if (mesh.imported) {  // already in VTK's order
    for (const std::int32_t node : mesh.imported->corner[element]) grid.cells.push_back(node);
    return;
  }
  const Lattice& lattice = mesh.lattice;
  const std::int64_t faces = lattice.plane ? 2 : 1;
  for (const std::size_t at : vtk_corner) {
    const int k = static_cast<int>(at);
    const int corner = lattice.plane ? (k & 1) | (k >> 2) << 1 : k;
    const std::int64_t face = lattice.plane ? k >> 1 & 1 : 0;
    grid.cells.push_back(mesh.corner(element, corner) * faces + face);
  }
}

template <class Numbers>
void put(io::FieldData& field, const Numbers& numbers) {
  field.values.insert(field.values.end(), numbers.begin(), numbers.end());
}

// The fields do not depend on whether an element of this rank has yielded: every rank has the same.
void add_plastic(const auto& impl, io::Grid& grid) {
  io::FieldData strain{"plastic_strain", {"-", "equivalent plastic strain"}, 1, {}},
      work{"plastic_work", {"J", "of the element"}, 1, {}};
  for (std::size_t z = 0; z < impl.mesh.element.size(); ++z) {
    if (!impl.mesh.writes(z)) continue;
    strain.values.push_back(impl.plasticity->equivalent_strain(z));
    work.values.push_back(impl.plasticity->dissipated(z));
  }
  grid.cell_data.push_back(std::move(strain));
  grid.cell_data.push_back(std::move(work));
}

void add_extremes(const auto& impl, io::Grid& grid) {
  for (std::size_t q = 0; q < Extremes::count; ++q) {
    const Extremes::Quantity& quantity = Extremes::quantities()[q];
    std::string name = std::string("extreme_") + quantity.name;
    std::replace(name.begin(), name.end(), ' ', '_');
    io::FieldData field{
        name, {"Pa", std::string(quantity.name) + " in the stage up to now"}, 1, {}};
    for (std::size_t z = 0; z < impl.mesh.element.size(); ++z)
      if (impl.mesh.writes(z))
        field.values.push_back(impl.extremes->values[z * Extremes::count + q]);
    grid.cell_data.push_back(std::move(field));
  }
}

}  // namespace

void Ground::begin_extremes() {
  impl_->extremes = std::make_unique<Extremes>(impl_->mesh.element.size());
}

// Later fields and checkpoints must not show extremes that are no longer updated.
void Ground::end_extremes() { impl_->extremes.reset(); }

// For all elements held: those of other ranks at the borders are not used, and are cheap.
void Ground::take_extremes() {
  if (!impl_->extremes) begin_extremes();  // called in the middle of a stage
  for (std::size_t z = 0; z < impl_->mesh.element.size(); ++z)
    impl_->extremes->take(z,
                          impl_->stress(z, Plasticity::Where::centre, Plasticity::When::static_) +
                              impl_->stress(z, Plasticity::Where::centre, Plasticity::When::since));
}

// Collective because velocities and accelerations of ghosts are exchanged; they do not affect the
// run, but points of elements at rank borders show them.
io::Grid Ground::fields() const {
  const Mesh& mesh = impl_->mesh;
  io::Grid grid;
  grid.kind = mesh.imported ? io::CellKind::quadratic_tetrahedron : io::CellKind::hexahedron;
  Nodal velocity = impl_->state.velocity, acceleration = impl_->state.acceleration;
  impl_->mesh.exchange(velocity);
  impl_->mesh.exchange(acceleration);
  add_points(*impl_, velocity, acceleration, grid);
  io::FieldData stress{
      "stress_change", {"Pa", "xx yy zz xy yz zx, since the static equilibrium"}, 6, {}};
  io::FieldData static_stress{
      "stress_static", {"Pa", "xx yy zz xy yz zx, in static equilibrium"}, 6, {}},
      solid{"solid", {"-", "number of the solid"}, 1, {}};
  io::FieldData principals{
      "principal_stress", {"Pa", "of the sum of both stresses, largest first"}, 3, {}};
  io::FieldData shear{
      "largest_shear_stress", {"Pa", "half the difference of principal stresses"}, 1, {}};
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    if (!mesh.writes(z)) continue;
    add_cell(mesh, z, grid);
    const Vec6 now = impl_->stress(z, Plasticity::Where::centre, Plasticity::When::since);
    const Vec6 then = impl_->stress(z, Plasticity::Where::centre, Plasticity::When::static_);
    const Vec3 values = principal(now + then).value;
    put(stress, now);
    put(static_stress, then);
    put(principals, values);
    shear.values.push_back(0.5 * (values.x() - values.z()));
    solid.values.push_back(mesh.solids.region[static_cast<std::size_t>(mesh.solid[z])]);
  }
  grid.cell_data = {stress, static_stress, solid, principals, shear};
  if (impl_->plasticity) add_plastic(*impl_, grid);
  if (impl_->extremes) add_extremes(*impl_, grid);
  return grid;
}

}  // namespace trackbed::fem
