// Servo control of a plate: moves it so that the force of the stones on it reaches a target.
#pragma once

#include "trackbed/input/section.hpp"
#include "trackbed/io/archive.hpp"

namespace trackbed::bed {

struct ServoParameters {
  double speed = 0.5;        // m/s, largest
  double acceleration = 50;  // m/s^2, largest
  double average = 0.01;     // s, time constant of the measured force
  double tolerance = 0.02;   // of the target: steady if the average is within it ...
  double hold = 0.05;        // s, ... for this time
};

// The speed is proportional to the force error, (target - force)/target * speed, with the force
// averaged over average/10. Acceleration is limited, braking is not, since the plate would
// otherwise overrun a stiff bed. Each time the average crosses the target from below, the gain is
// halved (down to 1/16), so that the servo converges on a bed of any stiffness; if the average
// stays too low for `hold`, because stones yield, the gain is doubled. Displacements, speeds and
// forces are positive towards the stones.
class Servo {
 public:
  struct Mode {
    bool integral = false;  // integral term for the speed: for a bed that deforms continuously
    bool vibrates = false;  // a vibration is superposed
  };
  void retarget();  // before another target: it has to become steady again
  void reset();     // to the initial state, for another bed
  // Displacement in this window, m, for the force of the stones in the last one and the target, N.
  double advance(const ServoParameters& p, double dt, double force, double target,
                 const Mode& mode);
  // The same with a given displacement, m.
  void drive(const ServoParameters& p, double dt, double force, double displacement);
  double mean() const { return state_.mean; }              // N
  double steady_for() const { return state_.steady_for; }  // s, within the tolerance up to now

  void archive(io::Archive& a);

 private:
  void average_force(const ServoParameters& p, double dt, double force, bool vibrates);

  struct State {
    double speed = 0;             // m/s
    double recent = 0, mean = 0;  // N, averaged over average/10 and average
    double gain = 1;
    double steady_for = 0, low_for = 0;  // s, within the tolerance, below it
    double drift = 0;                    // m/s, integral term
  };
  State state_;
};

}  // namespace trackbed::bed
