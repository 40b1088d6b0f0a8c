// Green's functions of a track without stops: responses to a unit force that acts at a fixed place
// of a rail for one sample. Superposed along the path of a wheel they are the response to a moving
// force ("Model-based condition monitoring of railway switches and crossings", section 5.7).
#pragma once

#include <cstdint>
#include <vector>

#include "trackbed/track/newmark.hpp"

namespace trackbed::track {

struct GreensParameters {
  double sensor = 30;               // m, x; the nearest sleeper has the sensor
  std::size_t side = 0;             // of the sensor, at that end of the sleeper, and of the wheel
  double rate = 5000;               // Hz, of samples
  double duration = 0.2;            // s, of responses
  double speed = 0;                 // m/s, of the moving response
  std::vector<double> axles = {0};  // m, distance of each axle behind the first one
  double step = 2e-4;               // s, longest step of time integration, of which a sample has a
                                    // whole number
};

class GreensFunctions {
 public:
  // The line must not have stops or moved parts; it must outlive this object.
  GreensFunctions(const Line& line, const GreensParameters& parameters);

  // A force rises linearly from 0 to 1 N within 1/rate before time 0 and falls to 0 within 1/rate
  // after it. Responses at times n/rate, n = 0 ... samples() - 1; force and response are positive
  // upwards.
  std::size_t samples() const { return samples_; }
  double step() const;  // s, of time integration

  // Response of the sensor, a row for each position x, a column for each sample.
  struct Fixed {
    Columns displacement, acceleration;  // m/N, m/s2/N
  };
  Fixed fixed(const std::vector<double>& x, std::size_t side) const;

  // Deflection of the rail below the first wheel, on the side of the sensor, due to the force of
  // axle `axle` on the rail `side`, m/N: a row for each position x of the force, in whose column n
  // the first wheel is at x + axles[axle] + speed n/rate; 0 beyond the track.
  Columns moving(const std::vector<double>& x, std::size_t axle, std::size_t side) const;

 private:
  const Line& line_;
  GreensParameters parameters_;
  std::int64_t substeps_;  // of a sample
  std::size_t samples_;
};

}  // namespace trackbed::track
