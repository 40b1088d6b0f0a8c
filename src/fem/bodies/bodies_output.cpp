// State and fields of solid bodies. Shape, matrices and factor are not stored: they follow from the
// deck.
#include <array>

#include "fem/bodies/bodies_impl.hpp"
#include "fem/material/mohr_coulomb.hpp"

namespace trackbed::fem {

namespace {

template <class Numbers>
void put(io::FieldData& field, const Numbers& numbers) {
  field.values.insert(field.values.end(), numbers.begin(), numbers.end());
}

std::int32_t nodes_of(const std::vector<BodyMesh>& meshes) {
  return meshes.empty() ? 0 : meshes.back().first + meshes.back().nodes();
}

}  // namespace

// As rows of nodes, with zeros for fixed components.
void Bodies::archive(io::Archive& a) {
  BodiesSystem& system = impl_->system;
  bool moved = system.begun();
  a("origin", impl_->origin, {"m", "where the solids were placed"});
  a("moved", moved, {"-", "1: the solids have moved since they were placed; else 0"});
  if (a.reads()) place(impl_->origin);
  const auto nodal = [&](const char* name, const io::Label& label, BodiesSystem::Vector& values) {
    std::vector<Vec3> nodes;
    for (std::int32_t n = 0; n < nodes_of(impl_->meshes); ++n)
      nodes.push_back(system.of(values, n));
    a.rows(name, nodes, label);
    for (std::size_t n = 0; n < nodes.size() && a.reads(); ++n)
      system.put(static_cast<std::int32_t>(n), nodes[n], values);
  };
  nodal("displacement", {"m", "of each node of the solids, since they were placed"},
        system.displacement);
  nodal("velocity", {"m/s", "of each node of the solids"}, system.velocity);
  nodal("acceleration", {"m/s^2", "of each node of the solids"}, system.acceleration);
  if (!a.reads()) return;
  system.resume(moved);
  show_at_rest();
}

io::Grid Bodies::fields(const par::Comm& comm) const {
  io::Grid grid;
  grid.kind = io::CellKind::hexahedron;
  io::FieldData displacement{"displacement", {"m", "of each node"}, 3, {}},
      velocity{"velocity", {"m/s", "of each node"}, 3, {}};
  io::FieldData stress{"stress", {"Pa", "xx yy zz xy yz zx"}, 6, {}},
      number{"body", {"-", "number of the body"}, 1, {}};
  io::FieldData principals{"principal_stress", {"Pa", "largest first"}, 3, {}};
  const std::size_t bodies = comm.root() ? impl_->meshes.size() : 0;
  for (std::size_t b = 0; b < bodies; ++b) {
    const BodyMesh& mesh = impl_->meshes[b];
    for (std::int32_t n = 0; n < mesh.nodes(); ++n) {
      const std::int32_t node = mesh.first + n;
      grid.points.push_back(impl_->origin + mesh.position(node));
      put(displacement, impl_->system.of(impl_->system.displacement, node));
      put(velocity, impl_->system.of(impl_->system.velocity, node));
    }
    for (std::int64_t e = 0; e < mesh.elements(); ++e) {
      const auto corners = mesh.corners(e);
      for (const std::size_t k : vtk_corner) grid.cells.push_back(corners[k]);
      const Vec3 centre = mesh.lattice.centre(e);
      const std::array<double, 6> found = this->stress(b, centre);
      put(stress, found);
      put(principals, principal(Vec6(found.data())).value);
      number.values.push_back(static_cast<double>(b));
    }
  }
  grid.point_data = {std::move(displacement), std::move(velocity)};
  grid.cell_data = {std::move(stress), std::move(principals), std::move(number)};
  return grid;
}

}  // namespace trackbed::fem
