// Loads on rail seats under passing axles: closed forms or measured tables.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/input/section.hpp"

namespace trackbed::track {

enum class SeatLoadKind { winkler, power, table, seats };

// Load on one rail seat while axles pass: winkler R = peak * sum exp(-b|s|)(cos b|s| + sin b|s|);
// power R = peak * sum X^((s/spacing)^2); table: CSV "time_s,force_N" of the sleeper at x = 0,
// linear in between, 0 outside, delayed by x/speed elsewhere; seats: CSV "time_s,sleeper_0,..."
// with the force in N on each sleeper, of two seats "time_s,sleeper_0_left,sleeper_0_right,...". s
// = distance of axle from sleeper.
struct SeatLoadParameters {
  SeatLoadKind kind = SeatLoadKind::winkler;
  double peak = 71.1e3;       // N, of a single axle; not used if there is a wheel load
  double speed = 18.6667;     // m/s
  std::vector<double> axles;  // m behind the first axle
  double start = 0;           // m, x of the first axle at the start of the passage
  double decay = 1.54257;     // 1/m, b of winkler
  double ratio = 0.5531;      // X of power
  std::string file;           // table, seats
  double gauge = 0;           // m, between two seats of a sleeper with a column each; 0: one seat
  // The peak from the load of a wheel, by the rules of AREA (1974) as quoted by Chen et al. (2023,
  // doi:10.1016/j.compgeo.2022.105105).
  double wheel_load = 0;      // N, static; 0: `peak` is given
  double wheel_diameter = 0;  // m; 0: the wheel load does not grow with speed
  double seat_share = 0.4;    // of the wheel load on the seat directly below
  double slice = 1;           // of this seat load on a sleeper of the model
  void declare(input::Section& s);
  double impact_factor() const;       // dynamic over static wheel load, at `speed`
  double dynamic_wheel_load() const;  // N
  double largest_seat_load() const;   // N, of one rail, below a wheel
  double peak_load() const;           // N, on a sleeper of the model below an axle
  bool is_table() const { return kind == SeatLoadKind::table || kind == SeatLoadKind::seats; }
};

// An axle of the deck: position (m) and load on the rails (N, downwards).
struct AxleLoad {
  double x, force;
};

class SeatLoad {
 public:
  // Throws InputError with file:line for an invalid table.
  explicit SeatLoad(const SeatLoadParameters& parameters, double spacing, std::size_t sleepers = 1);
  // N, downwards positive, for the sleeper at x; a table of seats uses the column of `sleeper`.
  double at(double x, double time, std::size_t sleeper = 0) const;
  // N, load of the left seat of a sleeper minus half of the sum; 0 without two seats.
  double left_excess(double time, std::size_t sleeper) const;
  // The axles themselves, for a bending rail: each has the wheel load for which `peak` is the seat
  // load of a beam on a Winkler bed. Kind winkler.
  std::vector<AxleLoad> axles(double time) const;
  // Messages on jumps at the start or end of a table while loads act for `time` s on sleepers from
  // first_x to last_x, to follow the name of its file; none for closed forms.
  std::vector<std::string> jumps(double first_x, double last_x, double time) const;
  double duration(double last_x) const;  // s, until the last axle is 3 m beyond last_x

 private:
  double column(std::size_t number, double time) const;

  SeatLoadParameters parameters_;
  double spacing_;
  std::vector<double> times_;
  // Of each sleeper, or of each seat, left before right, or only of the sleeper at x = 0.
  std::vector<std::vector<double>> forces_;
};

}  // namespace trackbed::track
