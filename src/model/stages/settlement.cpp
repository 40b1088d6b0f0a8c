// Cycles are counted in whole windows with integers, so that they end at the same windows in a
// resumed run.
//
// The measure is the loss of height over whole cycles, without elastic deflection within a cycle.
// It is the largest of all sleepers: a mean would hide a single one. Tilting about the centre does
// not count.
#include "model/stages/settlement.hpp"

#include <algorithm>

namespace trackbed::model {

namespace {

std::vector<double> levels(const track::Sleepers& sleepers) {
  std::vector<double> all;
  for (std::size_t i = 0; i < sleepers.count(); ++i)
    all.push_back(sleepers.state(i).displacement.z());
  return all;
}

}  // namespace

void Settlement::begin(const track::Sleepers& sleepers) {
  level_ = levels(sleepers);
  last_ = -1;
}

void Settlement::end() {
  level_.clear();
  last_ = -1;
}

// After w of n windows floor(w cycles/n) cycles are complete: exact in integers, also if a cycle is
// not a whole number of windows.
bool Settlement::watch(std::int64_t cycles, const Clock& clock, const track::Sleepers& sleepers) {
  const auto cycle = [&](std::int64_t window) { return window * cycles / clock.windows(); };
  if (cycle(clock.window()) == cycle(clock.window() - 1)) return false;
  const std::vector<double> now = levels(sleepers);
  last_ = 0;
  for (std::size_t i = 0; i < now.size(); ++i) last_ = std::max(last_, level_[i] - now[i]);
  level_ = now;
  return true;
}

void Settlement::archive(io::Archive& a) {
  a("last_cycle", last_,
    {"m", "largest settlement of a sleeper in the last cycle; below 0: no cycle is complete"});
  a.rows("level", level_, {"m", "height of each sleeper when the present cycle began"});
}

}  // namespace trackbed::model
