// Walls that stages move. They are moved as the platen is: what a window shows is where it begins
// and how far it goes, what is kept is where it ends. So the state is four lengths and the servos,
// and the next window, or a run resumed before it, finds the walls where this one left them.
//
// Walls of a box that hold a pressure go in pairs: the bed stays where it is, and one servo follows
// the mean of two forces. Planes go through each other at the corners, which no stone reaches.
//
// Nodes are placed anew from where they were built in each window, so that rounding cannot bend a
// wall. Cost: all nodes of all walls per window, on every rank alike; a few hundred.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <tuple>

#include "trackbed/bed/bed.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::bed {

// The names are those of any height: they are columns of the histories before the walls stand.
Walls::Walls(const Container& container, int material, int floor_material)
    : container_(container), material_(material), floor_material_(floor_material) {
  for (const Surface& wall : walls(container, 1, material, floor_material >= 0))
    names_.push_back(wall.name);
}

void Walls::raise(double height) {
  height_ = height;
  std::vector<Surface> higher = walls(container_, height, material_, floor_material_ >= 0);
  if (floor_material_ >= 0) higher[0].material = floor_material_;
  home_.clear();
  for (const Surface& wall : higher) home_.push_back(wall.position);
  surfaces_.resize(higher.size());  // walls that stand already stay where others know them
  std::move(higher.begin(), higher.end(), surfaces_.begin());
  if (gone_) take_away();
  show({});
}

// Floor and lower halves are the half of a shear box that moves.
bool Walls::goes_along(const std::string& name) const {
  return name == "floor" || container_.split <= 0 || name.ends_with(".lower");
}

Vec3 Walls::way_of(const std::string& name, const Motion& motion) const {
  const double left = name == "wall.left" ? 1 : 0, right = name == "wall.right" ? 1 : 0;
  const double front = name == "wall.front" ? 1 : 0, back = name == "wall.back" ? 1 : 0;
  return {(goes_along(name) ? motion.along : 0) + (left - right) * motion.in[0],
          (front - back) * motion.in[1], name == "floor" ? 0 : motion.up};
}

Vec3 Walls::displacement(const std::string& name) const { return way_of(name, so_far_); }

void Walls::show(const Motion& motion) {
  for (std::size_t k = 0; k < surfaces_.size(); ++k) {
    Surface& wall = surfaces_[k];
    const Vec3 so_far = displacement(wall.name), now = way_of(wall.name, motion);
    for (std::size_t n = 0; n < wall.nodes(); ++n)
      wall.position[n] = home_[k][n] + so_far, wall.motion[n] = now;
  }
}

void Walls::go(const Motion& motion) {
  show(motion);
  so_far_.along += motion.along, so_far_.up += motion.up;
  for (std::size_t axis = 0; axis < 2; ++axis) so_far_.in[axis] += motion.in[axis];
}

void Walls::move(double along, double up) { go({.along = along, .up = up}); }

double Walls::extent(std::size_t axis) const {
  const auto a = static_cast<Eigen::Index>(axis);
  return container_.high[a] - container_.low[a] - 2 * so_far_.in[axis];
}

double Walls::area() const {
  const bool moved = so_far_.in != std::array{0.0, 0.0};
  return moved ? extent(0) * extent(1) : container_.area();
}

// The area that stones press on is that of the bed's side as it is now. Periodic sides, and the
// faces of a plane model, have no walls. A bed that is squeezed from above widens all the time.
void Walls::confine(const ServoParameters& p, double dt, double pressure, double height,
                    const std::array<double, 2>& push) {
  Motion motion;
  for (std::size_t axis = 0; axis < 2; ++axis)
    if (pressed(axis))
      motion.in[axis] = servo_[axis].advance(
          p, dt, push[axis], pressure * extent(1 - axis) * height, {.follows = true});
  go(motion);
}

bool Walls::pressed(std::size_t axis) const {
  return !container_.periodic[axis] && (axis == 0 || container_.dimension == Dimension::space);
}

void Walls::aim() {
  for (Servo& servo : servo_) servo.aim();
}

double Walls::steady_for() const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 2; ++axis)
    if (pressed(axis)) least = std::min(least, servo_[axis].steady_for());
  return least;
}

// The floor comes first and stays where it is.
void Walls::take_away() {
  gone_ = true;
  const std::size_t kept = floor_material_ >= 0 && !surfaces_.empty() ? 1 : 0;
  surfaces_.erase(surfaces_.begin() + static_cast<std::ptrdiff_t>(kept), surfaces_.end());
  home_.resize(kept);
}

// The state, listed once: height, along, up, in across x and y (m), gone, the two servos.
void Walls::save(io::File& file, const std::string& group, const par::Comm& comm) const {
  std::vector<double> row{height_,       so_far_.along, so_far_.up,
                          so_far_.in[0], so_far_.in[1], gone_ ? 1.0 : 0.0};
  for (const Servo& servo : servo_)
    for (const double value : servo.row()) row.push_back(value);
  const std::span<const double> mine(row.data(), comm.root() ? row.size() : 0);
  file.write<double>(group + "/walls", mine, row.size(),
                     {fmt::format("m, m, m, m, m, -, {0}, {0}", Servo::units),
                      "height of the walls (m; 0: none yet), way of floor and lower halves along "
                      "x, of walls upwards, inwards across x, across y (m), whether they are gone, "
                      "servos of the walls across x and across y: " +
                          std::string(Servo::columns)});
}

void Walls::load(const io::File& file, const std::string& group) {
  const auto row = file.read_all<double>(group + "/walls");
  constexpr std::size_t own = 6, each = std::tuple_size_v<Servo::Row>;
  if (row.size() != own + servo_.size() * each)
    throw RunError(group + "/walls does not hold the state of walls");
  so_far_ = {.along = row[1], .up = row[2], .in = {row[3], row[4]}};
  gone_ = row[5] != 0;
  for (std::size_t axis = 0; axis < servo_.size(); ++axis) {
    Servo::Row servo;
    std::copy_n(row.begin() + static_cast<std::ptrdiff_t>(own + axis * each), each, servo.begin());
    servo_[axis].set(servo);
  }
  if (row[0] > 0) raise(row[0]);
}

}  // namespace trackbed::bed
