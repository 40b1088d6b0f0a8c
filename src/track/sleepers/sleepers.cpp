// Motion of rigid sleepers under seat loads, weight and stones: leapfrog for centre and spin, the
// attitude is rotated by the exponential of spin times window. All ranks perform the same
// operations in the same order on the same numbers, so that no communication is needed. The reasons
// for leapfrog are in docs/decisions/interface.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "track/sleepers/impl.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/track/line.hpp"

namespace trackbed::track {

namespace {

// exp of a rotation vector.
// Exact for a constant spin, at any angle, and of unit length to rounding: an update in the
// rotation group (as in Simo, Wong 1991, doi:10.1002/nme.1620310103) instead of adding to Euler
// angles, which have poles.
Quat rotation_by(const Vec3& vector) {
  const double angle = vector.norm();
  if (angle == 0) return Quat::Identity();
  return Quat(Eigen::AngleAxisd(angle, vector / angle));
}

// log of a rotation: the inverse, for angles below pi.
// By atan2 of both parts: acos of the real part is inaccurate at small angles, which are usual
// here.
Vec3 rotation_of(const Quat& attitude) {
  const double half_sine = attitude.vec().norm();
  if (half_sine == 0) return Vec3::Zero();
  return 2 * std::atan2(half_sine, attitude.w()) / half_sine * attitude.vec();
}

}  // namespace

RigidSleepers::Impl::Impl(const SleeperParameters& given, Dimension dimension, double thickness)
    : parameters(given) {
  // A plane model is a slice of the model's thickness: its sleeper has that length, and its mass is
  // that of the slice. Motions out of the plane are fixed independent of the deck.
  const bool plane = dimension == Dimension::plane;
  if (plane) parameters.y = 0;
  prism = bevelled_box(given.width, given.height, plane ? thickness : given.length, given.bevel);
  shape = surface_of(prism);
  mass = given.density * prism.volume;
  const auto is_free = [&](const char* name) {
    return std::find(given.free.begin(), given.free.end(), name) != given.free.end();
  };
  free_shift = {is_free("x") ? 1.0 : 0.0, is_free("y") && !plane ? 1.0 : 0.0,
                is_free("z") ? 1.0 : 0.0};
  free_turn = {is_free("rx") && !plane, is_free("ry"), is_free("rz") && !plane};
  bodies.resize(static_cast<std::size_t>(given.count));
}

// Centre of mass when placed. Displacements are relative to it, so that settlements of 1e-6 m are
// accurate at x = 100 m.
Vec3 RigidSleepers::Impl::placed_centre(std::size_t i) const {
  const double x = parameters.first + static_cast<double>(i) * parameters.spacing;
  return {x, parameters.y, bottom + prism.depth};
}

// R diag(I) R^T in space axes, kg m^2; computed from the attitude, not stored between windows.
Mat3 RigidSleepers::Impl::inertia(const Body& body) const {
  const Mat3 axes = body.attitude.toRotationMatrix();
  return axes * (mass * prism.gyration).asDiagonal() * axes.transpose();
}

// About the centre. The forces are means over the last window and act on the positions of the nodes
// at mid-window; the change of their arms within the window is neglected. The arms follow from the
// pose, not from the surface, so that they are available in a resumed run.
Vec3 RigidSleepers::Impl::torque(std::size_t i, std::span<const Vec3> node_force) const {
  const Body& body = bodies[i];
  const Quat middle = rotation_by(body.spin * (-last_step / 2)) * body.attitude;
  Vec3 sum = Vec3::Zero();
  for (std::size_t n = 0; n < node_force.size(); ++n)
    sum += (middle * shape.position[n]).cross(node_force[n]);
  return sum;
}

// Euler's equation in space axes, I a = T - w x I w, for the free components only: the constraint
// of the fixed ones provides the required torque.
Vec3 RigidSleepers::Impl::angular_acceleration(const Body& body, const Vec3& torque) const {
  Mat3 matrix = inertia(body);
  Vec3 right = torque - body.spin.cross(matrix * body.spin);
  for (int k = 0; k < 3; ++k) {
    if (free_turn[static_cast<std::size_t>(k)]) continue;
    matrix.row(k).setZero();
    matrix.col(k).setZero();
    matrix(k, k) = 1;
    right[k] = 0;
  }
  return matrix.inverse() * right;
}

// About the centre, of two seats that rotate with the sleeper, in its present position: with r from
// the centre to the left seat
//   T = r x (Q_r - Q_l) e_z,   N m.
Vec3 RigidSleepers::Impl::seat_torque(const Body& body, std::span<const double> seat_force) const {
  if (seat_force.size() < 2) return Vec3::Zero();
  const Vec3 left = body.attitude * Vec3(0, parameters.gauge / 2, 0);
  return left.cross(Vec3(0, 0, seat_force[1] - seat_force[0]));
}

// v += a (dt + last dt)/2: from mid-window to mid-window, also if the length of windows changes.
// `reaction` is stored for output; with one rail the seat force acts at the centre and gives no
// moment, since the two rails are not modelled separately.
//   a = free (R - m g e_z - Q e_z)/m,  v += a t
// R the stones' reaction, N, mean of the last window; Q the seat force, N, downwards; t s.
void RigidSleepers::Impl::kick(std::size_t i, std::span<const double> seat_force,
                               std::span<const Vec3> node_force, const Kick& by) {
  Body& body = bodies[i];
  body.reaction.setZero();
  for (const Vec3& force : node_force) body.reaction += force;
  double seats = 0;
  for (const double one : seat_force) seats += one;
  const Vec3 weight(0, 0, -mass * by.gravity - seats);
  body.acceleration = ((body.reaction + weight) / mass).cwiseProduct(free_shift);
  body.turning = angular_acceleration(body, torque(i, node_force) + seat_torque(body, seat_force));
  body.velocity += body.acceleration * by.time;
  body.spin += body.turning * by.time;
}

// Both ends of the motion are computed from the pose: rounding does not accumulate in the surface.
// The surface's motion is a chord: rotating nodes move on arcs, from which the chord differs by
// (spin dt)^2/8 of their arm.
void RigidSleepers::Impl::drift(std::size_t i, double dt) {
  Body& body = bodies[i];
  Surface& surface = surfaces[i];
  for (std::size_t n = 0; n < surface.nodes(); ++n) surface.position[n] = node(i, n);
  body.displacement += body.velocity * dt;
  body.attitude = (rotation_by(body.spin * dt) * body.attitude).normalized();
  for (std::size_t n = 0; n < surface.nodes(); ++n)
    surface.motion[n] = node(i, n) - surface.position[n];
}

// Also after a checkpoint was read: the next `advance` sets the motion before the sub-steps.
void RigidSleepers::Impl::show_at_rest() {
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (std::size_t n = 0; n < surfaces[i].nodes(); ++n) {
      surfaces[i].position[n] = node(i, n);
      surfaces[i].motion[n].setZero();
    }
}

RigidSleepers::RigidSleepers(const SleeperParameters& parameters, Dimension dimension,
                             double thickness, int material)
    : impl_(std::make_unique<Impl>(parameters, dimension, thickness)) {
  Surface shape = impl_->shape;
  shape.material = material;
  for (std::size_t i = 0; i < count(); ++i) {
    shape.name = fmt::format("sleeper.{}", i);
    impl_->surfaces.push_back(shape);
  }
  impl_->show_at_rest();
}

RigidSleepers::~RigidSleepers() = default;
RigidSleepers::RigidSleepers(RigidSleepers&&) noexcept = default;
RigidSleepers& RigidSleepers::operator=(RigidSleepers&&) noexcept = default;

std::size_t RigidSleepers::count() const { return impl_->bodies.size(); }
double RigidSleepers::x(std::size_t i) const { return impl_->placed_centre(i).x(); }
double RigidSleepers::mass() const { return impl_->mass; }
bool RigidSleepers::placed() const { return impl_->placed; }
double RigidSleepers::bottom() const { return impl_->bottom; }
std::vector<Surface>& RigidSleepers::surfaces() { return impl_->surfaces; }
void RigidSleepers::show_at_rest() { impl_->show_at_rest(); }
Vec3 RigidSleepers::reaction(std::size_t i) const { return impl_->bodies.at(i).reaction; }

// The last window is set to 0: the first velocity update is then over half a window, as leapfrog
// requires from rest.
void RigidSleepers::place(double z) {
  impl_->bottom = z;
  impl_->placed = true;
  impl_->last_step = 0;
  std::fill(impl_->bodies.begin(), impl_->bodies.end(), Body{});
  impl_->show_at_rest();
}

// The bevel is neglected: a stone in the bevelled corner of the box counts as overlapping.
bool RigidSleepers::overlaps(const Vec3& centre, double radius) const {
  const Impl& impl = *impl_;
  // Distance from the sphere's centre to the box in the body's own axes: clamp to the box, then
  // compare.
  const Vec3 half(impl.parameters.width / 2, impl.prism.length / 2, 0);
  const Vec3 low(-half.x(), -half.y(), -impl.prism.depth);
  const Vec3 high(half.x(), half.y(), impl.parameters.height - impl.prism.depth);
  for (std::size_t i = 0; i < impl.bodies.size(); ++i) {
    const Vec3 local = impl.bodies[i].attitude.conjugate() * (centre - impl.centre(i));
    if ((local - local.cwiseMax(low).cwiseMin(high)).norm() < radius) return true;
  }
  return false;
}

// All velocities are updated before any sleeper moves: the order of sleepers does not matter.
// Local.
void RigidSleepers::advance(double dt, std::span<const double> seat_force,
                            const std::vector<std::span<const Vec3>>& node_force, double gravity) {
  Impl& impl = *impl_;
  const std::size_t seats = count() > 0 ? seat_force.size() / count() : 1;
  require(seat_force.size() == seats * count() && (seats == 1 || seats == 2),
          "seat_force must have one or two values for each sleeper");
  require(seats == 1 || impl.parameters.gauge > 0, "two seats need a gauge");
  require(node_force.empty() || node_force.size() == count(),
          "one list of node forces per sleeper");
  for (std::size_t i = 0; i < count(); ++i)
    impl.kick(i, seat_force.subspan(i * seats, seats),
              node_force.empty() ? std::span<const Vec3>{} : node_force[i],
              {.time = (impl.last_step + dt) / 2, .gravity = gravity});
  for (std::size_t i = 0; i < count(); ++i) impl.drift(i, dt);
  impl.last_step = dt;
}

// Attitudes are unchanged: a lifted track carries its sleepers in their present attitude. The
// velocity is that at their release.
void RigidSleepers::carry(double dt, double up,
                          const std::vector<std::span<const Vec3>>& node_force) {
  Impl& impl = *impl_;
  for (std::size_t i = 0; i < count(); ++i) {
    Body& body = impl.bodies[i];
    body.velocity = Vec3(0, 0, up / dt);
    body.acceleration.setZero(), body.spin.setZero(), body.turning.setZero();
    body.reaction.setZero();
    for (const Vec3& force : node_force.at(i)) body.reaction += force;
    impl.drift(i, dt);
  }
  impl.last_step = dt;
}

// Centre and rotation relative to the placed position; velocities at mid-window.
SleeperState RigidSleepers::state(std::size_t i) const {
  const Body& body = impl_->bodies.at(i);
  return {body.displacement, body.velocity, body.acceleration, rotation_of(body.attitude),
          body.spin};
}

// The velocity at mid-window plus half a window of the acceleration that led to it: the error is
// that of half a window's change of acceleration.
Vec3 RigidSleepers::velocity_now(std::size_t i) const {
  const Body& body = impl_->bodies.at(i);
  return body.velocity + impl_->last_step / 2 * body.acceleration;
}

Vec3 RigidSleepers::spin_now(std::size_t i) const {
  const Body& body = impl_->bodies.at(i);
  return body.spin + impl_->last_step / 2 * body.turning;
}

// With r from the centre to the seat, which rotates with the sleeper: u = z + r_z, u' = (v + w x
// r)_z.
Seat seat_of(const Sleepers& sleepers, std::size_t i, double aside) {
  const SleeperState now = sleepers.state(i);
  const Vec3 arm = rotation_by(now.rotation) * Vec3(0, aside, 0);
  return {.height = now.displacement.z() + arm.z(),
          .rate = sleepers.velocity_now(i).z() + sleepers.spin_now(i).cross(arm).z()};
}

// m v^2/2 + w . I w/2, J, with the velocities at mid-window.
double RigidSleepers::kinetic() const {
  double sum = 0;
  for (const Body& body : impl_->bodies)
    sum += impl_->mass * body.velocity.squaredNorm() / 2 +
           body.spin.dot(impl_->inertia(body) * body.spin) / 2;
  return sum;
}

// Local and identical on all ranks.
std::string RigidSleepers::trouble() const {
  for (std::size_t i = 0; i < count(); ++i) {
    const Body& body = impl_->bodies[i];
    if (!body.displacement.allFinite() || !body.attitude.coeffs().allFinite())
      return fmt::format(
          "the position or rotation of the sleeper placed at x = {:g} m is not a number; use a "
          "smaller time.step or dem.safety, or a shorter time.window",
          x(i));
  }
  return "";
}

}  // namespace trackbed::track
