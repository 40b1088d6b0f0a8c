// Cells of an embankment cut into tetrahedra.
//
// Five tetrahedra per cell: one between four corners of which no two share an edge, and one at each
// of the other four corners. Cells alternate between the two sets of four corners, so that the
// diagonals of faces conform, and with an even number of columns the mesh is symmetric about the
// axis. Rejected: six along one diagonal, which are a fifth more, have one more node per cell, and
// are not symmetric.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "fem/mesh/embankment.hpp"
#include "fem/shape/tetrahedron.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Corners of a cell: bits are x, y, z. For cells with an even sum of indices; cells with an odd sum
// use the opposite corners along x.
constexpr std::array<std::array<int, 4>, 5> parts = {
    {{0, 3, 5, 6}, {0, 3, 5, 1}, {0, 3, 6, 2}, {0, 5, 6, 4}, {3, 5, 6, 7}}};

BorderKind held_by(Base base) {
  return base == Base::fixed ? BorderKind::fixed : BorderKind::viscous;
}

BorderKind held_by(Sides sides) {
  require(sides != Sides::free_field && sides != Sides::periodic,
          "sides of an embankment are neither free_field nor periodic");
  if (sides == Sides::free) return BorderKind::free;
  if (sides == Sides::fixed) return BorderKind::fixed;
  return sides == Sides::viscous ? BorderKind::viscous : BorderKind::roller;
}

class Builder {
 public:
  explicit Builder(const GroundParameters& parameters)
      : parameters_(parameters),
        embankment_(parameters),
        solids_(parameters, make_lattice(parameters, Dimension::space, 1)) {}
  SolidMesh build();

 private:
  using Corners = std::array<Index3, 4>;
  void add_cell(const Index3& cell);
  void add_part(const Index3& cell, Corners corners);
  void take_faces(const Index3& cell, std::int32_t element, const Corners& corners);
  void take_face(const Index3& cell, SolidMesh::Face face, const std::array<Index3, 3>& corners);
  int solid_of(const Index3& cell) const;
  std::int32_t corner(const Index3& point);
  void number_nodes();
  Vec3 place(const Index3& point) const { return embankment_.corner(point); }
  // Number, in a lattice twice as fine, of the point midway between two lattice points, or of one
  // (given twice).
  Id between(const Index3& a, const Index3& b) const;

  const GroundParameters& parameters_;
  Embankment embankment_;
  Solids solids_;
  SolidMesh mesh_;
  std::vector<std::array<Id, 10>> wide_;  // nodes in the fine lattice
  std::map<Id, Vec3> places_;             // of these nodes
};

Id Builder::between(const Index3& a, const Index3& b) const {
  const Index3& cells = embankment_.cells();
  return a[0] + b[0] + (2 * cells[0] + 1) * (a[1] + b[1] + (2 * cells[1] + 1) * (a[2] + b[2]));
}

// Solid of the block whose outline contains the middle of the cell, else of the layer of its row.
int Builder::solid_of(const Index3& cell) const {
  Vec3 centre = Vec3::Zero();
  for (int k = 0; k < 8; ++k)
    centre += place({cell[0] + (k & 1), cell[1] + (k >> 1 & 1), cell[2] + (k >> 2)}) / 8;
  const int block = block_at(parameters_, centre);
  return solids_.in(block >= 0 ? block : embankment_.layer(cell[2]), cell[0]);
}

void Builder::add_cell(const Index3& cell) {
  // Counted from the far side: half an embankment has the elements of that half of the whole.
  const int flip = static_cast<int>((cell[0] + embankment_.cells()[1] - 1 - cell[1] + cell[2]) % 2);
  const int solid = solid_of(cell);
  for (const auto& part : parts) {
    Corners corners;
    for (std::size_t c = 0; c < 4; ++c) {
      const int bits = part[c] ^ flip;
      corners[c] = {cell[0] + (bits & 1), cell[1] + (bits >> 1 & 1), cell[2] + (bits >> 2)};
    }
    mesh_.solid.push_back(solid);
    add_part(cell, corners);
  }
}

