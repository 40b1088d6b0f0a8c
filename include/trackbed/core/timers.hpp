// Wall time of each phase of a run. Timing is a scope:
//   const auto timing = timers.scope(Phase::dem);
#pragma once

#include <array>
#include <chrono>
#include <string_view>

namespace trackbed {

// A tree: parts follow the phase that includes their time, see `parent_of`.
enum class Phase {
  track,              // sleepers, rails, vehicles, solids, tines
  ground,             // steps and static equilibrium
  ground_elements,    // internal forces of explicit steps
  ground_plasticity,  // return mapping
  ground_solve,       // linear systems of implicit steps and of static equilibrium
  coupling,           // exchange of surfaces and forces between their owners and the stones
  dem,                // sub-steps of the stones
  search,             // neighbour lists, with migration between ranks
  pair_forces,
  surface_forces,
  integration,
  waiting,    // for the slowest rank, in the reduction of a sub-step
  halo,       // exchange of ghosts
  agreement,  // of the ranks, after a window
  partition,  // of the stones over the ranks, again
  observe,    // rows of histories
  output,     // files
  count
};
inline constexpr auto phases = static_cast<std::size_t>(Phase::count);

std::string_view name_of(Phase phase);  // in the table of times and in summary.json
// The phase of which it is a part; itself if of none.
Phase parent_of(Phase phase);
inline bool is_part(Phase phase) { return parent_of(phase) != phase; }

class Timers {
  using Watch = std::chrono::steady_clock;

 public:
  class Scope {
   public:
    Scope(Timers& timers, Phase phase) : timers_(timers), phase_(phase), begin_(Watch::now()) {}
    ~Scope() { timers_.add(phase_, std::chrono::duration<double>(Watch::now() - begin_).count()); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    Timers& timers_;
    Phase phase_;
    Watch::time_point begin_;
  };

  [[nodiscard]] Scope scope(Phase phase) { return Scope(*this, phase); }
  void add(Phase phase, double seconds) { seconds_[static_cast<std::size_t>(phase)] += seconds; }
  double seconds(Phase phase) const { return seconds_[static_cast<std::size_t>(phase)]; }

 private:
  std::array<double, phases> seconds_{};
};

}  // namespace trackbed
