// Time integration of a linear structure by Newmark's average acceleration method. Forces that
// depend on the motion at the end of a step (contacts) are left to the caller, who uses the
// structure's flexibility.
#pragma once

#include <memory>

#include "trackbed/track/line.hpp"

namespace trackbed::track {

// Row-major, so that a band solve processes all columns at once.
using Columns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Effective stiffness of a step, N/m (rotations: N m); `step` in s.
Sparse effective_stiffness(const LinearSystem& system, double step);

class Newmark {
 public:
  // Factorises once; `step` in s.
  Newmark(const LinearSystem& system, double step);
  ~Newmark();
  Newmark(Newmark&&) noexcept;

  Vector displacement, velocity, acceleration;  // at one time level

  // Displacement increment of the next step under `force` at its end, N; the state is unchanged.
  Vector free_change(const Vector& force) const;
  // Displacement increment of a step due to forces at its end.
  Columns flexibility(const Columns& forces) const;
  Vector flexibility(const Vector& forces) const;
  // Completes the step with this displacement increment.
  void accept(const Vector& change);
  double energy() const;  // J, kinetic and elastic

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Static displacements: K x = f. Throws RunError if the structure has a rigid body motion.
class Statics {
 public:
  explicit Statics(const LinearSystem& system);
  ~Statics();
  Columns flexibility(const Columns& forces) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trackbed::track
