// Loads on the top of a ground that are known beforehand: even pressures on rectangles that stand
// or go along x, with a course over time.
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

namespace trackbed::couple {

enum class Course { dead, rise, pulse, harmonic, table };

struct PressureParameters {
  std::string name;
  std::vector<double> x = {0, 1};              // m, from and to, at 0 s
  std::vector<double> y = {};                  // m; none: all of the ground's width
  double pressure = 0, along = 0, across = 0;  // Pa, downwards, along x and y
  Course course = Course::rise;
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
  // `top`: the surface at rest. `around`: what leaves it at one end along x comes in at the other.
  // Throws InputError for bad tables, and for rectangles that stand beside it. Every rank alike.
  Pressures(const par::Comm& comm, const Surface& top, bool around,
            const std::vector<PressureParameters>& parameters);

  // Adds their forces at a time (s, from when the ground is let go) to those of the top's nodes, N.
  // `dead`: of the dead ones alone.
  void add(double time, std::vector<Vec3>& nodes) const;
  void add_dead(std::vector<Vec3>& nodes) const;

 private:
  struct One {
    PressureParameters given;
    Rectangle rectangle;                      // at 0 s
    std::vector<Footprints::Share> standing;  // of those that do not move
    PressureParameters::Table table;
  };
  double factor(const One& one, double time) const;
  std::vector<Footprints::Share> shares(const Rectangle& rectangle) const;
  std::vector<Rectangle> after(const Rectangle& rectangle, double way) const;
  void press(const One& one, double time, double factor, std::vector<Vec3>& nodes) const;

  par::Comm comm_;
  Surface top_;
  double low_ = 0, length_ = 0;  // m, of the top along x, if loads go around; else 0
  std::vector<One> all_;
};

}  // namespace trackbed::couple
