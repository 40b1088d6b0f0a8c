// Largest and least force of the wheels of a run, in its state and its summary.
#pragma once

#include <algorithm>

#include "trackbed/io/archive.hpp"

namespace trackbed::model {

// N, over all wheels and steps passed to `add`.
struct WheelExtremes {
  double least = 0, most = 0;
  bool any = false;

  void add(double force) {
    least = any ? std::min(least, force) : force;
    most = any ? std::max(most, force) : force;
    any = true;
  }
  // Nothing if there are no forces.
  void archive(io::Archive& a) {
    any = a.has("smallest", any);
    if (!any) return;
    a("smallest", least, {"N", "smallest force of a wheel up to now"});
    a("largest", most, {"N", "largest force of a wheel up to now"});
  }
};

}  // namespace trackbed::model
