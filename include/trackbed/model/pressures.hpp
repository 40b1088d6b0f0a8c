// Prescribed loads on the top of a ground: uniform pressures on rectangles that are fixed or move
// along x, with a given time function (course).
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/couple/footprints.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::model {

enum class PressureCourse { dead, rise, pulse, harmonic, table };

struct PressureParameters {
  std::string name;
  std::vector<double> x = {0, 1};              // m, from and to, at 0 s
  std::vector<double> y = {};                  // m; none: all of the ground's width
  double pressure = 0, along = 0, across = 0;  // Pa, downwards, along x and y
  PressureCourse course = PressureCourse::rise;
  double begin = 0, duration = 0;  // s
  double frequency = 0;            // Hz
  std::string file;                // time_s, factor
  double speed = 0;                // m/s, along x
  void declare(input::Section& s);

  struct Table {
    std::vector<double> times, factors;  // s, -
  };
  Table table() const;  // of the file; empty without one. Throws InputError.
};

class Pressures {
 public:
  // `top`: the undeformed surface. `around`: periodic along x. Throws InputError for invalid tables
  // and for fixed rectangles outside of the surface. Identical on all ranks.
  Pressures(const par::Comm& comm, const Surface& top, bool around,
            const std::vector<PressureParameters>& parameters);

  // Adds their forces at a time (s, from the start of the ground's motion) to those of the top's
  // nodes, N.
  // add_dead: only those of dead loads.
  void add(double time, std::vector<Vec3>& nodes) const;
  void add_dead(std::vector<Vec3>& nodes) const;

 private:
  struct One {
    PressureParameters given;
    couple::Rectangle rectangle;                        // at 0 s
    std::vector<couple::Footprints::NodeWeight> fixed;  // weights of rectangles that do not move
    PressureParameters::Table table;
  };
  double factor(const One& one, double time) const;
  std::vector<couple::Footprints::NodeWeight> weights(const couple::Rectangle& rectangle) const;
  std::vector<couple::Rectangle> moved(const couple::Rectangle& rectangle, double travel) const;
  void add_force(const One& one, double time, double factor, std::vector<Vec3>& nodes) const;

  par::Comm comm_;
  Surface top_;
  double low_ = 0, length_ = 0;  // m, of the top along x if it is periodic; else 0
  std::vector<One> all_;
};

}  // namespace trackbed::model
