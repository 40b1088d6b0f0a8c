// Walls that stages move. They are moved as the platen is: what a window shows is where it begins
// and how far it goes, what is kept is where it ends. So the state is two lengths, and the next
// window, or a run resumed before it, finds the walls where this one left them.
//
// Nodes are placed anew from where they were built in each window, so that rounding cannot bend a
// wall. Cost: all nodes of all walls per window, on every rank alike; a few hundred.
#include <algorithm>
#include <array>

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
  show(0, 0);
}

// Floor and lower halves are the half of a shear box that moves.
bool Walls::goes_along(const std::string& name) const {
  return name == "floor" || container_.split <= 0 || name.ends_with(".lower");
}

Vec3 Walls::displacement(const std::string& name) const {
  return {goes_along(name) ? along_ : 0, 0, name == "floor" ? 0 : up_};
}

void Walls::show(double along, double up) {
  for (std::size_t k = 0; k < surfaces_.size(); ++k) {
    Surface& wall = surfaces_[k];
    const Vec3 so_far = displacement(wall.name);
    const Vec3 motion(goes_along(wall.name) ? along : 0, 0, wall.name == "floor" ? 0 : up);
    for (std::size_t n = 0; n < wall.nodes(); ++n)
      wall.position[n] = home_[k][n] + so_far, wall.motion[n] = motion;
  }
}

void Walls::move(double along, double up) {
  show(along, up);
  along_ += along, up_ += up;
}

// The floor comes first and stays where it is.
void Walls::take_away() {
  gone_ = true;
  const std::size_t kept = floor_material_ >= 0 && !surfaces_.empty() ? 1 : 0;
  surfaces_.erase(surfaces_.begin() + static_cast<std::ptrdiff_t>(kept), surfaces_.end());
  home_.resize(kept);
}

// The state, listed once: height, along, up (m), gone.
void Walls::save(io::File& file, const std::string& group, const par::Comm& comm) const {
  const std::array row{height_, along_, up_, gone_ ? 1.0 : 0.0};
  const std::span<const double> mine(row.data(), comm.root() ? row.size() : 0);
  file.write<double>(group + "/walls", mine, row.size(),
                     {"-",
                      "height of the walls (m; 0: none yet), way of floor and lower halves along x "
                      "and of walls upwards (m), whether they are gone"});
}

void Walls::load(const io::File& file, const std::string& group) {
  const auto row = file.read_all<double>(group + "/walls");
  if (row.size() != 4) throw RunError(group + "/walls does not hold the state of walls");
  along_ = row[1], up_ = row[2], gone_ = row[3] != 0;
  if (row[0] > 0) raise(row[0]);
}

}  // namespace trackbed::bed
