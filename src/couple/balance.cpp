// Received against given, see balance.hpp. Costs one small reduction per window.
#include "balance.hpp"

#include <algorithm>
#include <cmath>

namespace trackbed::couple {

namespace {

Vec3 in_newton(const std::array<std::int64_t, 3>& quanta, double quantum) {
  return quantum * Vec3(static_cast<double>(quanta[0]), static_cast<double>(quanta[1]),
                        static_cast<double>(quanta[2]));
}

// A NaN is kept as the largest for good instead of being dropped by a comparison.
void keep_largest(double& largest, double gap, double scale) {
  const double ratio = scale == 0 ? 0 : gap / scale;
  if (!std::isnan(largest) && !(ratio <= largest)) largest = ratio;
}

}  // namespace

void Received::add(const Surface& surface, std::size_t node, int steps) {
  const NodeLoad& load = surface.load[node];
  const Vec3 sum = in_newton(load.force, surface.load_quantum);
  const Vec3 first = in_newton(load.first, surface.load_quantum);
  const Vec3& position = surface.position[node];
  const Vec3& motion = surface.motion[node];
  force += sum;
  moment += position.cross(sum) + motion.cross(first);
  work += sum.dot(motion) / steps;
  force_scale += sum.norm();
  moment_scale += position.norm() * sum.norm() + motion.norm() * first.norm();
  work_scale += sum.norm() * motion.norm() / steps;
}

std::array<double, Received::numbers> Received::pack() const {
  return {force.x(),  force.y(), force.z(),   moment.x(),   moment.y(),
          moment.z(), work,      force_scale, moment_scale, work_scale};
}

void Received::unpack_add(std::span<const double, numbers> values) {
  force += Vec3(values[0], values[1], values[2]);
  moment += Vec3(values[3], values[4], values[5]);
  work += values[6];
  force_scale += values[7];
  moment_scale += values[8];
  work_scale += values[9];
}

void Ledger::book(const Received& received, const Action& action, int steps, double dt) {
  // The particles' own magnitudes join the scales: a load lost on its way must read as 1, not as
  // a division by zero.
  const double force_scale = std::max(received.force_scale, action.force.norm());
  const double moment_scale = std::max(received.moment_scale, action.moment.norm());
  const double work_scale = std::max(received.work_scale, std::abs(action.work));
  keep_largest(balance_.force, (received.force - action.force).norm(), force_scale);
  keep_largest(balance_.moment, (received.moment - action.moment).norm(), moment_scale);
  keep_largest(balance_.work, std::abs(received.work - action.work), work_scale);
  impulse_gap_ += (received.force - action.force) * (dt / steps);
  impulse_scale_ += force_scale * (dt / steps);
  keep_largest(balance_.impulse, impulse_gap_.norm(), impulse_scale_);
}

}  // namespace trackbed::couple
