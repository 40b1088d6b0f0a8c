#include "model/scheme/waiting.hpp"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <mutex>

namespace trackbed::model {

namespace {

// A new thread inherits the signal mask of its creator: signals that request the run to stop must
// reach only the main thread.
class NoSignals {
 public:
  NoSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~NoSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  NoSignals(const NoSignals&) = delete;
  NoSignals& operator=(const NoSignals&) = delete;

 private:
  sigset_t before_{};
};

void report(const std::stop_token& stop, const std::string& what, double interval,
            const Waiting::Say& say) {
  using clock = std::chrono::steady_clock;
  const auto begin = clock::now();
  std::mutex alone;
  std::condition_variable_any woken;
  std::unique_lock lock(alone);
  for (int line = 1;; ++line) {
    const auto next = begin + std::chrono::duration_cast<clock::duration>(
                                  std::chrono::duration<double>(line * interval));
    woken.wait_until(lock, stop, next, [] { return false; });
    if (stop.stop_requested()) return;
    const double passed = std::chrono::duration<double>(clock::now() - begin).count();
    say(fmt::format("{}: {:.3g} s", what, passed));
  }
}

}  // namespace

Waiting::Waiting(std::string what, double interval, Say say) {
  const NoSignals blocked;
  thread_ = std::jthread([what = std::move(what), interval, say = std::move(say)](
                             const std::stop_token& stop) { report(stop, what, interval, say); });
}

}  // namespace trackbed::model
