// Assembly, and implicit steps solved for the acceleration at their end.
//
//   M [(1 - alpha_m) a' + alpha_m a] + C v' + K u' = F',
//   u' = u + dt v + dt^2 [(1/2 - beta) a + beta a'],  v' = v + dt [(1 - gamma) a + gamma a']
// (alpha_scheme.hpp): with A = (1 - alpha_m) M + gamma dt C + beta dt^2 K, constant for a dt,
//   A a' = F' - alpha_m M a - C [v + dt (1 - gamma) a] - K [u + dt v + dt^2 (1/2 - beta) a].
// With alpha_m = alpha, gamma = 1/2 - alpha and beta = (1 - alpha)^2/4 of Bossak
//   u' - u = dt (v + v')/2 + dt^2 alpha^2/4 (a' - a),
// so that u - dt^2 alpha^2/4 a is the displacement that the trapezoidal rule integrates from the
// velocities.
//
// A direct solver is used: the factor of thin bodies has little fill-in, and its solve is a fixed
// sequence of operations, the same on every rank and after a restart. Rejected: conjugate gradients
// through PETSc, distributed over ranks: messages cost more than the solve, and results would
// depend on the partition.
#include "fem/bodies/bodies_system.hpp"

#include <fmt/format.h>

#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

AlphaScheme bossak(double alpha) {
  GroundParameters parameters;
  parameters.integrator = Integrator::bossak;
  parameters.alpha = alpha;
  return alpha_scheme(parameters);
}

double stiffness_damping(const Elastic& solid) { return std::max(0.0, solid.rayleigh_stiffness); }

BodiesSystem::Sparse matrix_of(Eigen::Index size, const std::vector<Eigen::Triplet<double>>& all) {
  BodiesSystem::Sparse matrix(size, size);
  matrix.setFromTriplets(all.begin(), all.end());
  return matrix;
}

}  // namespace

BodiesSystem::BodiesSystem(const std::vector<BodyMesh>& meshes, const BodiesParameters& parameters)
    : scheme_(bossak(parameters.alpha)) {
  number(meshes, parameters);
  Entries mass, damping, stiffness;
  for (const BodyMesh& mesh : meshes) add_body(mesh, mass, damping, stiffness);
  for (const Pad& pad : parameters.pads) add_pad(pad, meshes, damping, stiffness);
  const Eigen::Index size = displacement.size();
  mass_ = matrix_of(size, mass);
  damping_ = matrix_of(size, damping);
  stiffness_ = matrix_of(size, stiffness);
}

void BodiesSystem::number(const std::vector<BodyMesh>& meshes, const BodiesParameters& parameters) {
  std::size_t nodes = 0;
  for (const BodyMesh& mesh : meshes) nodes += static_cast<std::size_t>(mesh.nodes());
  unknown_.assign(3 * nodes, 0);
  for (const HeldFace& held : parameters.held)
    for (const std::int32_t node : meshes.at(held.body).face(held.axis, held.low))
      for (std::size_t c = 0; c < 3; ++c)
        if (held.components[c]) unknown_[3 * static_cast<std::size_t>(node) + c] = -1;
  std::int32_t next = 0;
  for (std::int32_t& unknown : unknown_) unknown = unknown < 0 ? -1 : next++;
  displacement = velocity = acceleration = Vector::Zero(next);
}

// Indices are of components, 3 * node + component.
void BodiesSystem::add_entry(std::int32_t row, std::int32_t column, double value,
                             Entries& to) const {
  const std::int32_t i = unknown_[static_cast<std::size_t>(row)],
                     j = unknown_[static_cast<std::size_t>(column)];
  if (i >= 0 && j >= 0) to.emplace_back(i, j, value);
}

void BodiesSystem::add_body(const BodyMesh& mesh, Entries& mass, Entries& damping,
                            Entries& stiffness) const {
  const double element_mass = mesh.mass() / static_cast<double>(mesh.elements());
  const double beta = stiffness_damping(mesh.body.solid);
  const auto& k = mesh.hexahedron.stiffness();
  for (std::int64_t e = 0; e < mesh.elements(); ++e) {
    const auto nodes = mesh.corners(e);
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) {
        const std::int32_t row = 3 * nodes[static_cast<std::size_t>(a)],
                           column = 3 * nodes[static_cast<std::size_t>(b)];
        for (int i = 0; i < 3; ++i) {
          add_entry(row + i, column + i, element_mass * mass_fraction(a, b), mass);
          for (int j = 0; j < 3; ++j) {
            const double value = k(3 * a + i, 3 * b + j);
            add_entry(row + i, column + j, value, stiffness);
            if (beta > 0) add_entry(row + i, column + j, beta * value, damping);
          }
        }
      }
  }
}

