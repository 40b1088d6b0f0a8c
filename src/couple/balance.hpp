// Balance of the loads received by surfaces against the action that the particles report.
//
// Node n moves as X(s) = X0 + s motion, s = k/steps in sub-step k, and carries the sums
// S0 = sum F_k and S1 = sum (k/steps) F_k. Then, without the single F_k,
//   force  = sum S0,   moment = sum X0 x S0 + motion x S1,   work = sum S0 . motion / steps
// are exact for the moving nodes.
#pragma once

#include <array>
#include <span>

#include "trackbed/couple/coupler.hpp"

namespace trackbed::couple {

// Sums over nodes, additive over nodes, surfaces and ranks. The scales are sums of magnitudes: N,
// Nm, J.
struct Received {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  double work = 0;
  double force_scale = 0, moment_scale = 0, work_scale = 0;

  void add(const Surface& surface, std::size_t node, int steps);
  static constexpr std::size_t numbers = 10;
  std::array<double, numbers> pack() const;
  void unpack_add(std::span<const double, numbers> values);
};

// Compares both sides in each window and keeps the largest imbalance.
class Ledger {
 public:
  // `quantum`: N, the largest quantum to which loads were rounded; equal on all ranks.
  void record(const Received& received, const Action& action, double quantum, int steps, double dt);
  const Balance& balance() const { return balance_; }
  double lost() const { return lost_; }  // imbalance of force in the last window, relative
  void set(const Balance& balance) { balance_ = balance; }

 private:
  Balance balance_;
  double lost_ = 0;
  Vec3 impulse_gap_ = Vec3::Zero();  // Ns, received minus applied since the start
  double impulse_scale_ = 0;         // Ns
};

}  // namespace trackbed::couple
