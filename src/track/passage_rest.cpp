// Equilibrium of train and track before the first step.
#include <fmt/format.h>

#include <Eigen/LU>

#include "passage_room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

constexpr int most_iterations = 100;
constexpr double first_pressed = 1e-6;  // m, any above 0: its force is none
constexpr double most_change = 1e300;   // m, of what is no number

std::string why_no_rest(const Train& train) {
  std::string text = "the train finds no static equilibrium on the track: is every wheel loaded?";
  for (const VehicleParameters& vehicle : train.vehicles())
    if (vehicle.body_offset != 0)
      return text + fmt::format(" Perhaps less body_offset of {} helps", vehicle.name);
  return text;
}

}  // namespace

// One step of Newton's method towards
//   K u - E F(d) = weight,   E' u + d + G F(d) = approaches without train and forces
// for the train's unknowns u (m) and the approaches d (m); E puts forces on unknowns, G is the
// track's static flexibility, m/N. The train alone is not held, but with its wheels it is.
// Returns the largest change of an approach.
double Passage::Room::improve_rest(Vector& u, const Matrix& g, const Vector& without) {
  const Eigen::Index m = u.size(), n = contacts(), wheels = wheels_rolling();
  const Matrix k = train.system().stiffness;
  Matrix e = Matrix::Zero(m, n);
  e.leftCols(wheels) = wheel_columns;
  const Matrix slope = slopes().asDiagonal();
  Matrix jacobian(m + n, m + n);
  jacobian << k, -e * slope, e.transpose(), Matrix::Identity(n, n) + g * slope;
  Vector wrong(m + n);
  wrong << k * u - e * forces() - train.weight(),
      e.transpose() * u + approach + g * forces() - without;
  const Vector change = jacobian.partialPivLu().solve(wrong);
  u -= change.head(m);
  // Wheels never out of contact on the way: the train would be held by nothing.
  const Vector least = approach.head(wheels) / 10;
  approach -= change.tail(n);
  approach.head(wheels) = approach.head(wheels).cwiseMax(least);
  return change.allFinite() ? change.tail(n).cwiseAbs().maxCoeff() : most_change;
}

// Equilibrium of train and track with the wheels where they are.
void Passage::Room::start() {
  place_wheels();
  const Statics statics(line.system());
  track.displacement = statics.flexibility(constant_load);
  if (contacts() == 0) return;
  const Columns columns = statics.flexibility(columns_of(0, touching.size()));
  Vector u = Vector::Zero(train.weight().size());
  const Vector without = approaches(track.displacement, u);
  for (Eigen::Index i = 0; i < wheels_rolling(); ++i)
    approach[i] = law.approach(train.wheels()[rolling[static_cast<std::size_t>(i)]].share);
  const Matrix g = rail_matrix(0, columns);
  // Pads begin pressed: what is lifted follows from the rail.
  for (Eigen::Index k = 0; k < stop_before.size(); ++k)
    if (line.stops()[static_cast<std::size_t>(k)].in_matrix)
      approach[wheels_rolling() + k] = first_pressed;
  int round = 0;
  while (improve_rest(u, g, without) > parameters.tolerance)
    if (++round == most_iterations) throw RunError(why_no_rest(train));
  vehicles.displacement = u;
  track.displacement -= columns * forces();
  for (Eigen::Index k = 0; k < stop_before.size(); ++k) stop_before[k] = own_approach(k);
  rate_slope = 2 / parameters.step;
  train_at_rest = u;
  wheels_at_rest = approach.head(wheels_rolling());
}

// Only for a train that starts on rigid rails: its equilibrium there knows no track.
void Passage::Room::rest_train() {
  steps = 0;
  vehicles.displacement = train_at_rest;
  vehicles.velocity.setZero();
  vehicles.acceleration.setZero();
  approach.head(wheels_rolling()) = wheels_at_rest;
}

}  // namespace trackbed::track
