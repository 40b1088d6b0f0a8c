// The hand-over loop of long-term studies: what jobs/handover.py reads from a deck.
#pragma once

#include <cstdint>
#include <string>

#include "trackbed/input/section.hpp"

namespace trackbed::app {

// The program checks it; the rounds are runs of their own, which the script starts.
struct HandoverParameters {
  std::string after;        // stage
  std::int64_t rounds = 3;  // of weighing, track alone, trains
  std::int64_t trains = 2;  // computed in a round
  double each = 1;          // trains that a computed one stands for
  double load = 30e3;       // N, on each seat while it is weighed
  void declare(input::Section& s);
};

struct Model;
void declare_handover(const Model& model, input::Section& s);

}  // namespace trackbed::app
