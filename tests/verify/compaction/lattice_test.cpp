// Triaxial compression of a face-centred cubic array of smooth spheres between flat walls, with
// known strength: the walls of a box hold a pressure, the platen moves down, and the ratio of their
// forces follows from the geometry of the array (as in Thornton 1979,
// doi:10.1680/geot.1979.29.4.441, for an infinite array; here with its ends, so that the ratio is
// exact).
//
// Layers of n x n and (n-1) x (n-1) spheres alternate. Once neighbours in a layer have separated,
// all forces f act between layers, and each of the I interfaces has 4 (n-1)^2 contacts:
//   platen:            F_1 = 4 (n-1)^2 f h/d,
//   yielding walls:    F_3 = I 2 (n-1) f s/(2 d),     F_1/F_3 = 4 (n-1) h/(I s),
// with d the distance of centres, h that of layers and s that of neighbours in a layer. Walls under
// pressure do not keep s_x and s_y equal: the direction that extends becomes weaker and continues
// to extend, while neighbours in the other direction stay in contact and share the force. (s_x^2 +
// s_y^2)/4 + h^2 = d^2.
#include <gtest/gtest.h>

#include <cmath>

#include "support/scene.hpp"
#include "support/verified.hpp"
#include "trackbed/bed/bed.hpp"
#include "trackbed/couple/coupler.hpp"

namespace trackbed::lattice_test {
namespace {

constexpr double radius = 0.02, width = 2 * radius;  // m
constexpr int n = 4, layers = 5, interfaces = layers - 1;
constexpr double side = n * width;               // m
constexpr double confinement = 20e3;             // Pa
const double spacing = radius * std::sqrt(2.0);  // m, of layers, as built

dem::Physics smooth() {
  dem::Physics p;
  for (const char* name : {"wall", "ball"}) p.materials.push_back({.name = name});
  for (const char* other : {"wall", "ball"}) {
    dem::ContactLaw law;
    law.first = "ball", law.second = other;
    law.k_n = law.k_s = 1e8;
    law.friction = 0;
    law.zeta_n = law.zeta_s = 0.3;
    p.laws.push_back(law);
  }
  return p;
}

dem::Domain domain() {
  dem::Domain d;
  d.low = {0, 0, -0.2}, d.high = {side, side, 1};
  return d;
}

dem::Parameters weightless() {
  dem::Parameters p;
  p.gravity = 0;
  return p;
}

std::vector<dem::NewParticle> array(int shape) {
  std::vector<dem::NewParticle> all;
  for (int layer = 0; layer < layers; ++layer) {
    const int across = layer % 2 == 0 ? n : n - 1;
    const double first = layer % 2 == 0 ? radius : width;
    for (int i = 0; i < across; ++i)
      for (int j = 0; j < across; ++j) {
        dem::NewParticle ball;
        ball.id = static_cast<Id>(all.size());
        ball.shape = shape;
        ball.material = 1;
        ball.position = {first + i * width, first + j * width, radius + layer * spacing};
        all.push_back(ball);
      }
  }
  return all;
}

bed::PlatenParameters servo() {
  bed::PlatenParameters p;
  p.pressure = confinement;
  p.speed = 0.05, p.average = 5e-3;
  return p;
}

class Array {
 public:
  explicit Array(const par::Comm& comm)
      : particles_(comm, smooth(), weightless(), domain()),
        coupler_(comm),
        walls_(bed::Container(domain()), 0, 0),
        platen_(servo(), domain(), 0) {
    dem::Template ball = test::sphere(radius);
    const auto all = array(particles_.add_template(ball));
    particles_.add(comm.root() ? all : std::vector<dem::NewParticle>{});
    particles_.set_local_damping(0.7);
    walls_.build(0.3);
    platen_.place(width + interfaces * spacing);
    std::vector<Surface*> surfaces;
    for (Surface& wall : walls_.surfaces()) surfaces.push_back(&wall);
    surfaces.push_back(&platen_.surface());
    particles_.set_surfaces(surfaces);
    for (Surface* surface : surfaces) coupler_.add(*surface);
    coupler_.connect(
        [&](const Vec3& low, const Vec3& high) { return particles_.reaches(low, high); });
    dt_ = particles_.stable_step();
  }
  // The platen has the pressure of the walls, or moves down by `down`, m.
  void compress(double time) { run(time, 0, false); }
  void drive(double time, double down) { run(time, down, true); }
  Vec3 on(const std::string& name) const {
    Vec3 force = Vec3::Zero();
    std::size_t number = 0;
    for (const Surface& wall : const_cast<bed::Walls&>(walls_).surfaces()) {
      if (wall.name == name)
        for (const Vec3& node : coupler_.mean_force(number)) force += node;
      ++number;
    }
    if (name == "platen")
      for (const Vec3& node : coupler_.mean_force(number)) force += node;
    return force;
  }
  const bed::Walls& walls() const { return walls_; }
  const bed::Platen& platen() const { return platen_; }

