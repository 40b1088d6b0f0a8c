// Largest and least force of the wheels of a run, in its state and its summary.
#pragma once

#include <algorithm>

#include "trackbed/io/file.hpp"

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
  // The same on all ranks; rank 0 of `comm` writes. Writes nothing if there are no forces.
  // Collective.
  void save(io::File& file, const par::Comm& comm) const {
    if (!any) return;
    const double both[] = {least, most};
    file.write<double>("run/wheels", std::span(both).first(comm.root() ? 2 : 0), 1,
                       {"N", "smallest and largest force of a wheel up to now"});
  }
  void load(const io::File& file) {
    *this = {};
    if (!file.has("run/wheels")) return;
    const auto both = file.read_all<double>("run/wheels");
    *this = {.least = both.at(0), .most = both.at(1), .any = true};
  }
};

}  // namespace trackbed::model
