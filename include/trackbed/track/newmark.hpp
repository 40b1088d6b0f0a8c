// A linear structure in time by Newmark's average acceleration. Forces that depend on the motion at
// the end of a step (contacts) are left to the caller, who asks for the structure's flexibility.
#pragma once

#include <memory>

#include "trackbed/track/line.hpp"

namespace trackbed::track {

// Columns side by side in memory: a band solve then takes all of them in one go.
using Columns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// What holds against a change of displacement within a step, N/m and the like; `step` in s.
Sparse effective_stiffness(const LinearSystem& system, double step);

class Newmark {
 public:
  // Factorises once; `step` in s.
  Newmark(const LinearSystem& system, double step);
  ~Newmark();
  Newmark(Newmark&&) noexcept;

  Vector displacement, velocity, acceleration;  // at one time level

  // Change of displacement over the next step under `force` at its end, N; changes nothing.
  Vector free_change(const Vector& force) const;
  // Change of displacement at the end of a step per force at its end.
  Columns flexibility(const Columns& forces) const;
  Vector flexibility(const Vector& forces) const;
  // Ends the step with this change.
  void accept(const Vector& change);
  double energy() const;  // J, kinetic and elastic

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

// Displacements at rest per force: K x = f. Throws RunError if the structure is held by nothing.
class Statics {
 public:
  explicit Statics(const LinearSystem& system);
  ~Statics();
  Columns flexibility(const Columns& forces) const;

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace trackbed::track
