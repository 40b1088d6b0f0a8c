// The owner of a node holds all faces around it, so a row of T is complete where its corner is
// owned, and a column where its mid-edge node is. Faces are in the order of the file: results are
// bitwise identical on any number of ranks.
#include "fem/mesh/flat_top.hpp"

#include <algorithm>
#include <cmath>

#include "fem/shape/tetrahedron.hpp"

namespace trackbed::fem {

namespace {

double cross(const Vec3& a, const Vec3& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

FlatTop::FlatTop(Mesh& mesh, const std::vector<double>& mass) : mesh_(mesh), mass_(mass) {
  for (const Imported::Face& face : mesh.imported->top) take(face);
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.corner < b.corner; });
  compute_mass(mass);
}

// With m the mid-edge nodes and x a corner: x = sum l_i m_i, sum l_i = 1, in the plane of the top.
// The area of a corner in a face is that of its quarter: so each face takes the same fraction of
// the corner force as it contributes.
void FlatTop::take(const Imported::Face& face) {
  const Imported& shape = *mesh_.imported;
  const auto& local = tetrahedron_faces[static_cast<std::size_t>(face.side)];
  std::array<std::int32_t, 6> node{};
  std::array<Vec3, 6> x;
  for (std::size_t k = 0; k < 6; ++k) {
    node[k] = mesh_.corner(static_cast<std::size_t>(face.element), local[k]);
    x[k] = mesh_.position(node[k]);
  }
  const double whole = cross(x[4] - x[3], x[5] - x[3]);
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const Vec3& home = x[corner];
    const double quarter =
        0.5 * std::abs(cross(x[3 + corner] - home, x[3 + (corner + 2) % 3] - home));
    const double fraction =
        quarter / shape.area_around(mesh_.node[static_cast<std::size_t>(node[corner])]);
    for (std::size_t m = 0; m < 3; ++m) {
      const Vec3 &next = x[3 + (m + 1) % 3], &last = x[3 + (m + 2) % 3];
      const double l = cross(next - home, last - home) / whole;
      entries_.push_back({node[corner], node[3 + m], fraction * l});
    }
  }
}

std::span<const FlatTop::Entry> FlatTop::row(std::int32_t node) const {
  const auto [first, last] =
      std::equal_range(entries_.begin(), entries_.end(), Entry{node, 0, 0},
                       [](const Entry& a, const Entry& b) { return a.corner < b.corner; });
  return {first, last};
}

Vec3 FlatTop::at(std::int32_t node, const Nodal& values) const {
  const std::span<const Entry> entries = row(node);
  if (entries.empty()) return {values[0][node], values[1][node], values[2][node]};
  Vec3 sum = Vec3::Zero();
  for (const Entry& entry : entries)
    for (int c = 0; c < 3; ++c) sum[c] += entry.weight * values[c][entry.middle];
  return sum;
}

void FlatTop::to_nodes(Nodal& force) const {
  mesh_.exchange(force);
  for (int c = 0; c < 3; ++c) {
    for (const Entry& entry : entries_)
      force[c][entry.middle] += entry.weight * force[c][entry.corner];
    for (const Entry& entry : entries_) force[c][entry.corner] = 0;
    for (std::size_t n = 0; n < mesh_.nodes(); ++n)
      if (mesh_.owned[n] == 0) force[c][n] = 0;
  }
}

double FlatTop::mass(std::int32_t node) const { return mass_[static_cast<std::size_t>(node)]; }

// Row i of |T| M^-1 |T|' summed: sum_k |T_ik| s_k / M_k, s_k = sum_j |T_jk|.
void FlatTop::compute_mass(const std::vector<double>& mass) {
  Nodal rate(3, mesh_.nodes());
  for (std::size_t n = 0; n < mesh_.nodes(); ++n) rate[0][n] = 1;
  for (const Entry& entry : entries_) rate[0][entry.middle] += std::abs(entry.weight);
  for (std::size_t n = 0; n < mesh_.nodes(); ++n) rate[0][n] /= mass[n];
  mesh_.exchange(rate);
  for (const std::int32_t n : mesh_.own) {
    const std::span<const Entry> entries = row(n);
    double sum = entries.empty() ? rate[0][n] : 0;
    for (const Entry& entry : entries) sum += std::abs(entry.weight) * rate[0][entry.middle];
    mass_[static_cast<std::size_t>(n)] = 1 / sum;
  }
}

}  // namespace trackbed::fem
