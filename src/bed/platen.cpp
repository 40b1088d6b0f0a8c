// A plate on the bed controlled by a servo (servo.cpp). It remains horizontal: its state is a
// height.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "plate.hpp"
#include "trackbed/bed/bed.hpp"

namespace trackbed::bed {

// Larger than the bed, so that no stone touches its edge; the pressure refers to the area of the
// bed. The order of the edges makes the normal point down, towards the stones.
Platen::Platen(const PlatenParameters& parameters, const Container& container, int material)
    : parameters_(parameters), area_(container.area()) {
  const Footprint outside =
      Footprint{container.low, container.high}.grown(beyond + container.beside);
  const Vec3 size = outside.high - outside.low;
  surface_ = plate("platen", material, outside.low, Vec3(0, size.y(), 0), Vec3(size.x(), 0, 0));
}

Surface& Platen::surface() { return surface_; }
double Platen::pressure() const { return servo_.mean() / area_; }
double Platen::z() const { return z_; }
bool Platen::steady() const { return servo_.steady_for() >= parameters_.hold; }
void Platen::set_area(double area) { area_ = area; }

void Platen::set_target(double pressure, bool integral) {
  parameters_.pressure = pressure;
  integral_ = integral;
  servo_.retarget();
}

// With values, from which the user can decide whether to wait longer or to change the bed.
std::string Platen::shortfall() const {
  if (steady()) return {};
  return fmt::format(
      "the averaged pressure of the platen is {:.1f} kPa; it was within {:g} % of {:g} kPa for "
      "{:.3g} s instead of {:g} s (platen.hold); give a longer stage.duration",
      pressure() / 1e3, 100 * parameters_.tolerance, parameters_.pressure / 1e3,
      servo_.steady_for(), parameters_.hold);
}

// All nodes have the same motion: the plate remains horizontal.
void Platen::set_motion(double motion) {
  for (Vec3& node : surface_.position) node.z() = z_;
  for (Vec3& node : surface_.motion) node = Vec3(0, 0, motion);
}

void Platen::place(double z) {
  servo_.reset();
  z_ = z, vibration_time_ = 0;
  set_motion(0);
}

// m, upwards, in this window. x = A sin(2 pi f t) min(1, t f): the amplitude increases in the first
// period, since a jump of speed would cause an impact. When it stops, the plate keeps its position,
// from which the servo continues.
double Platen::vibration_increment(double dt) {
  if (parameters_.vibration <= 0 || integral_) return 0;
  const double f = parameters_.frequency;
  const auto displacement = [&](double t) {
    return parameters_.vibration * std::sin(2 * std::numbers::pi * f * t) * std::min(1.0, t * f);
  };
  const double before = displacement(vibration_time_);
  vibration_time_ += dt;
  return displacement(vibration_time_) - before;
}

// Local; every rank has the same force and so the same motion.
void Platen::advance(double dt, double force_up) {
  const Servo::Mode mode{.integral = integral_,
                         .vibrates = parameters_.vibration > 0 && !integral_};
  const double down = servo_.advance(parameters_, dt, force_up, parameters_.pressure * area_, mode);
  const double motion = -down + vibration_increment(dt);
  set_motion(motion);
  z_ += motion;
}

void Platen::drive(double dt, double down, double force_up) {
  servo_.drive(parameters_, dt, force_up, down);
  set_motion(-down);
  z_ -= down;
}

// The target follows from the deck.
void Platen::archive(io::Archive& a) {
  a.part("servo", servo_);
  a("z", z_, {"m", "height of the lower face"});
  a("vibration_time", vibration_time_, {"s", "since the vibration began"});
  if (a.reads()) set_motion(0);
}

}  // namespace trackbed::bed
