#include "trackbed/model/log.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "trackbed/par/processors.hpp"

namespace trackbed::model {

std::string clock_words(double seconds) {
  const auto s = static_cast<std::int64_t>(seconds);
  return fmt::format("{}:{:02d}:{:02d}", s / 3600, s / 60 % 60, s % 60);
}

std::string estimate_words(double seconds) {
  constexpr double readable = 100;  // s
  return seconds > readable ? fmt::format("{} (h:mm:ss)", clock_words(seconds))
                            : fmt::format("{:.2g} s", seconds);
}

// Not fmt::print, which throws where nothing can be written. Flushed at once: batch systems show
// stdout only when it is flushed, and the log of a run that is killed must be complete.
void print(const par::Comm& comm, const std::string& text) {
  if (!comm.root()) return;
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

void say(const par::Comm& comm, const std::string& line) { print(comm, line + "\n"); }

std::string ranks_in_words(const par::Comm& comm) {
  const par::Processors node = par::processors_of(comm);
  return fmt::format("{} rank{}{}", comm.size(), plural_ending(comm.size()),
                     node.too_few()
                         ? fmt::format(" ({} of them share {} processor{}, which is slow)",
                                       node.ranks, node.processors, plural_ending(node.processors))
                         : "");
}

double Log::wall_time() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

bool Log::due() const { return wall_time() - last_line_ > seconds_between_lines; }

void Log::warning(const std::string& sentence) { say(comm_, "warning: " + sentence); }

Pace Log::progress(double time, double remaining, const std::string& status) {
  const double wall = wall_time(), speed = (time - last_time_) / (wall - last_line_);  // s per s
  const double left = speed > 0 ? remaining / speed : 0;
  say(comm_,
      fmt::format("  {:>8.4f} s | {:.3g} ms simulated per s of wall time | remaining {}{}{}", time,
                  speed * 1e3, clock_words(left), status.empty() ? "" : " | ", status));
  mark(time);
  return {speed, left};
}

void Log::instead(const std::string& line) {
  say(comm_, line);
  last_line_ = wall_time();
}

void Log::mark(double time) { last_line_ = wall_time(), last_time_ = time; }

bool Log::is_new_step(const std::string& words) {
  const bool is_new = words != last_step_;
  last_step_ = words;
  return is_new;
}

// A row of zeros is left out: most often a part that the model does not have.
std::vector<PhaseTime> times_over_ranks(const par::Comm& comm, const Timers& timers) {
  constexpr double shown = 0.005;  // s
  std::vector<PhaseTime> times;
  for (std::size_t i = 0; i < phases; ++i) {
    const auto phase = static_cast<Phase>(i);
    const double mine = timers.seconds(phase);
    const PhaseTime time{phase, comm.min(mine), comm.sum(mine) / comm.size(), comm.max(mine)};
    if (time.largest >= shown) times.push_back(time);
  }
  return times;
}

// imbalance: largest over mean of the ranks. Phases in which ranks wait for each other (halo,
// coupling, agreement) include the imbalance of the others as time. Parts are indented.
void Log::timer_table(const Timers& timers) {
  const double total = comm_.max(wall_time());
  say(comm_, fmt::format("{:<18}{:>8}{:>10}{:>10}{:>10}{:>11}", "time in", "share", "min s",
                         "mean s", "max s", "imbalance"));
  double counted = 0;  // s, mean over ranks; parts of other phases aside
  for (const PhaseTime& time : times_over_ranks(comm_, timers)) {
    const bool part = is_part(time.phase);
    say(comm_, fmt::format("{:<18}{:>7.1f}%{:>10.2f}{:>10.2f}{:>10.2f}{:>11.2f}",
                           fmt::format("{}{}", part ? "  " : "", name_of(time.phase)),
                           100 * time.mean / total, time.least, time.mean, time.largest,
                           time.mean > 0 ? time.largest / time.mean : 1));
    if (!part) counted += time.mean;
  }
  say(comm_, fmt::format("{:<18}{:>7.1f}%{:>10}{:>10.2f}", "other", 100 * (1 - counted / total), "",
                         total - counted));
  say(comm_, fmt::format("{:<18}{:>8}{:>10}{:>10.2f}", "all", "", "", total));
}

}  // namespace trackbed::model
