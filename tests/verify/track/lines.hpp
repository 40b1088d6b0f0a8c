// Tracks and trains of the verification cases.
#pragma once

#include <cmath>
#include <numbers>

#include "trackbed/track/passage.hpp"

namespace trackbed::track {

// 60E1 on 50 MPa, without run-ins; m.
inline LineParameters winkler(double length, BeamTheory theory, std::int64_t elements = 4) {
  LineParameters p;
  p.rail.theory = theory;
  p.track.support = Support::continuous;
  p.track.length = length;
  p.track.elements = elements;
  p.track.bed_stiffness = 50e6;
  p.track.bed_damping = 0;
  p.track.run_in = 0;
  return p;
}

// A single-span beam that represents both rails; E in Pa, I in m^4, mass in kg/m.
inline LineParameters span(double young, double inertia, double mass) {
  LineParameters p;
  p.rail.theory = BeamTheory::euler;
  p.rail.young = young;
  p.rail.inertia = inertia;
  p.rail.mass = mass;
  p.track.support = Support::none;
  p.track.ends = RailEnds::pinned;
  p.track.rails = 1;
  p.track.length = 25;
  p.track.spacing = 2.5;
  p.track.run_in = 0;
  return p;
}

// Elements of equal length for a sleeper of 2.5 m and a gauge of 1.5 m, if their number between the
// rails is a multiple of six.
inline TrackParameters bending(std::int64_t elements, BeamTheory theory = BeamTheory::euler) {
  TrackParameters t;
  t.dimension = Dimension::space;
  t.sleeper_length = 2.5;
  t.sleeper.model = SleeperModel::beam;
  t.sleeper.theory = theory;
  t.sleeper.elements = elements;
  return t;
}

// Static displacements under `force` N downwards at x.
inline Vector at_rest(const Line& line, double x, double force) {
  Vector load = Vector::Zero(line.system().mass.rows());
  line.at(x).add(-force, load);
  return Statics(line.system()).flexibility(load);
}

// Modal amplitude of sin(pi x/L) in the motion of a span, by the mass matrix.
inline double first_mode(const Line& line, int elements, const Vector& u) {
  const double wave = std::numbers::pi / line.length();
  Vector shape = Vector::Zero(u.size());
  const auto put = [&](std::int32_t unknown, double value) {
    if (unknown >= 0) shape[unknown] = value;
  };
  for (int e = 0; e < elements; ++e) {
    const auto unknown = line.at((e + 0.5) * line.length() / elements).unknown;
    for (const int end : {0, 1}) {
      const double x = (e + end) * line.length() / elements;
      put(unknown[static_cast<std::size_t>(2 * end)], std::sin(wave * x));
      put(unknown[static_cast<std::size_t>(2 * end + 1)], wave * std::cos(wave * x));
    }
  }
  const Vector momentum = line.system().mass * shape;
  return momentum.dot(u) / momentum.dot(shape);
}

}  // namespace trackbed::track
