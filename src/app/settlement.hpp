// How far sleepers go down from cycle to cycle of a load or from train to train: the measure of
// whether a bed is bedded in.
#pragma once

#include <vector>

#include "trackbed/core/clock.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::app {

class Settlement {
 public:
  void begin(const track::Sleepers& sleepers);  // the first cycle begins here and now
  void end();                                   // forgets all
  // After each window of a stage that `cycles` fill evenly, from its first window on.
  void watch(std::int64_t cycles, const Clock& clock, const track::Sleepers& sleepers);
  // m, what the sleeper that sank most lost in the last whole cycle; 0: none sank; below 0: no
  // cycle is over yet.
  double last() const { return last_; }

  // All ranks hold the same; rank 0 writes it, all read it. Collective.
  void save(io::File& file, const par::Comm& comm) const;
  void load(const io::File& file);

 private:
  std::vector<double> level_;  // m, of each sleeper when the present cycle began
  double last_ = -1;
};

}  // namespace trackbed::app
