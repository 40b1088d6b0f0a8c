// What moves a plate so that stones press on it with a wanted force.
#pragma once

#include <array>

#include "trackbed/input/section.hpp"

namespace trackbed::bed {

struct ServoParameters {
  double speed = 0.5;        // m/s, never faster
  double acceleration = 50;  // m/s^2, speed changes no faster
  double average = 0.01;     // s, time constant of the measured force
  double tolerance = 0.02;   // of the force: steady is the average within it ...
  double hold = 0.05;        // s, ... for so long
};

// Its speed follows the force error, (target - force)/target * speed, with the force averaged over
// average/10. Speeding up is limited by the acceleration, braking is not: a stiff bed would be
// overrun. Each time the average passes the target from below the gain is halved (down to 1/16), so
// that the servo settles on a bed of any stiffness; where it stays too low for `hold`, because
// stones give way, the gain doubles again. Ways, speeds and pushes are positive towards the stones.
class Servo {
 public:
  struct Mode {
    bool follows = false;   // learns the speed that keeps the force: for a bed that yields on
    bool vibrates = false;  // the plate is shaken as well
  };
  void aim();   // at another force from now on; it has to become steady anew
  void rest();  // as it began: what it knew of another bed means nothing
  // Way in this window, m, under the push of the stones in the last one and the wanted one, N.
  double advance(const ServoParameters& p, double dt, double push, double target, const Mode& mode);
  // The same with a given way, m.
  void drive(const ServoParameters& p, double dt, double push, double way);
  double mean() const { return state_.mean; }              // N
  double steady_for() const { return state_.steady_for; }  // s, within the tolerance so far

  using Row = std::array<double, 7>;
  static constexpr const char* columns =
      "speed (m/s), recent and mean force (N), gain, steady for (s), too low for (s), learnt speed "
      "(m/s)";
  static constexpr const char* units = "m/s, N, N, -, s, s, m/s";
  Row row() const;
  void set(const Row& row);

 private:
  void feel(const ServoParameters& p, double dt, double force, bool vibrates);

  struct State {
    double speed = 0;             // m/s
    double recent = 0, mean = 0;  // N, averaged over average/10 and average
    double gain = 1;
    double steady_for = 0, low_for = 0;  // s, within the tolerance, below it
    double drift = 0;                    // m/s, learnt
  };
  State state_;
};

}  // namespace trackbed::bed
