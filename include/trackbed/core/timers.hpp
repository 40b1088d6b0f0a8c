// Wall time of each phase of the step. Timing is a scope:
//   const auto timing = timers.scope(Verb::dem);
#pragma once

#include <array>
#include <chrono>
#include <string_view>

namespace trackbed {

// The phases of a step, in order; `dem` covers halo, neighbours and contacts.
enum class Verb { track, ground, coupling, dem, halo, neighbours, observe, output, count };
std::string_view name_of(Verb verb);
// Whether the time of this phase is already included in that of another one.
inline bool is_part(Verb verb) { return verb == Verb::halo || verb == Verb::neighbours; }

class Timers {
  using Watch = std::chrono::steady_clock;

 public:
  class Scope {
   public:
    Scope(Timers& timers, Verb verb) : timers_(timers), verb_(verb), begin_(Watch::now()) {}
    ~Scope() { timers_.add(verb_, std::chrono::duration<double>(Watch::now() - begin_).count()); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    Timers& timers_;
    Verb verb_;
    Watch::time_point begin_;
  };

  [[nodiscard]] Scope scope(Verb verb) { return Scope(*this, verb); }
  void add(Verb verb, double seconds) { seconds_[static_cast<std::size_t>(verb)] += seconds; }
  double seconds(Verb verb) const { return seconds_[static_cast<std::size_t>(verb)]; }

 private:
  std::array<double, static_cast<std::size_t>(Verb::count)> seconds_{};
};

}  // namespace trackbed
