// The hand-over loop of long-term studies: what jobs/handover.py reads from a deck.
#pragma once

#include <cstdint>
#include <string>

#include "trackbed/input/section.hpp"

namespace trackbed::model {

// The program only checks it; the rounds are separate runs, which the script starts.
struct HandoverParameters {
  std::string after;        // stage
  std::int64_t rounds = 3;  // of static load test, track alone, trains
  std::int64_t trains = 2;  // computed in a round
  double each = 1;          // number of trains that a computed one represents
  double load = 30e3;       // N, on each seat in the static load test
  void declare(input::Section& s);
};

struct Model;
void declare_handover(const Model& model, input::Section& s);

}  // namespace trackbed::model
