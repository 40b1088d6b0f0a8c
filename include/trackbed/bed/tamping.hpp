// The tools of a tamping machine: pairs of vibrating tines that are inserted into the ballast
// beside each sleeper and compact it below by squeezing.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/io/archive.hpp"

namespace trackbed::bed {

struct TampingParameters {
  double lift = 0.02;                       // m, of the sleepers, at the first insertion
  double depth = 0.12;                      // m, of the tips below the lifted sleepers
  double gap = 0.09;                        // m, from a sleeper's face to open tines
  double closing = 0.06;                    // m, displacement of a tine towards the sleeper
  double thickness = 0.03, width = 0.12;    // m, of a tine along x, along y
  std::vector<double> y;                    // m, centres of the tines of a row; space
  double amplitude = 5e-3, frequency = 35;  // m, Hz, along x
  double insertion = 0.4, squeeze = 0.8, withdrawal = 0.3;  // s
  double force = 10e3;                                      // N, of a tine: it stops at this force
  void declare(input::Section& s);
  bool operator==(const TampingParameters&) const = default;
  double cycle() const { return insertion + squeeze + withdrawal; }  // s
  double reach() const { return gap + thickness + amplitude; }       // m, from a sleeper's face
};

// Tamped sleepers, all equal.
struct TampedSleepers {
  std::vector<double> x{};  // m, centres
  double width = 0;         // m, along x
};

// The tines on one side of a sleeper are attached to an arm, both arms of a sleeper to a frame that
// moves down. Arms and frame yield as under a hydraulic drive: their speed is the nominal one times
// 1 - F/F0, with the resistance F of the stones and the capacity F0 of the drive; lost displacement
// is not recovered. All ranks hold the same.
class Tines {
 public:
  // In a plane model `thickness`, m, is their width and y is not used.
  Tines(const TampingParameters& parameters, const TampedSleepers& sleepers, Dimension dimension,
        double thickness, int material);

  // Heights of the tips, m: initially above `top`, where they must touch nothing; finally `depth`
  // below lifted sleepers whose lower faces are at `underside`.
  void set_heights(double top, double underside);
  // One window from `time` to `time` + dt, s since the stage began, under the mean forces of stones
  // on the nodes of the surfaces in the last window, N.
  void advance(double time, double dt, const std::array<std::span<const Vec3>, 2>& force);
  // Positions `time` s after the stage began, without motion, until the next `advance`.
  void show_at_rest(double time);
  double lift(double time) const;  // m, of the sleepers
  // Tines at the sides of smaller and of larger x of all sleepers.
  std::array<Surface, 2>& surfaces() { return surfaces_; }
  static std::array<std::string, 2> names() { return {"tines.left", "tines.right"}; }
  // m, mean of the arms of that name, from the open and raised position, without vibration.
  Vec3 displacement(const std::string& name) const;
  double tip() const { return foot_; }  // m, lowest height of the tips

  void archive(io::Archive& a);  // after loading, `show_at_rest` positions them

 private:
  struct Frame {
    double down = 0;                 // m
    std::array<double, 2> in{0, 0};  // m, of its arms
  };
  Vec3 displacement_of(const Frame& frame, std::size_t side, double vibration) const;
  double vibration(double time) const;
  void move(Frame& frame, double time, double dt, const std::array<Vec3, 2>& resistance) const;
  void place(std::size_t sleeper, const Frame& begin, const Frame& end,
             const std::array<double, 2>& vibration);

  TampingParameters parameters_;
  std::size_t rows_;  // tines on an arm
  std::array<Surface, 2> surfaces_;
  std::array<std::vector<Vec3>, 2> initial_;  // m, nodes of open tines with their tips at z = 0
  std::vector<Frame> frames_;                 // of each sleeper
  double highest_ = 0, underside_ = 0;        // m, arguments of `set_heights`
  double top_ = 0, foot_ = 0;                 // m, heights of the tips
};

}  // namespace trackbed::bed
