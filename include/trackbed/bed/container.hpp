// Lateral confinement of a bed: a box or an upright cylinder, whose walls a stage may move.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "trackbed/bed/servo.hpp"
#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/dem/particles.hpp"
#include "trackbed/io/archive.hpp"

namespace trackbed::bed {

enum class ContainerKind { box, cylinder };

// Facets of a cylinder. The polygon's corners lie on the circle, so its area is smaller than that
// of the circle by 1 - sin(2 pi/n)/(2 pi/n): 0.16 % with 64.
inline constexpr int facets = 64;

// A box between `low` and `high`, open at the top; or the cylinder inscribed in it, whose base is a
// polygon of `facets` sides.
struct Container {
  Container() = default;
  explicit Container(const dem::Domain& domain);  // the box of the domain

  ContainerKind kind = ContainerKind::box;
  Dimension dimension = Dimension::space;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // m, z = 0; plane: y is the thickness, about 0
  std::array<bool, 2> periodic{false, false};    // along x, y: no walls there
  double depth = 0;   // m, of the walls' lower ends below 0, since a ground may settle
  double split = 0;   // m, height at which walls are divided; 0: undivided
  double beside = 0;  // m, width of the floor outside of the walls

  double area() const;          // m^2, of the floor between the walls (of the polygon)
  Vec3 centre() const;          // m
  double radius() const;        // m, of the cylinder's circle
  double clear_radius() const;  // m, from the axis to the middle of a facet
};

// Flat floor at z = 0 (if `floor`) and walls at the ends (and sides in space) up to `height`;
// periodic sides have none. All extend beyond their edges, so that no stone escapes through a
// corner. Names: floor, wall.left, wall.right, wall.front, wall.back or wall.cylinder; divided
// walls have the suffix .lower or .upper. Both halves have rims that extend outwards at the height
// of the division, so that it stays closed while one half moves. Walls with floor around them are
// boards of 50 mm, which stones may touch on both sides.
std::vector<Surface> walls(const Container& container, double height, int material, bool floor);
inline std::vector<Surface> walls(const dem::Domain& domain, double height, int material,
                                  bool floor) {
  return walls(Container(domain), height, material, floor);
}

// Floor and walls of a run with their positions and motion. All ranks hold the same. Surfaces keep
// their address while their number is constant.
class Walls {
 public:
  // Materials of the walls and of the floor; no floor if its material is below 0.
  Walls(const Container& container, int material, int floor_material);

  void build(double height);  // m; existing walls are replaced in place
  // One window: floor and lower halves (all walls if undivided) move along x, all walls except the
  // floor upwards, m.
  void move(double along, double up);
  // One window in which opposite walls of a box move inwards or outwards by equal amounts, so that
  // the pressure on the stones, which fill the box up to `height`, m, becomes `pressure`, Pa.
  // `force`: outward force of the stones on a wall across x and on one across y in the last window,
  // N.
  void confine(const ServoParameters& p, double dt, double pressure, double height,
               const std::array<double, 2>& force);
  void retarget();  // before another pressure: they have to become steady again
  void remove();    // all walls except the floor, permanently

  std::vector<Surface>& surfaces() { return surfaces_; }
  double height() const { return height_; }  // m; 0: no walls yet
  const std::vector<std::string>& names() const {
    return names_;
  }                                                  // also of removed and future walls
  Vec3 displacement(const std::string& name) const;  // m, since it was built
  double area() const;  // m^2, of the floor between the walls as they are now
  double steady_for()
      const;  // s, for which the pressure of all confined walls has been within tolerance

  void archive(io::Archive& a);

 private:
  // Displacement increments of a window, m: along x, of walls upwards, inwards across x and y.
  struct Motion {
    double along = 0, up = 0;
    std::array<double, 2> in{0, 0};
  };
  void set_motion(const Motion& motion);
  void advance(const Motion& motion);
  Vec3 displacement_of(const std::string& name, const Motion& motion) const;
  double extent(std::size_t axis) const;  // m, between opposite walls
  bool moves_along(const std::string& name) const;
  bool is_confined(std::size_t axis) const;  // by `confine`

  Container container_;
  int material_, floor_material_;
  std::vector<Surface> surfaces_;
  std::vector<std::vector<Vec3>> initial_;  // m, nodes as built
  std::vector<std::string> names_;
  double height_ = 0;  // m
  Motion total_;
  std::array<Servo, 2> servo_;  // of the walls across x, across y
  bool removed_ = false;
};

}  // namespace trackbed::bed
