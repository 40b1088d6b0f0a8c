// The log of a run.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/core/timers.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::model {

// Both print on rank 0: a text as it is, and a line. A run whose log cannot be written continues.
void print(const par::Comm& comm, const std::string& text);
void say(const par::Comm& comm, const std::string& line);
// "2 ranks", and a hint if they are more than the processors that they may use. Collective.
std::string ranks_in_words(const par::Comm& comm);

std::string clock_words(double seconds);  // h:mm:ss
// Wall time, s, of an estimate: above 100 s as h:mm:ss.
std::string estimate_words(double seconds);

inline const char* plural_ending(std::int64_t count) { return count == 1 ? "" : "s"; }

// Of wall time between lines. A line costs sums over all contacts: at intervals of wall time their
// cost is always negligible.
inline constexpr double seconds_between_lines = 5;

// Wall time of a phase, s, over all ranks.
struct PhaseTime {
  Phase phase;
  double least, mean, largest;
};
// Of the phases that took time, parts after the phase that includes them. Collective.
std::vector<PhaseTime> times_over_ranks(const par::Comm& comm, const Timers& timers);

// Simulated s per s of wall time, and s of wall time until the end; 0: not known.
struct Pace {
  double speed, left;
};

class Log {
 public:
  explicit Log(const par::Comm& comm) : comm_(comm) {}

  double wall_time() const;  // s since the run began
  bool due() const;          // whether a line of progress is; decided on rank 0
  void warning(const std::string& sentence);
  // Prints a line of progress at the simulated time (s), with the speed since the last line or
  // `mark`: stages differ much, and the remaining time (`remaining`, s of simulated time, rough)
  // should follow from the present speed.
  Pace progress(double time, double remaining, const std::string& status);
  // Prints another line in its place.
  void instead(const std::string& line);
  void mark(double time);
  // Whether the step differs from that of the stage before, which need not be explained again.
  bool is_new_step(const std::string& words);
  // Collective.
  void timer_table(const Timers& timers);

 private:
  const par::Comm& comm_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double last_line_ = 0, last_time_ = 0;  // s of wall and of simulated time
  std::string last_step_;
};

}  // namespace trackbed::model
