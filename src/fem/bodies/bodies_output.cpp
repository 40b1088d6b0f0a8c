// Checkpoints and fields of solid bodies. Rank 0 writes the state, which is the same on all ranks;
// all ranks read all of it, so a run resumes on any number of ranks. Shape, matrices and factor are
// not stored: they follow from the deck in the same file.
#include <array>

#include "fem/bodies/bodies_impl.hpp"
#include "fem/material/mohr_coulomb.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// The state, listed once: what a checkpoint holds.
struct Item {
  const char *name, *unit, *meaning;
  BodiesSystem::Vector BodiesSystem::*of;
};
constexpr std::array state_items{
    Item{"displacement", "m", "of each node of the solids, from where it was placed",
         &BodiesSystem::displacement},
    Item{"velocity", "m/s", "of each node of the solids", &BodiesSystem::velocity},
    Item{"acceleration", "m/s^2", "of each node of the solids", &BodiesSystem::acceleration}};

// Corners in VTK's order, as bits x, y, z.
constexpr std::array<std::size_t, 8> vtk_corner = {0, 1, 3, 2, 4, 5, 7, 6};

template <class Numbers>
void put(io::FieldData& field, const Numbers& numbers) {
  field.values.insert(field.values.end(), numbers.begin(), numbers.end());
}

std::int32_t nodes_of(const std::vector<BodyMesh>& meshes) {
  return meshes.empty() ? 0 : meshes.back().first + meshes.back().nodes();
}

}  // namespace

void Bodies::save(io::File& file, const std::string& group, const par::Comm& comm) const {
  const std::int32_t nodes = comm.root() ? nodes_of(impl_->meshes) : 0;
  for (const Item& item : state_items) {
    std::vector<double> rows;
    for (std::int32_t n = 0; n < nodes; ++n) {
      const Vec3 value = impl_->system.of(impl_->system.*item.of, n);
      rows.insert(rows.end(), value.begin(), value.end());
    }
    file.write<double>(group + "/" + item.name, rows, 3, {item.unit, item.meaning});
  }
  std::vector<double> common;
  if (comm.root())
    common = {impl_->origin.x(), impl_->origin.y(), impl_->origin.z(),
              impl_->system.begun() ? 1.0 : 0.0};
  file.write<double>(group + "/origin", common, 1,
                     {"m, -", "x, y, z where the solids were placed; whether they have moved"});
}

void Bodies::load(const io::File& file, const std::string& group) {
  const auto common = file.read_all<double>(group + "/origin");
  if (common.size() != 4) throw RunError(group + "/origin does not hold the state of solids");
  place({common[0], common[1], common[2]});
  const std::int32_t nodes = nodes_of(impl_->meshes);
  for (const Item& item : state_items) {
    const auto rows = file.read_all<double>(group + "/" + item.name);
    if (rows.size() != 3 * static_cast<std::size_t>(nodes))
      throw RunError(group + "/" + item.name + " belongs to solids of another shape");
    for (std::int32_t n = 0; n < nodes; ++n) {
      const double* row = rows.data() + 3 * n;
      impl_->system.put(n, {row[0], row[1], row[2]}, impl_->system.*item.of);
    }
  }
  impl_->system.resume(common[3] != 0);
  show_at_rest();
}

io::Grid Bodies::fields(const par::Comm& comm) const {
  io::Grid grid;
  grid.kind = io::CellKind::hexahedron;
  io::FieldData displacement{"displacement (m)", 3, {}}, velocity{"velocity (m/s)", 3, {}};
  io::FieldData stress{"stress, xx yy zz xy yz zx (Pa)", 6, {}}, number{"body", 1, {}};
  io::FieldData principals{"principal stresses, largest first (Pa)", 3, {}};
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
