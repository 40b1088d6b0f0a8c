// Average acceleration (gamma 1/2, beta 1/4): second order, stable for any step, and without
// damping of its own, so that what a track damps is what the deck says.
//   (K + 2/h C + 4/h^2 M) du = f' - K u + M (4/h v + a) + C v,
//   v' = 2/h du - v,   a' = 4/h^2 du - 4/h v - a
// (Newmark 1959, doi:10.1061/JMCEA3.0000098.) Written for the change du: in equilibrium the right
// side is zero to rounding, and nothing drifts.
//
// Every rank factorises and solves the same small band matrix alike: 600 m of track have about 1e4
// unknowns and a solve takes well below a millisecond, less than a message would.
// Rejected: a distributed solve, and generalised-alpha, whose numerical damping at 1 kHz would hide
// behind that of the pads.
#include "trackbed/track/newmark.hpp"

#include <Eigen/SparseCholesky>

#include "digits.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

// Unknowns are numbered along the track: any other order would only widen the band.
using Factor = Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>>;

}  // namespace

Sparse effective_stiffness(const LinearSystem& system, double step) {
  return system.stiffness + 2 / step * system.damping + 4 / (step * step) * system.mass;
}

struct Newmark::Room {
  LinearSystem system;
  double step;
  Factor factor;
};

Newmark::Newmark(const LinearSystem& system, double step)
    : displacement(Vector::Zero(system.mass.rows())),
      velocity(displacement),
      acceleration(displacement),
      room_(std::make_unique<Room>()) {
  room_->system = system;
  room_->step = step;
  const Sparse matrix = effective_stiffness(system, step);
  room_->factor.compute(matrix);
  require_digits(room_->factor.vectorD(), matrix.diagonal());
}

Newmark::~Newmark() = default;
Newmark::Newmark(Newmark&&) noexcept = default;

// `force` is that at the end of the step: the scheme asks for equilibrium there.
Vector Newmark::free_change(const Vector& force) const {
  const LinearSystem& s = room_->system;
  const double h = room_->step;
  Vector right = force;
  right.noalias() -= s.stiffness * displacement;
  right.noalias() += s.mass * (4 / h * velocity + acceleration);
  right.noalias() += s.damping * velocity;
  return room_->factor.solve(right);
}

Columns Newmark::flexibility(const Columns& forces) const { return room_->factor.solve(forces); }
Vector Newmark::flexibility(const Vector& forces) const { return room_->factor.solve(forces); }

// All three stay at one time level: a step can be judged, and a run stopped, between any two.
void Newmark::accept(const Vector& change) {
  const double h = room_->step;
  displacement += change;
  acceleration = 4 / (h * h) * change - 4 / h * velocity - acceleration;
  velocity = 2 / h * change - velocity;
}

// Kept to rounding without dampers and forces: the scheme is the trapezoidal rule.
double Newmark::energy() const {
  return (velocity.dot(room_->system.mass * velocity) +
          displacement.dot(room_->system.stiffness * displacement)) /
         2;
}

struct Statics::Room {
  Factor factor;
};

// A structure that nothing holds has a pivot that is zero to rounding.
Statics::Statics(const LinearSystem& system) : room_(std::make_unique<Room>()) {
  room_->factor.compute(system.stiffness);
  const Vector pivots = room_->factor.vectorD();
  constexpr double rounding = 1e-14;
  if (room_->factor.info() != Eigen::Success ||
      pivots.minCoeff() <= rounding * system.stiffness.diagonal().minCoeff())
    throw RunError("the track is held by nothing: give it a support or pinned ends");
  require_digits(pivots, system.stiffness.diagonal());
}

Statics::~Statics() = default;

Columns Statics::flexibility(const Columns& forces) const { return room_->factor.solve(forces); }

}  // namespace trackbed::track
