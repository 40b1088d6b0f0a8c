// Field files of one instant, and the parts of grids that runs of all kinds have. Private to the
// module.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "trackbed/io/fields.hpp"
#include "trackbed/observe/results.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::observe {

// Writes the parts that `files` asks for and enters each into the list of its series.
class FieldSeries {
 public:
  // Collective, as `write`.
  FieldSeries(const par::Comm& comm, const FieldFiles& files);
  // `grid` makes the part of this rank, and is called only if the part is asked for.
  void write(std::string_view part, const std::function<io::Grid()>& grid);
  // The same for what all ranks know: the root writes it.
  void write_on_root(std::string_view part, const std::function<io::Grid()>& grid);

 private:
  const par::Comm& comm_;
  const FieldFiles& files_;
};

// Where a drawn train is.
struct TrainPlace {
  double origin;                                   // m, x of the model at the start of the track
  double wheel_radius;                             // m
  double level;                                    // m, z of the top of the unloaded rail
  std::function<double(std::size_t side)> across;  // m, y of a rail
};

// Rails of the whole track as lines, wheels as disks on them, with their displacements.
io::Grid rails_and_wheels(const track::Passage& passage, const track::Train& train,
                          const TrainPlace& place);

}  // namespace trackbed::observe
