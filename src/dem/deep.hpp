// What two pieces feel whose cores are in one another (packing too fast, too small a rounding).
//
// For each way out a of the cores (face normals, crossed edges) the second piece is moved out along
// it, by l_a, until it all but touches; there the smooth maximum of features.hpp is M_a, with
// normals that are all known. Going in by l_a makes it grow as a single feature would:
//   M = sum w_a (1 + l_a / R) M_a / sum w_a,   w_a = s_a l_a^-q,
// R the overlap of what touches (sum of the radii), s_a the sin^2 of crossed edges, 1 for faces.
// The shortest way decides, and where two are equally short the energy changes smoothly from one
// to the other: with the shortest alone it leaped there, and up to 40 % more came back than was
// stored. Force and torque are the exact gradient: l_a, its direction and s_a change with the pose
// (separation.hpp, WayOut).
#pragma once

#include "features.hpp"
#include "separation.hpp"

namespace trackbed::dem {

class DeepBlend {
 public:
  // Ways this much longer than the shortest weigh nothing: 1.5^-q < 1e-4.
  static constexpr double longest = 1.5;
  explicit DeepBlend(double touching) : R_(touching) {}
  // `moved`: what is felt when the second is moved out by `length` m; `shortest` m of all ways.
  // Cores are apart there, so all its normals are known.
  void add(const WayOut& way, double length, double shortest, const Wrench& moved);
  // M = 0 if no way weighed anything.
  Wrench result() const;

 private:
  // Change of a scalar per m that the second piece moves, and per rad that the first one turns.
  struct Slope {
    Vec3 move = Vec3::Zero(), turn = Vec3::Zero();
    void add(double factor, const Slope& s) { move += factor * s.move, turn += factor * s.turn; }
  };
  double R_;  // m
  double weight_ = 0, M_ = 0, spread_ = 0;
  Vec3 x_ = Vec3::Zero();
  Slope of_M_, of_log_weight_, of_both_;  // sums of w dM, w d(log w), w M d(log w)
};

}  // namespace trackbed::dem