void Builder::add_part(const Index3& cell, Corners corners) {
  constexpr std::array<std::array<std::size_t, 2>, 6> ends = {
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  const auto at = [&](std::size_t c) { return place(corners[c]); };
  if ((at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0)) < 0)
    std::swap(corners[1], corners[2]);
  TenNodes nodes;
  auto& wide = wide_.emplace_back();
  for (std::size_t c = 0; c < 4; ++c) nodes[c] = at(c), wide[c] = between(corners[c], corners[c]);
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [a, b] = ends[e];
    nodes[4 + e] = (nodes[a] + nodes[b]) / 2, wide[4 + e] = between(corners[a], corners[b]);
  }
  for (std::size_t n = 0; n < 10; ++n) places_.emplace(wide[n], nodes[n]);
  if (const double ratio = tetrahedron_mean_ratio(nodes); !(ratio >= least_mean_ratio))
    throw InputError({fmt::format(
        "ground.section: a tetrahedron at x = {:.3g}, y = {:.3g}, z = {:.3g} m is "
        "flat: its shape quality (mean ratio, 1: equilateral) is {:.2g} and must be at least {:g}; "
        "change the elements or the sections",
        nodes[0].x(), nodes[0].y(), nodes[0].z(), ratio, least_mean_ratio)});
  take_faces(cell, static_cast<std::int32_t>(wide_.size()) - 1, corners);
}

// Corners of a face on a side of its cell have one equal lattice index.
void Builder::take_faces(const Index3& cell, std::int32_t element, const Corners& corners) {
  for (std::size_t side = 0; side < 4; ++side) {
    std::array<Index3, 3> of;
    for (std::size_t k = 0; k < 3; ++k)
      of[k] = corners[static_cast<std::size_t>(tetrahedron_faces[side][k])];
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (of[0][axis] == of[1][axis] && of[0][axis] == of[2][axis])
        take_face(cell,
                  {element, static_cast<std::int32_t>(side), BorderKind::free,
                   static_cast<int>(axis), of[0][axis] == cell[axis]},
                  of);
  }
}

// For faces of the boundary. Slopes and the natural ground beside them are free and so are not
// borders. A vertical boundary where the ground ends is a side of the ground, as `check` ensures.
void Builder::take_face(const Index3& cell, SolidMesh::Face face,
                        const std::array<Index3, 3>& corners) {
  const auto axis = static_cast<std::size_t>(face.axis);
  if (cell[axis] != (face.low ? 0 : embankment_.cells()[axis] - 1)) return;
  if (face.axis == 2 && !face.low) return mesh_.top.push_back(face);
  const bool slopes = face.axis == 1 && std::any_of(corners.begin(), corners.end(), [&](auto& at) {
                        return !embankment_.ends_at(place(at).y());
                      });
  if (slopes) return;
  face.holds =
      face.axis == 2 ? held_by(parameters_.base) : held_by(parameters_.side(face.axis, !face.low));
  mesh_.borders.push_back(face);
}

// In the order of the fine lattice.
void Builder::number_nodes() {
  std::vector<Id> known;
  for (const auto& [wide, at] : places_) known.push_back(wide), mesh_.position.push_back(at);
  for (const auto& wide : wide_) {
    auto& nodes = mesh_.element.emplace_back();
    for (std::size_t n = 0; n < 10; ++n)
      nodes[n] = static_cast<std::int32_t>(std::lower_bound(known.begin(), known.end(), wide[n]) -
                                           known.begin());
  }
}

SolidMesh Builder::build() {
  const Index3& cells = embankment_.cells();
  for (std::int64_t k = 0; k < cells[2]; ++k)
    for (std::int64_t j = 0; j < cells[1]; ++j)
      for (std::int64_t i = 0; i < cells[0]; ++i)
        if (embankment_.holds({i, j, k})) add_cell({i, j, k});
  number_nodes();
  return std::move(mesh_);
}

}  // namespace

SolidMesh embankment_mesh(const GroundParameters& parameters) {
  return Builder(parameters).build();
}

}  // namespace trackbed::fem
