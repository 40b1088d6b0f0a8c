// Matrices of bodies and pads, integrated with Bossak's scheme.
#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <optional>
#include <vector>

#include "fem/bodies/body_mesh.hpp"
#include "fem/time/alpha_scheme.hpp"

namespace trackbed::fem {

// Unknowns are the free components of all nodes in turn.
class BodiesSystem {
 public:
  using Sparse = Eigen::SparseMatrix<double>;
  using Vector = Eigen::VectorXd;

  BodiesSystem(const std::vector<BodyMesh>& meshes, const BodiesParameters& parameters);

  Vector displacement, velocity, acceleration;  // m, m/s, m/s^2, at one time level

  void reset();  // all zero; the next step starts with the acceleration due to its forces
  // N at the end of the step. Throws RunError if the matrix cannot be factorised.
  void step(double dt, const Vector& force);
  void add(const Vector& force);  // N, added at the end of the last step
  // m/s at the end of a step of dt due to a force there, N.
  Vector mobility(double dt, const Vector& force);
  // s^2: factor of the acceleration in the difference of the displacement from the sum of dt (v +
  // v')/2.
  double beyond_trapezoid(double dt) const { return (scheme_.beta - scheme_.gamma / 2) * dt * dt; }
  bool begun() const { return begun_; }  // since `reset`
  void resume(bool begun) { begun_ = begun; }

  std::size_t unknowns() const { return static_cast<std::size_t>(displacement.size()); }
  std::int64_t factor() const;  // its number of entries
  // -1: fixed.
  std::int32_t unknown(std::int32_t node, int component) const {
    return unknown_[3 * static_cast<std::size_t>(node) + static_cast<std::size_t>(component)];
  }
  Vec3 of(const Vector& values, std::int32_t node) const {
    Vec3 found = Vec3::Zero();
    for (int c = 0; c < 3; ++c)
      if (const std::int32_t i = unknown(node, c); i >= 0) found[c] = values[i];
    return found;
  }
  void add(std::int32_t node, const Vec3& value, Vector& to) const {
    for (int c = 0; c < 3; ++c)
      if (const std::int32_t i = unknown(node, c); i >= 0) to[i] += value[c];
  }
  void put(std::int32_t node, const Vec3& value, Vector& to) const {
    for (int c = 0; c < 3; ++c)
      if (const std::int32_t i = unknown(node, c); i >= 0) to[i] = value[c];
  }
  // kg, N s/m, N/m; the last two include pads.
  const Sparse& mass() const { return mass_; }
  const Sparse& damping() const { return damping_; }
  const Sparse& stiffness() const { return stiffness_; }
  double kinetic() const { return 0.5 * velocity.dot(mass_ * velocity); }
  double elastic() const { return 0.5 * displacement.dot(stiffness_ * displacement); }

 private:
  using Entries = std::vector<Eigen::Triplet<double>>;
  void number(const std::vector<BodyMesh>& meshes, const BodiesParameters& parameters);
  void add_body(const BodyMesh& mesh, Entries& mass, Entries& damping, Entries& stiffness) const;
  void add_pad(const Pad& pad, const std::vector<BodyMesh>& meshes, Entries& damping,
               Entries& stiffness) const;
  void add_entry(std::int32_t row, std::int32_t column, double value, Entries& to) const;
  void factorise(double dt);
  void begin(const Vector& force);

  // LDL^T with the fill-reducing order of Amestoy, Davis, Duff 1996 (AMD) as in Eigen.
  using Factor = Eigen::SimplicialLDLT<Sparse>;
  AlphaScheme scheme_;
  std::vector<std::int32_t> unknown_;
  Sparse mass_, damping_, stiffness_;
  std::unique_ptr<Factor> factor_;
  double factor_step_ = 0;  // s
  bool begun_ = false;
};

}  // namespace trackbed::fem
