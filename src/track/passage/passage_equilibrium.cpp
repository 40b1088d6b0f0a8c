// Static equilibrium of train and track before the first step.
#include <fmt/format.h>

#include "track/passage/passage_impl.hpp"
#include "trackbed/core/decompositions.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

constexpr double initial_approach = 1e-6;  // m, any positive value: the force is zero
constexpr double most_change = 1e300;      // m, if a change is not finite

std::string why_no_equilibrium(const Train& train, double change, double tolerance) {
  const std::string text = fmt::format(
      "static equilibrium of the train on the track did not converge to passage.tolerance = {:g} m "
      "in {} iterations of Newton's method ({}): a wheel may be unloaded",
      tolerance, most_iterations,
      change < most_change
          ? fmt::format("the last one changed the compression of a contact by {:.2g} m", change)
          : "the last one has no finite solution");
  for (const VehicleParameters& vehicle : train.vehicles())
    if (vehicle.body_offset != 0)
      return text + fmt::format("; reduce body_offset of {}", vehicle.name);
  return text +
         "; check the vehicles and the forces on the rail ([[force]]), or increase "
         "passage.tolerance";
}

}  // namespace

// One iteration of Newton's method for
//   K u - E F(d) = weight,   E' u + d + G F(d) = approaches without train and forces
// for the train's unknowns u (m) and the approaches d (m); E distributes forces to unknowns, G is
// the track's static flexibility, m/N. K alone is singular, but not the system with the contacts.
// Returns the largest change of an approach.
double Passage::Impl::iterate_equilibrium(Vector& u, const Matrix& g, const Vector& without) {
  const Eigen::Index m = u.size(), n = contacts(), wheels = wheels_rolling();
  const Matrix k = train.system().stiffness;
  Matrix e = Matrix::Zero(m, n);
  e.leftCols(wheels) = wheel_columns;
  const Matrix slope = slopes().asDiagonal();
  Matrix jacobian(m + n, m + n);
  jacobian << k, -e * slope, e.transpose(), Matrix::Identity(n, n) + g * slope;
  Vector residual(m + n);
  residual << k * u - e * forces() - train.weight(),
      e.transpose() * u + approach + g * forces() - without;
  const Vector change = solution(jacobian, residual);
  u -= change.head(m);
  // Approaches of wheels remain positive: without contact the system would be singular.
  const Vector least = approach.head(wheels) / 10;
  approach -= change.tail(n);
  approach.head(wheels) = approach.head(wheels).cwiseMax(least);
  return change.allFinite() ? change.tail(n).cwiseAbs().maxCoeff() : most_change;
}

// Static equilibrium of train and track with the wheels at their start positions.
void Passage::Impl::start() {
  place_wheels();
  const Statics statics(line.system());
  track.displacement = statics.flexibility(constant_load);
  if (contacts() == 0) return;
  const Columns columns = statics.flexibility(columns_of(0, touching.size()));
  Vector u = Vector::Zero(train.weight().size());
  const Vector without = approaches(track.displacement, u);
  for (Eigen::Index i = 0; i < wheels_rolling(); ++i)
    approach[i] = law.approach(train.wheels()[rolling[static_cast<std::size_t>(i)]].mean_load);
  const Matrix g = rail_matrix(0, columns);
  // Pads with uplift are compressed in the first iteration; which of them open is solved for.
  for (Eigen::Index k = 0; k < stop_before.size(); ++k)
    if (line.stops()[static_cast<std::size_t>(k)].in_matrix)
      approach[wheels_rolling() + k] = initial_approach;
  int iteration = 0;
  for (double change = most_change; change > parameters.tolerance; ++iteration) {
    if (iteration == most_iterations)
      throw RunError(why_no_equilibrium(train, change, parameters.tolerance));
    change = iterate_equilibrium(u, g, without);
  }
  vehicles.displacement = u;
  track.displacement -= columns * forces();
  for (Eigen::Index k = 0; k < stop_before.size(); ++k) stop_before[k] = own_approach(k);
  rate_slope = 2 / parameters.step;
  train_at_rest = u;
  wheels_at_rest = approach.head(wheels_rolling());
}

// Only for a train that starts on rigid rails: its static equilibrium there is independent of the
// track.
void Passage::Impl::reset_train() {
  steps = 0;
  vehicles.displacement = train_at_rest;
  vehicles.velocity.setZero();
  vehicles.acceleration.setZero();
  approach.head(wheels_rolling()) = wheels_at_rest;
}

}  // namespace trackbed::track
