// Forces on the rail without a vehicle: harmonic forces and impacts at fixed positions.
#pragma once

#include "trackbed/input/section.hpp"

namespace trackbed::track {

// harmonic: size sin(2 pi frequency t), t from `begin`; impact: one half of a sine.
enum class ForceKind { harmonic, impact };
enum class ForceSide { left, right };

struct RailForce {
  ForceKind kind = ForceKind::harmonic;
  ForceSide side = ForceSide::left;  // of two rails
  double at = 30;                    // m, x of the track
  double size = 1e3;                 // N, downwards, on one rail
  double frequency = 100;            // Hz, harmonic
  double begin = 0;                  // s
  double rise = 0.1;                 // s, over which a harmonic force grows
  double length = 2e-3;              // s, of an impact
  void declare(input::Section& s);
  double duration() const;          // s, of an impact, or the period of a harmonic force
  double force(double time) const;  // N, downwards
  std::size_t number() const { return side == ForceSide::left ? 0 : 1; }
};

}  // namespace trackbed::track
