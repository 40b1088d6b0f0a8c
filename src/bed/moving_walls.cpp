// Walls that stages move. As for the platen, the surfaces of a window have the positions at its
// start and the displacement within it, and the positions at its end are stored. So the state
// consists of four lengths and the servos, from which the next window or a resumed run continues.
//
// Walls of a box under a pressure move in pairs: the bed stays in place, and one servo controls the
// mean of two forces. Planes intersect at the corners, which no stone reaches.
//
// Nodes are computed from their initial positions in each window, so that rounding cannot deform a
// wall. Cost: all nodes of all walls per window, a few hundred, on every rank.
#include <algorithm>
#include <array>
#include <limits>

#include "trackbed/bed/bed.hpp"

namespace trackbed::bed {

// The names do not depend on the height: they are columns of the histories before the walls exist.
Walls::Walls(const Container& container, int material, int floor_material)
    : container_(container), material_(material), floor_material_(floor_material) {
  for (const Surface& wall : walls(container, 1, material, floor_material >= 0))
    names_.push_back(wall.name);
}

void Walls::build(double height) {
  height_ = height;
  std::vector<Surface> higher = walls(container_, height, material_, floor_material_ >= 0);
  if (floor_material_ >= 0) higher[0].material = floor_material_;
  initial_.clear();
  for (const Surface& wall : higher) initial_.push_back(wall.position);
  surfaces_.resize(higher.size());  // existing walls keep their address
  std::move(higher.begin(), higher.end(), surfaces_.begin());
  if (removed_) remove();
  set_motion({});
}

// Floor and lower halves are the moving half of a shear box.
bool Walls::moves_along(const std::string& name) const {
  return name == "floor" || container_.split <= 0 || name.ends_with(".lower");
}

Vec3 Walls::displacement_of(const std::string& name, const Motion& motion) const {
  const double left = name == "wall.left" ? 1 : 0, right = name == "wall.right" ? 1 : 0;
  const double front = name == "wall.front" ? 1 : 0, back = name == "wall.back" ? 1 : 0;
  return {(moves_along(name) ? motion.along : 0) + (left - right) * motion.in[0],
          (front - back) * motion.in[1], name == "floor" ? 0 : motion.up};
}

Vec3 Walls::displacement(const std::string& name) const { return displacement_of(name, total_); }

void Walls::set_motion(const Motion& motion) {
  for (std::size_t k = 0; k < surfaces_.size(); ++k) {
    Surface& wall = surfaces_[k];
    const Vec3 before = displacement(wall.name), now = displacement_of(wall.name, motion);
    for (std::size_t n = 0; n < wall.nodes(); ++n)
      wall.position[n] = initial_[k][n] + before, wall.motion[n] = now;
  }
}

void Walls::advance(const Motion& motion) {
  set_motion(motion);
  total_.along += motion.along, total_.up += motion.up;
  for (std::size_t axis = 0; axis < 2; ++axis) total_.in[axis] += motion.in[axis];
}

void Walls::move(double along, double up) { advance({.along = along, .up = up}); }

double Walls::extent(std::size_t axis) const {
  const auto a = static_cast<Eigen::Index>(axis);
  return container_.high[a] - container_.low[a] - 2 * total_.in[axis];
}

double Walls::area() const {
  const bool moved = total_.in != std::array{0.0, 0.0};
  return moved ? extent(0) * extent(1) : container_.area();
}

// The loaded area is that of the bed's side at present. Periodic sides, and the faces of a plane
// model, have no walls. A bed compressed from above widens continuously, hence the integral term.
void Walls::confine(const ServoParameters& p, double dt, double pressure, double height,
                    const std::array<double, 2>& force) {
  Motion motion;
  for (std::size_t axis = 0; axis < 2; ++axis)
    if (is_confined(axis))
      motion.in[axis] = servo_[axis].advance(
          p, dt, force[axis], pressure * extent(1 - axis) * height, {.integral = true});
  advance(motion);
}

bool Walls::is_confined(std::size_t axis) const {
  return !container_.periodic[axis] && (axis == 0 || container_.dimension == Dimension::space);
}

void Walls::retarget() {
  for (Servo& servo : servo_) servo.retarget();
}

double Walls::steady_for() const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 2; ++axis)
    if (is_confined(axis)) least = std::min(least, servo_[axis].steady_for());
  return least;
}

// The floor is the first surface and remains.
void Walls::remove() {
  removed_ = true;
  const std::size_t kept = floor_material_ >= 0 && !surfaces_.empty() ? 1 : 0;
  surfaces_.erase(surfaces_.begin() + static_cast<std::ptrdiff_t>(kept), surfaces_.end());
  initial_.resize(kept);
}

void Walls::archive(io::Archive& a) {
  a("height", height_, {"m", "of the walls; 0: there are no walls yet"});
  a("along", total_.along, {"m", "displacement of floor and lower halves along x"});
  a("up", total_.up, {"m", "displacement of the walls upwards"});
  a("in_x", total_.in[0], {"m", "inward displacement of the walls normal to x"});
  a("in_y", total_.in[1], {"m", "inward displacement of the walls normal to y"});
  a("removed", removed_, {"-", "1: the walls have been removed; else 0"});
  a.part("servo_x", servo_[0]);
  a.part("servo_y", servo_[1]);
  if (a.reads() && height_ > 0) build(height_);
}

}  // namespace trackbed::bed
