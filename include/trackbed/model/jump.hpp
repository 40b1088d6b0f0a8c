// Jumps over cycles of load, stages of kind jump: a few cycles with less friction settle the
// sleepers by as much as many cycles would by a law of settlement.
#pragma once

#include <cstdint>
#include <string>

#include "trackbed/input/section.hpp"

namespace trackbed::model {

struct JumpParameters {
  std::string from;             // stage from which on cycles count; see Model::counts_from
  std::int64_t cycles = 20;     // measured, the last ones of the stage before a jump
  double exponent = 0;          // b of the law of settlement
  double period = 0.1;          // s, of the cycles in a jump
  double least_friction = 0.3;  // in a jump, over that of the contact laws
  void declare(input::Section& s);
};

// Settlement after `cycles` cycles, up to a factor: ((1 + N)^b - 1)/b, for b = 0 ln(1 + N).
double settlement_law(double cycles, double exponent);

struct Model;
struct Stage;
// Number of cycles that a stage adds: of a load its haversines, of a passage its trains, of a jump
// those that it represents.
std::int64_t cycles_of(const Stage& stage);
void declare_jump(const Model& model, input::Section& s);

}  // namespace trackbed::model