 private:
  void run(double time, double down, bool driven) {
    for (double t = 0; t < time; t += window()) {
      const std::array force_on{(on("wall.right").x() - on("wall.left").x()) / 2,
                                (on("wall.back").y() - on("wall.front").y()) / 2};
      platen_.set_area(walls_.area());
      if (driven)
        platen_.drive(window(), down / time * window(), on("platen").z());
      else
        platen_.advance(window(), on("platen").z());
      walls_.confine(servo(), window(), confinement, platen_.z(), force_on);
      coupler_.publish();
      particles_.advance(window(), substeps);
      const dem::SurfaceAction& did = particles_.surface_action();
      coupler_.collect(substeps, window(), {did.force, did.moment, did.work});
    }
  }
  static constexpr int substeps = 5;
  double window() const { return substeps * dt_; }
  dem::Particles particles_;
  couple::Coupler coupler_;
  bed::Walls walls_;
  bed::Platen platen_;
  double dt_ = 0;
};

TEST(Triaxial, StrengthOfAFaceCentredCubicArray) {
  Array array(par::Comm::world());
  array.compress(0.2);
  EXPECT_GT(array.walls().steady_for(), servo().hold);
  EXPECT_TRUE(array.platen().steady());
  array.drive(0.3, 1e-3);
  array.drive(0.1, 0);
  const auto across = [&](const char* low, const char* high, int axis) {
    return (array.on(high)[axis] - array.on(low)[axis]) / 2;
  };
  const double in_x = array.walls().displacement("wall.left").x(),
               in_y = array.walls().displacement("wall.front").y();
  const double h = (array.platen().z() - width) / interfaces;
  const double s_x = width - 2 * in_x / (n - 1), s_y = width - 2 * in_y / (n - 1);
  const double f_x = across("wall.left", "wall.right", 0),
               f_y = across("wall.front", "wall.back", 1);
  ASSERT_GT(std::max(s_x, s_y), 1.005 * width);
  // Contacts of f = 40 N overlap by 0.4 um, 1e-5 of d.
  verified::near(
      "F_1 over F on the walls that move apart", "-",
      array.on("platen").z() / (s_x > s_y ? f_x : f_y),
      4 * (n - 1) * h / (interfaces * std::max(s_x, s_y)),
      {2e-3, "forces that are unbalanced 0.1 s after the platen stops; overlaps are 1e-5 of d"});
  const double height = array.platen().z();
  const verified::Tolerance held{servo().tolerance, "tolerance of the servo"};
  verified::near("pressure of walls across x", "Pa", f_x / ((side - 2 * in_y) * height),
                 confinement, held.of(confinement));
  verified::near("pressure of walls across y", "Pa", f_y / ((side - 2 * in_x) * height),
                 confinement, held.of(confinement));
  // The walls follow the array.
  verified::near("distance of centres in adjacent layers", "m",
                 std::sqrt(h * h + (s_x * s_x + s_y * s_y) / 4), width,
                 {2e-6, "overlaps of walls, layers and plates"});
}

}  // namespace
}  // namespace trackbed::lattice_test
