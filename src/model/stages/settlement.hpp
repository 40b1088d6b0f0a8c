// Settlement of sleepers from cycle to cycle of a load or from train to train, from which the end
// of initial settlement is judged.
#pragma once

#include <vector>

#include "trackbed/core/clock.hpp"
#include "trackbed/io/archive.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::model {

class Settlement {
 public:
  void begin(const track::Sleepers& sleepers);  // starts the first cycle
  void end();                                   // resets
  // To be called after each window of a stage with `cycles` equal cycles, from its first window on.
  // Returns whether a cycle is complete.
  bool watch(std::int64_t cycles, const Clock& clock, const track::Sleepers& sleepers);
  // m, largest settlement of a sleeper in the last complete cycle; 0: no sleeper settled; below 0:
  // no cycle is complete yet.
  double last() const { return last_; }

  bool begun() const { return !level_.empty(); }
  void archive(io::Archive& a);  // after `begin`

 private:
  std::vector<double> level_;  // m, of each sleeper when the present cycle began
  double last_ = -1;
};

}  // namespace trackbed::model
