// What holds a bed at its sides: a box or an upright cylinder, whose walls a stage may move.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "trackbed/bed/servo.hpp"
#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/dem/particles.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::bed {

enum class ContainerKind { box, cylinder };

// Sides of a cylinder. Its polygon has corners on the circle, so its area is smaller than the
// circle's by 1 - sin(2 pi/n)/(2 pi/n): 0.16 % with 64.
inline constexpr int facets = 64;

// A box between `low` and `high`, open at the top; or the cylinder inscribed in it, which stands on
// a polygon of `facets` sides.
struct Container {
  Container() = default;
  explicit Container(const dem::Domain& domain);  // the box as large as the domain

  ContainerKind kind = ContainerKind::box;
  Dimension dimension = Dimension::space;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // m, z = 0; plane: y is the thickness, about 0
  std::array<bool, 2> periodic{false, false};    // along x, y: no walls there
  double depth = 0;   // m, below 0: where walls begin, since a ground may settle
  double split = 0;   // m, walls are divided at this height; 0: not
  double beside = 0;  // m, of floor around the walls

  double area() const;          // m^2, of the floor between the walls (of the polygon)
  Vec3 centre() const;          // m
  double radius() const;        // m, of the cylinder's circle
  double clear_radius() const;  // m, from the axis to the middle of a facet
};

// Flat floor at z = 0 (if `floor`) and walls at the ends (and sides in space) up to `height`;
// periodic sides have none. All reach beyond their edges, so that no stone slips through a corner.
// Names: floor, wall.left, wall.right, wall.front, wall.back or wall.cylinder; of divided walls
// with .lower or .upper behind. Two halves have rims that lead outwards at the height where they
// meet, so that they stay closed while one moves. Walls with floor around them are boards of 50 mm,
// which stones may touch on both sides.
std::vector<Surface> walls(const Container& container, double height, int material, bool floor);
inline std::vector<Surface> walls(const dem::Domain& domain, double height, int material,
                                  bool floor) {
  return walls(Container(domain), height, material, floor);
}

// Floor and walls of a run, as they stand and move. All ranks hold the same. Surfaces keep their
// address while their number stays.
class Walls {
 public:
  // Materials of the walls and of the floor, which is there only if it has one (0 or more).
  Walls(const Container& container, int material, int floor_material);

  void raise(double height);  // m; walls that stand already are replaced in place
  // One window: floor and lower halves (all, if walls are not divided) go along x, all walls but
  // the floor up, m.
  void move(double along, double up);
  // One window in which opposite walls of a box go inwards (or give way) by the same, so that each
  // presses with `pressure`, Pa, on the stones, which fill it up to `height`, m. `push`: that of
  // stones on a wall across x, across y, outwards, in the last window, N.
  void confine(const ServoParameters& p, double dt, double pressure, double height,
               const std::array<double, 2>& push);
  void aim();        // another pressure is to come: they have to become steady anew
  void take_away();  // all but the floor, for good

  std::vector<Surface>& surfaces() { return surfaces_; }
  double height() const { return height_; }                         // m; 0: no walls yet
  const std::vector<std::string>& names() const { return names_; }  // also of those gone or to come
  Vec3 displacement(const std::string& name) const;                 // m, from where it was built
  double area() const;        // m^2, of the floor between them, where they stand now
  double steady_for() const;  // s, the pressure of all that are pressed has been within tolerance

  // Rank 0 of `comm` writes, all read; height, displacements, servos. Collective.
  void save(io::File& file, const std::string& group, const par::Comm& comm) const;
  void load(const io::File& file, const std::string& group);

 private:
  // Ways of a window, m: of what goes along, of walls upwards, inwards across x and y.
  struct Motion {
    double along = 0, up = 0;
    std::array<double, 2> in{0, 0};
  };
  void show(const Motion& motion);
  void go(const Motion& motion);
  Vec3 way_of(const std::string& name, const Motion& motion) const;
  double extent(std::size_t axis) const;  // m, between opposite walls
  bool goes_along(const std::string& name) const;
  bool pressed(std::size_t axis) const;  // by `confine`

  Container container_;
  int material_, floor_material_;
  std::vector<Surface> surfaces_;
  std::vector<std::vector<Vec3>> home_;  // m, nodes as built
  std::vector<std::string> names_;
  double height_ = 0;  // m
  Motion so_far_;
  std::array<Servo, 2> servo_;  // of the walls across x, across y
  bool gone_ = false;
};

}  // namespace trackbed::bed
