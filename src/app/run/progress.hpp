// The log of a run.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "app/run/course.hpp"
#include "app/run/waiting.hpp"
#include "app/scene/world.hpp"
#include "trackbed/core/timers.hpp"

namespace trackbed::app {

// Counters at the time from which speeds are measured.
struct SpeedCounters {
  std::string stage;
  double dem_seconds = 0, neighbour_seconds = 0, cpu_seconds = 0;  // on this rank
  std::int64_t dem_steps = 0;
  double ground_seconds = 0;
  std::int64_t ground_steps = 0;
};

class Progress {
 public:
  explicit Progress(const par::Comm& comm) : comm_(comm) {}

  double wall_time() const;  // s since the run began
  bool due() const;          // a line about every 5 s of wall time; decided on rank 0
  // Collective; rank 0 prints.
  void start(World& world, const Model& model, const std::string& name);
  void stage_begins(const Stage& stage, const Course& course, World& world);
  void line(const Course& course, const Model& model, const World& world);
  // Static equilibrium of the ground: a line now, and one every 5 s until the returned object is
  // destroyed. Collective.
  std::unique_ptr<Waiting> equilibrium(const World& world);
  void static_iteration(int iterations, double residual);  // of its solution; rank 0 alone
  void stage_ends(const StageRecord& record);
  void warning(const std::string& sentence);
  void timer_table(const Timers& timers);

 private:
  const par::Comm& comm_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double last_line_ = 0, last_time_ = 0;  // s of wall and of simulated time
};

}  // namespace trackbed::app
