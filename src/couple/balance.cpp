// Received loads against the action of the particles, see balance.hpp. Cost: one small reduction
// per window. The two sides are independent: the particles sum the forces of their contacts, the
// nodes sum the loads from shape functions and from communication. A node that is omitted, counted
// twice or sent to a wrong owner causes an imbalance of order 1, rounding one of 1e-15.
#include "balance.hpp"

#include <algorithm>
#include <cmath>

namespace trackbed::couple {

namespace {

Vec3 in_newton(const std::array<std::int64_t, 3>& quanta, double quantum) {
  return quantum * Vec3(static_cast<double>(quanta[0]), static_cast<double>(quanta[1]),
                        static_cast<double>(quanta[2]));
}

// A NaN remains the largest value; a plain comparison would drop it.
void keep_largest(double& largest, double gap, double scale) {
  // Without contact the balance is exact. A gap with scale 0 is impossible: the scale contains the
  // terms of the gap.
  const double ratio = scale == 0 ? 0 : gap / scale;
  if (!std::isnan(largest) && !(ratio <= largest)) largest = ratio;
}

}  // namespace

// Terms of balance.hpp for one node, in N, Nm and J: the arm at sub-step k is position + (k/steps)
// motion, so that its moment summed over k follows from S0 and S1; the velocity is constant, so
// that the work of F_k over its sub-step is F_k . motion / steps.
void Received::add(const Surface& surface, std::size_t node, int steps) {
  const NodeLoad& load = surface.load[node];
  const Vec3 sum = in_newton(load.force, surface.load_quantum);
  const Vec3 first = in_newton(load.first, surface.load_quantum);
  const Vec3& position = surface.position[node];
  const Vec3& motion = surface.motion[node];
  force += sum;
  moment += position.cross(sum) + motion.cross(first);
  work += sum.dot(motion) / steps;
  // Norms of the sums over the window, not sums of norms: loads that alternate within a window
  // reduce the scale, which makes the test stricter.
  force_scale += sum.norm();
  moment_scale += position.norm() * sum.norm() + motion.norm() * first.norm();
  work_scale += sum.norm() * motion.norm() / steps;
}

// As plain numbers for one reduction. Doubles: the balance is only a check, whose last bits may
// depend on the number of ranks; the loads themselves are not affected.
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

// A window with very small forces is not compared: rounding is a large part of a contact force of a
// few quanta, and all of it if each node's part is below half a quantum. `resolved` quanta are
// 1e-12 of the largest force for which the quantum is chosen; above them the rounding of a contact
// is at most 3e-6 of its force. A lost load is detected as soon as loads grow, and impulses are
// summed in every window.
void Ledger::record(const Received& received, const Action& action, double quantum, int steps,
                    double dt) {
  constexpr double resolved = 1048576;  // 2^20
  // The scales include the particles' magnitudes, so that a lost load gives 1, not a division by
  // zero.
  const double force_scale = std::max(received.force_scale, action.force.norm());
  const double moment_scale = std::max(received.moment_scale, action.moment.norm());
  const double work_scale = std::max(received.work_scale, std::abs(action.work));
  const double gap = (received.force - action.force).norm();
  // Force is a sum over `steps` sub-steps of length dt/steps. Signed gaps accumulate: rounding of
  // either sign stays small relative to the scale, a bias grows with it.
  impulse_gap_ += (received.force - action.force) * (dt / steps);
  impulse_scale_ += force_scale * (dt / steps);
  lost_ = 0;
  // Written so that a force that is not a number is also compared.
  if (force_scale <= resolved * quantum) return;
  lost_ = gap / force_scale;
  keep_largest(balance_.force, gap, force_scale);
  keep_largest(balance_.moment, (received.moment - action.moment).norm(), moment_scale);
  keep_largest(balance_.work, std::abs(received.work - action.work), work_scale);
  keep_largest(balance_.impulse, impulse_gap_.norm(), impulse_scale_);
}

}  // namespace trackbed::couple
