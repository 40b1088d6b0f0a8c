// What rail, sleepers and pads went through at most, all along a track alone: extremes of every
// step, of each sleeper or, of a track without sleepers, at each whole metre.
#pragma once

#include <string>
#include <vector>

#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::observe {

class PassageEnvelope {
 public:
  explicit PassageEnvelope(const track::Line& line);
  // The present step. Local.
  void see(const track::Passage& passage);
  // Extremes so far, in results and in checkpoints, and back. Collective; `load` throws RunError
  // for those of another track, or if a program without them wrote the file.
  void save(io::File& file, const par::Comm& comm) const;
  void load(const io::File& file);

 private:
  // Least and largest value at each place, left before right; before the first step none.
  struct Range {
    std::string path, unit, meaning;  // of a history: PATH_min, PATH_max
    std::vector<double> least, most;
    void see(std::size_t place, double value);
  };
  const track::Line& line_;
  std::vector<double> x_;  // m, of each place, on two rails twice
  std::vector<track::RailPoint> rail_points_;
  Range rail_, sleeper_, seat_;
};

}  // namespace trackbed::observe
