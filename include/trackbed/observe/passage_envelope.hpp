// Envelopes of rail, sleepers and pads along a track alone: extremes over every step, at each
// sleeper or, for a track without sleepers, at each whole metre.
#pragma once

#include <string>
#include <vector>

#include "trackbed/io/archive.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::observe {

class PassageEnvelope {
 public:
  explicit PassageEnvelope(const track::Line& line);
  // Updates the extremes with the present step. Local.
  void update(const track::Passage& passage);
  void archive(io::Archive& a);  // for results, too

 private:
  // Smallest and largest value at each place, left before right; infinite before the first step.
  struct Range {
    std::string path, unit, meaning;  // of a history: PATH_min, PATH_max
    std::vector<double> least, most;
    void update(std::size_t place, double value);
  };
  const track::Line& line_;
  std::vector<double> x_;  // m, of each place, twice on two rails
  std::vector<track::RailPoint> rail_points_;
  Range rail_, sleeper_, seat_;
};

}  // namespace trackbed::observe
