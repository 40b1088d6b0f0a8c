// Deflection of the rail at both ends of a bed, above its outermost sleepers and above the next
// ones, which lie on springs. Springs that do not match the bed form a transition of their own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/io/archive.hpp"
#include "trackbed/track/on_bed.hpp"

namespace trackbed::model {

class RailEnds {
 public:
  // To be called in every window with a train over a bed with this number of sleepers; starts again
  // with each train.
  void observe(const track::TrainOnBed& train, std::size_t sleepers);
  // A sentence for each end at which both deflections differ too much, once the train has passed
  // it. `line`: the track, whose sleeper `before` is the first of the bed with `sleepers`.
  std::vector<std::string> warnings(const track::LineParameters& line, std::size_t before,
                                    std::size_t sleepers) const;
  // Nothing if there was no train.
  void archive(io::Archive& a);

 private:
  // m, displacement of the rail, mean of all rails, above the outermost sleepers at the start of
  // the bed, those before it, the outermost at its end, those behind it: before the train comes,
  // and the lowest since.
  std::vector<double> before_, lowest_;
  double last_axle_ = 0;  // m, from the start of the track
};

}  // namespace trackbed::model
