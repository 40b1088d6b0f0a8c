// A track with some sleepers on a small ground of elements, coupled as in a run.
#pragma once

#include <cmath>
#include <vector>

#include "model/coupling/ground_below.hpp"
#include "model/coupling/track_built.hpp"
#include "support/verified.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::model {

inline constexpr std::size_t before = 7;  // sleepers on springs before those on the ground

// A track of 19 sleepers, `count` of them on the ground from x = 0.3 m on; an impact at their
// middle.
inline Model model_of(std::int64_t count, const fem::Elastic& soil) {
  Model m;
  m.kind = ModelKind::track_on_ground;
  m.track.line.track.length = 10.8;
  m.track.line.track.run_in = 2.4;
  m.track.line.ballast = {.stiffness = 100e6, .damping = 50e3};
  m.ground = fem::box({0.6 * static_cast<double>(count), 1.2, 1.2}, {4 * count, 1, 8}, soil);
  m.ground.plane = fem::PlaneState::strain;
  m.ground.base = fem::Base::fixed;
  m.ground.sides = fem::Sides::roller;
  m.thickness = 1.2;
  m.footing.before = before;
  m.footing.count = count;
  m.footing.first = 0.3;
  m.footing.width = 0.6;
  m.track.passage.forces = {{.kind = track::ForceKind::impact,
                             .at = 0.6 * (before + static_cast<double>((count - 1) / 2)),
                             .size = 50e3,
                             .length = 0.01}};
  m.track.passage.step = 1e-3;
  m.track.train.vehicles = {};
  return m;
}

// Track and ground as in a run.
struct Pair {
  explicit Pair(const Model& m) : whole(par::Comm::world(), m), built(whole.track, whole.line) {}
  void step() { whole.below->advance(built.passage); }
  void run(double time) {
    for (std::int64_t n = std::llround(time / whole.below->step()); n > 0; --n) step();
  }
  double energy() const {
    const observe::PassageEnergies of = whole.below->energies(built.passage);
    return of.track + of.ground.kinetic + of.ground.elastic;
  }
  TrackAssembly whole;
  BuiltTrack built;
};

// m, of sleeper i, below a rail.
inline double sleeper(const Pair& pair, std::size_t i, std::size_t side = 0) {
  return pair.built.passage.line_motion().displacement[pair.built.line.sleeper_unknown(i, side)];
}

// An impact of 2 s, long compared with all periods (20 ms): at its peak static to (10 ms/s)^2.
// Oscillations from its start have decayed by then, and damper forces vanish at the peak.
inline Model at_rest(Model m) {
  m.ground.rayleigh_mass = 50;
  m.track.passage.forces[0].size = 100e3;
  m.track.passage.forces[0].length = 2;
  return m;
}

// Reasons that several tests share.
inline const verified::Tolerance almost_static{2e-4, "static to (10 ms/s)^2 = 1e-4, twice"};
inline const verified::Tolerance second_order{
    0.05, "second order; next term (omega dt)^2 / 4 = 0.016 at 200 Hz and the coarsest step"};
inline const verified::Tolerance mean_energy{
    3e-3, "leapfrog: means of ten energies that vary by (omega h / 2)^2, up to 1 % at 40 Hz"};
inline const verified::Limit largest_energy{
    1.01, "leapfrog: energy varies by (omega h / 2)^2, up to 1 % at 40 Hz"};
inline const verified::Tolerance ground_energy{
    0.02, "leapfrog: energy of the ground varies by (omega h / 2)^2, up to 1 % at 40 Hz, twice"};
inline const verified::Limit rigid_ground{
    5e-6, "compliance of the ground, 1e-6 of the ballast's, with dynamic amplification"};
inline const verified::Limit rounding_of_sums{4e-14,
                                              "rounding of sums over a hundred nodes: 1e-14"};
inline const verified::Limit corners{
    2e-4,
    "pads and gaps pass their corners within a step: k (v dt)^2 / 8 each, 1e-5 of the energy"};

// Root mean square.
inline double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace trackbed::model
