// Conjugate gradients with exact sums. Symbols as in the textbook: r residual, z = M^-1 r, p
// direction, q = K p. Degrees of freedom that are fixed or owned by another rank have an inverse
// diagonal of 0, which excludes them from all vectors without a branch in the products.
//
// Vectors are nodal arrays of the explicit step, so K p is computed by its kernel. Sums of integers
// make the iteration bitwise identical for any partition; their resolution, the largest term times
// the number of terms times 2^-60, is far below what the directions need.
#include "fem/solver/static_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "trackbed/core/error.hpp"
#include "trackbed/core/exact_sum.hpp"

namespace trackbed::fem {

// Elements in ascending order, as in every nodal sum.
StaticSolver::StaticSolver(Mesh& mesh, const Stiffness& stiffness, const Terms& terms)
    : mesh_(mesh),
      stiffness_(stiffness),
      terms_(terms),
      terms_count_(static_cast<double>(
          mesh.comm.sum(static_cast<std::int64_t>(mesh.own.size()) * mesh.lattice.components()))),
      inverse_(mesh.lattice.components(), mesh.nodes()) {
  const int components = mesh.lattice.components();
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    const Eigen::MatrixXd k = stiffness.matrix(mesh, z);
    for (int corner = 0; corner < mesh.corners(); ++corner)
      for (int c = 0; c < components; ++c)
        inverse_[c][mesh.home(mesh.corner(z, corner))] +=
            k(corner * components + c, corner * components + c);
  }
  for (const Spring& spring : terms.springs)
    for (int c = 0; c < components; ++c) inverse_[c][spring.node] += spring.stiffness;
  for (int c = 0; c < components; ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n) {
      const bool moves = mesh.owned[n] != 0 && (terms.held_static[n] >> c & 1) == 0;
      inverse_[c][n] = moves ? 1 / inverse_[c][n] : 0;
    }
}

// The list also contains springs of fixed nodes: their forces are set to 0 with the others.
void StaticSolver::apply(Nodal& x, Nodal& force) {
  mesh_.exchange(x);
  stiffness_.apply(x, force);
  for (int c = 0; c < mesh_.lattice.components(); ++c) {
    for (const Spring& spring : terms_.springs)
      force[c][spring.node] += spring.stiffness * x[c][spring.node];
    for (const std::int32_t n : mesh_.own)
      if (inverse_[c][n] == 0) force[c][n] = 0;
  }
}

// a . b and b . c over own nodes, as in par::exact_totals: the range from the largest term and the
// number of terms, the sum from integers. Written out, since a callback per term would cost more
// than the term.
std::array<double, 2> StaticSolver::products(const Nodal& a, const Nodal& b, const Nodal& c) const {
  std::array<double, 2> largest{}, found{};
  const auto each = [&](const auto& take) {
    for (int part = 0; part < mesh_.lattice.components(); ++part) {
      const double *x = a[part], *y = b[part], *z = c[part];
      for (const std::int32_t n : mesh_.own) take(x[n] * y[n], y[n] * z[n]);
    }
  };
  each([&](double first, double second) {
    largest[0] = std::max(largest[0], std::abs(first));
    largest[1] = std::max(largest[1], std::abs(second));
  });
  mesh_.comm.max(std::span<double>(largest));
  if (!std::isfinite(largest[0]) || !std::isfinite(largest[1]) || largest[0] + largest[1] == 0)
    return largest;
  const auto sum_of = [&](double most) {
    return ExactSum(exact_quantum((most > 0 ? most : 1.0) * terms_count_));
  };
  std::array<ExactSum, 2> sums{sum_of(largest[0]), sum_of(largest[1])};
  each([&](double first, double second) { sums[0].add(first), sums[1].add(second); });
  std::array<std::int64_t, 2> counts{sums[0].count(), sums[1].count()};
  mesh_.comm.sum(std::span<std::int64_t>(counts));
  for (std::size_t k = 0; k < 2; ++k) {
    sums[k].count() = counts[k];
    found[k] = sums[k].value();
  }
  return found;
}

double StaticSolver::squared(const Nodal& force) const {
  Nodal moving = force;
  for (int c = 0; c < mesh_.lattice.components(); ++c)
    for (const std::int32_t n : mesh_.own)
      if (inverse_[c][n] == 0) moving[c][n] = 0;
  return products(moving, moving, moving)[0];
}

int StaticSolver::solve(const Nodal& right, Nodal& x, double tolerance, double size) {
  // A ground of 300 x 100 elements with a block of concrete takes some thousand.
  constexpr int most = 50000;
  const int components = mesh_.lattice.components();
  Nodal r(components, mesh_.nodes()), p = r, z = r, q = r;
  apply(x, q);
  for (int c = 0; c < components; ++c)
    for (const std::int32_t n : mesh_.own) {
      r[c][n] = inverse_[c][n] == 0 ? 0 : right[c][n] - q[c][n];
      p[c][n] = z[c][n] = inverse_[c][n] * r[c][n];
    }
  const double enough = tolerance * tolerance * size * size;
  auto [rz, rr] = products(z, r, r);
  int count = 0;
  // r is updated, not computed again: its drift is rounding error, below any useful tolerance.
  for (; rr > enough; ++count) {
    if (count == most)
      throw RunError(
          fmt::format("static solve of the ground did not converge: the relative residual is "
                      "{:.3g} (required: {:.2g}) after {} iterations; make the stiffnesses of "
                      "ground materials (layers, blocks, solids) and springs less unequal",
                      tolerance * std::sqrt(rr / enough), tolerance, most));
    apply(p, q);
    const double step = rz / products(p, q, q)[0];
    for (int c = 0; c < components; ++c)
      for (const std::int32_t n : mesh_.own) {
        x[c][n] += step * p[c][n];
        r[c][n] -= step * q[c][n];
        z[c][n] = inverse_[c][n] * r[c][n];
      }
    const auto [next, now] = products(z, r, r);
    for (int c = 0; c < components; ++c)
      for (const std::int32_t n : mesh_.own) p[c][n] = z[c][n] + next / rz * p[c][n];
    rz = next, rr = now;
  }
  // Stresses of elements at rank borders are computed next.
  mesh_.exchange(x);
  return count;
}

}  // namespace trackbed::fem
