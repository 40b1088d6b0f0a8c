// Loads that axles put on rail seats as they pass: formulas, or tables that were measured.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/input/section.hpp"

namespace trackbed::track {

enum class SeatLoadKind { winkler, power, table, seats };

// Load on one rail seat while axles pass: winkler R = peak * sum exp(-b|s|)(cos b|s| + sin b|s|);
// power R = peak * sum X^((s/spacing)^2); table: CSV "time_s,force_N" of the sleeper at x = 0,
// linear in between, 0 outside, later by x/speed elsewhere; seats: CSV "time_s,sleeper_0,..." with
// the N of each sleeper of its own, of two seats "time_s,sleeper_0_left,sleeper_0_right,...". s =
// distance of axle from sleeper.
struct SeatLoadParameters {
  SeatLoadKind kind = SeatLoadKind::winkler;
  double peak = 71.1e3;                             // N, of a single axle
  double speed = 18.6667;                           // m/s
  std::vector<double> axles = {0, 2.8, 9.0, 11.8};  // m behind the first axle
  double start = 0;        // m, x of the first axle when the passage begins
  double decay = 1.54257;  // 1/m, b of winkler
  double ratio = 0.5531;   // X of power
  std::string file;        // table, seats
  double gauge = 0;        // m, between the two seats of a sleeper that have columns; 0: one seat
  void declare(input::Section& s);
  bool is_table() const { return kind == SeatLoadKind::table || kind == SeatLoadKind::seats; }
};

// An axle of the deck: where it is (m) and what it puts on the rails (N, downwards).
struct AxleLoad {
  double x, force;
};

class SeatLoad {
 public:
  // Throws InputError with file:line for a bad table.
  explicit SeatLoad(const SeatLoadParameters& parameters, double spacing, std::size_t sleepers = 1);
  // N, downwards positive, for the sleeper at x, which of a table of seats is that of this number.
  double at(double x, double time, std::size_t sleeper = 0) const;
  // N, what the left seat of a sleeper has more than half of that; 0 without two seats.
  double left_more(double time, std::size_t sleeper) const;
  // The axles themselves, for a rail that bends: each has the wheel load that makes `peak` the seat
  // load of a beam on a Winkler bed. Kind winkler.
  std::vector<AxleLoad> axles(double time) const;
  // Where a table begins or ends with a jump while loads act for `time` s on sleepers from first_x
  // to last_x: sentences that go on after its file; none of formulas.
  std::vector<std::string> jumps(double first_x, double last_x, double time) const;
  double duration(double last_x) const;  // s until the last axle is 3 m beyond last_x

 private:
  double column(std::size_t number, double time) const;

  SeatLoadParameters parameters_;
  double spacing_;
  std::vector<double> times_;
  // Of each sleeper, or of each seat, left before right, or of the sleeper at x = 0 alone.
  std::vector<std::vector<double>> forces_;
};

}  // namespace trackbed::track
