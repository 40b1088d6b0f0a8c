// Conjugate gradients with exact sums. Symbols as in the textbook: r residual, z = M^-1 r, p
// direction.
#include "rest_solver.hpp"

#include <fmt/format.h>

#include "trackbed/core/error.hpp"
#include "trackbed/par/exact_totals.hpp"

namespace trackbed::fem {

// Zones in ascending order, as every nodal sum.
RestSolver::RestSolver(Mesh& mesh, const Stiffness& stiffness, const Terms& terms)
    : mesh_(mesh),
      stiffness_(stiffness),
      terms_(terms),
      inverse_(mesh.lattice.components(), mesh.nodes()) {
  const int components = mesh.lattice.components();
  for (std::size_t z = 0; z < mesh.zone.size(); ++z) {
    const Eigen::MatrixXd& k = stiffness.element(mesh.solid[z]).stiffness;
    for (int corner = 0; corner < mesh.lattice.corners(); ++corner)
      for (int c = 0; c < components; ++c)
        inverse_[c][mesh.corner(z, corner)] += k(corner * components + c, corner * components + c);
  }
  for (const Spring& spring : terms.springs)
    for (int c = 0; c < components; ++c) inverse_[c][spring.node] += spring.stiffness;
  for (int c = 0; c < components; ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n) {
      const bool moves = mesh.owned[n] != 0 && (terms.held_at_rest[n] >> c & 1) == 0;
      inverse_[c][n] = moves ? 1 / inverse_[c][n] : 0;
    }
}

// Springs of held nodes are in the list too: what they pull is left out with the rest.
void RestSolver::apply(Nodal& x, Nodal& force) {
  mesh_.exchange(x);
  stiffness_.apply(x, force);
  for (int c = 0; c < mesh_.lattice.components(); ++c) {
    for (const Spring& spring : terms_.springs)
      force[c][spring.node] += spring.stiffness * x[c][spring.node];
    for (const std::int32_t n : mesh_.own)
      if (inverse_[c][n] == 0) force[c][n] = 0;
  }
}

// a . b and b . c over own nodes, each with a range of its own.
std::array<double, 2> RestSolver::products(const Nodal& a, const Nodal& b, const Nodal& c) const {
  const auto parts = static_cast<std::size_t>(mesh_.lattice.components());
  const std::size_t terms = parts * mesh_.own.size();
  const auto sums =
      par::exact_totals(mesh_.comm, {2, 2}, 2 * terms, [&](std::size_t k) -> par::ExactTerm {
        const auto part = static_cast<int>(k % parts);
        const std::int32_t n = mesh_.own[k % terms / parts];
        if (k < terms) return {0, a[part][n] * b[part][n]};
        return {1, b[part][n] * c[part][n]};
      });
  return {sums[0], sums[1]};
}

double RestSolver::squared(const Nodal& force) const {
  Nodal moving = force;
  for (int c = 0; c < mesh_.lattice.components(); ++c)
    for (const std::int32_t n : mesh_.own)
      if (inverse_[c][n] == 0) moving[c][n] = 0;
  return products(moving, moving, moving)[0];
}

int RestSolver::solve(const Nodal& right, Nodal& x, double tolerance) {
  // A ground of 300 x 100 zones with a block of concrete takes some thousand.
  constexpr int most = 50000;
  const int components = mesh_.lattice.components();
  Nodal r(components, mesh_.nodes()), p = r, z = r, q = r;
  apply(x, q);
  for (int c = 0; c < components; ++c)
    for (const std::int32_t n : mesh_.own) {
      r[c][n] = inverse_[c][n] == 0 ? 0 : right[c][n] - q[c][n];
      p[c][n] = z[c][n] = inverse_[c][n] * r[c][n];
    }
  const double enough = tolerance * tolerance * squared(right);
  auto [rz, rr] = products(z, r, r);
  int count = 0;
  for (; rr > enough; ++count) {
    if (count == most)
      throw RunError(
          fmt::format("the ground finds no rest: residual {:.3g} of the load after {} "
                      "iterations; are solids or springs of very unequal stiffness?",
                      tolerance * std::sqrt(rr / enough), most));
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
  mesh_.exchange(x);
  return count;
}

}  // namespace trackbed::fem