// The energy of the pad is k/2n sum d_p^2, with d_p the relative displacement of the two faces at
// each of its n points. So its forces are equal and opposite at opposite points: there is no net
// force, and no net moment except that due to the thickness of the pad, which is 0.
void BodiesSystem::add_pad(const Pad& pad, const std::vector<BodyMesh>& meshes, Entries& damping,
                           Entries& stiffness) const {
  const auto points = BodyMesh::points(pad.patch);
  const auto fraction = 1 / static_cast<double>(points.size());
  for (const auto& [x, y] : points) {
    NodeWeights difference = meshes.at(pad.above).at(Side::lower, x, y);
    for (const NodeWeight& below : meshes.at(pad.below).at(Side::upper, x, y))
      difference.push_back({below.node, -below.weight});
    for (const NodeWeight& a : difference)
      for (const NodeWeight& b : difference)
        for (int c = 0; c < 3; ++c) {
          const double both = fraction * a.weight * b.weight;
          add_entry(3 * a.node + c, 3 * b.node + c, both * pad.stiffness[c], stiffness);
          add_entry(3 * a.node + c, 3 * b.node + c, both * pad.damping[c], damping);
        }
  }
}

void BodiesSystem::reset() {
  displacement.setZero(), velocity.setZero(), acceleration.setZero();
  begun_ = false;
}

void BodiesSystem::factorise(double dt) {
  const Sparse matrix = (1 - scheme_.alpha_m) * mass_ + scheme_.gamma * dt * damping_ +
                        scheme_.beta * dt * dt * stiffness_;
  if (!factor_) {
    factor_ = std::make_unique<Factor>();
    factor_->analyzePattern(matrix);
  }
  factor_->factorize(matrix);
  if (factor_->info() != Eigen::Success)
    throw RunError(fmt::format(
        "solid bodies: the matrix for steps of {:g} s cannot be factorised; check the stiffness, "
        "density and damping of solids and pads",
        dt));
  factor_step_ = dt;
}

// M a = F - C v - K u, so that the first step has a consistent initial acceleration and does not
// excite oscillations.
void BodiesSystem::begin(const Vector& force) {
  const Factor mass(mass_);
  acceleration = mass.solve(force - damping_ * velocity - stiffness_ * displacement);
  begun_ = true;
}

void BodiesSystem::step(double dt, const Vector& force) {
  if (dt != factor_step_) factorise(dt);
  if (!begun_) begin(force);
  const AlphaScheme& s = scheme_;
  // Predictor: state at the end of the step without the acceleration there.
  const Vector u = displacement + dt * velocity + (dt * dt * (0.5 - s.beta)) * acceleration;
  const Vector v = velocity + (dt * (1 - s.gamma)) * acceleration;
  Vector right = force - damping_ * v - stiffness_ * u;
  if (s.alpha_m != 0) right -= s.alpha_m * (mass_ * acceleration);
  acceleration = factor_->solve(right);
  displacement = u + (s.beta * dt * dt) * acceleration;
  velocity = v + (s.gamma * dt) * acceleration;
}

void BodiesSystem::add(const Vector& force) {
  const Vector change = factor_->solve(force);
  acceleration += change;
  displacement += (scheme_.beta * factor_step_ * factor_step_) * change;
  velocity += (scheme_.gamma * factor_step_) * change;
}

BodiesSystem::Vector BodiesSystem::mobility(double dt, const Vector& force) {
  if (dt != factor_step_) factorise(dt);
  return scheme_.gamma * dt * factor_->solve(force);
}

std::int64_t BodiesSystem::factor() const {
  return factor_ ? factor_->matrixL().nestedExpression().nonZeros() : 0;
}

}  // namespace trackbed::fem
