// Deflection of the rail at both ends of a bed, above its outermost sleepers and above the next
// ones, which lie on springs. Springs that do not match the bed form a transition of their own.
#pragma once

#include <string>
#include <vector>

#include "trackbed/io/archive.hpp"
#include "trackbed/track/on_bed.hpp"

namespace trackbed::model {

class RailEnds {
 public:
  // To be called in every window with a train over a bed with this number of sleepers.
  void observe(const track::TrainOnBed& train, std::size_t sleepers);
  // A sentence for each end at which both deflections differ too much.
  std::vector<std::string> warnings() const;
  // Nothing if there was no train.
  void archive(io::Archive& a);

 private:
  // m, lowest displacement of the rail, mean of all rails: of the outermost sleepers at the start
  // of the bed, of those before it, of the outermost at its end, of those behind it.
  std::vector<double> lowest_;
};

}  // namespace trackbed::model
