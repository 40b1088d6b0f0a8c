// An upward wave through the base, for tests: its table, and functions of time.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

#include "trackbed/par/comm.hpp"

namespace trackbed::fem {

// Acceleration of a Ricker wavelet of frequency f about time t_0, 1 at its peak; the velocity is
// its integral tau exp(-(pi f tau)^2).
struct Ricker {
  double frequency, centre;  // Hz, s
  double velocity(double time) const {
    const double tau = time - centre, w = std::numbers::pi * frequency * tau;
    return tau * std::exp(-w * w);
  }
};

// Writes a table of 1.5 wave lengths to both sides with peak accelerations along x and z (m/s^2),
// in rows of `dt`; returns the name of the file. Collective.
inline std::string wave_table(const par::Comm& comm, const std::string& name, const Ricker& wave,
                              double along_x, double along_z, double dt) {
  const std::string path = fmt::format("{}_on_{}.csv", name, comm.size());
  comm.sum(std::int64_t{1});  // no rank still reads an older file of this name
  if (comm.root()) {
    std::ofstream file(path);
    file << "time_s,vx_m_s,vz_m_s\n";
    const auto rows = static_cast<int>(std::ceil(1.5 / wave.frequency / dt));
    for (int r = -rows; r <= rows; ++r) {
      const double v = std::abs(r) == rows ? 0.0 : wave.velocity(wave.centre + r * dt);
      file << fmt::format("{},{},{}\n", wave.centre + r * dt, along_x * v, along_z * v);
    }
  }
  comm.sum(std::int64_t{1});  // no rank reads before the file is written
  return path;
}

}  // namespace trackbed::fem
