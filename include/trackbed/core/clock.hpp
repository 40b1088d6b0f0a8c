// Simulated time, counted in whole time windows, so that it does not drift and a restarted run
// continues at a bitwise identical time.
#pragma once

#include <cstdint>

namespace trackbed {

class Clock {
 public:
  Clock(double window, std::int64_t windows_to_run) : dt_(window), end_(windows_to_run) {}

  double dt() const { return dt_; }                                         // s, length of a window
  double time() const { return start_ + static_cast<double>(now_) * dt_; }  // s
  double start() const { return start_; }                                   // s, at window 0
  std::int64_t window() const { return now_; }
  std::int64_t windows() const { return end_; }
  bool runs() const { return now_ < end_; }
  void tick() { ++now_; }
  void set(double start, std::int64_t window) { start_ = start, now_ = window; }

 private:
  double dt_;
  std::int64_t end_;
  double start_ = 0;
  std::int64_t now_ = 0;
};

}  // namespace trackbed
