// `trackbed info DIR` of a run that is computing, or has ended.
#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <fstream>
#include <map>

#include "app/restart/track_resume.hpp"
#include "app/run/progress.hpp"
#include "trackbed/core/unix_time.hpp"
#include "trackbed/model/log.hpp"

namespace trackbed::app {

namespace {

using Json = nlohmann::ordered_json;

// The last line of each kind of event, of progress and end since the last command began; of any
// kind under "any". Null if there is none. `warnings`: all since the last command began, which
// repeats those before.
struct Events {
  std::map<std::string, Json> last;
  std::vector<std::string> warnings;
};

std::string text(const Json& line, const char* key) {
  const auto found = line.find(key);
  return found != line.end() && found->is_string() ? found->get<std::string>() : "?";
}

// Lines that are not JSON, of a run that was killed while it wrote, are passed over.
Events events_in(const std::string& folder) {
  Events found;
  auto& [last, warnings] = found;
  std::ifstream file(folder + "/" + progress_file);
  for (std::string words; std::getline(file, words);) {
    const Json line = Json::parse(words, nullptr, false);
    if (!line.is_object() || !line.contains("event") || !line["event"].is_string()) continue;
    const std::string event = line["event"];
    if (event == "begin") last["progress"] = last["end"] = Json(), warnings.clear();
    if (event == "warning") warnings.push_back(text(line, "message"));
    last[event] = last["any"] = line;
  }
  return found;
}

// 0 for what no run writes: the file may be damaged.
double number(const Json& line, const char* key) {
  constexpr double most = 1e12;
  const auto found = line.find(key);
  const double value = found != line.end() && found->is_number() ? found->get<double>() : 0;
  return std::abs(value) < most ? value : 0;
}

// A run that computes holds the lock. The test takes it for a moment; a run that begins waits.
bool is_locked(const std::string& folder) {
  const int lock = ::open((folder + "/.lock").c_str(), O_RDONLY | O_CLOEXEC);
  if (lock < 0) return false;
  const bool held = ::flock(lock, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(lock);
  return held;
}

std::string date(double unix_time) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(static_cast<std::time_t>(unix_time)));
}

double seconds_since(const Json& line) {
  return std::max(unix_time() - number(line, "unix_time_s"), 0.0);
}

std::string state_of(std::map<std::string, Json>& last, bool computes) {
  if (computes)
    return fmt::format(
        "computing since {}",
        date(number((last["end"].is_null() ? last["begin"] : last["end"]), "unix_time_s")));
  if (!last["end"].is_null()) {
    const std::string outcome = text(last["end"], "outcome"),
                      at = date(number(last["end"], "unix_time_s"));
    if (outcome == "failed")
      return fmt::format("failed at {}: {}", at, text(last["end"], "message"));
    return fmt::format("{} at {}", outcome, at);
  }
  return fmt::format("was killed after {}; trackbed resume continues it",
                     date(number(last["any"], "unix_time_s")));
}

std::string place_of(const Json& line) {
  const double windows = number(line, "windows_at_most");
  return fmt::format("  stage {} of {}, \"{}\": {} of at most {} windows ({:.3g} %), {:.6g} s\n",
                     number(line, "stage_number"), number(line, "stages"), text(line, "stage"),
                     number(line, "window"), windows,
                     windows > 0 ? 100 * number(line, "window") / windows : 0,
                     number(line, "time_s"));
}

// The numbers of a line of progress after those of all lines.
std::string figures_of(const Json& line) {
  std::string words;
  bool own = false;
  for (const auto& [key, value] : line.items()) {
    if (own && value.is_number())
      words += fmt::format("{}{} {:.4g}", words.empty() ? "  " : ", ", key, value.get<double>());
    own = own || key == "remaining_s";
  }
  return words.empty() ? "" : words + "\n";
}

}  // namespace

std::string describe_progress(const std::string& folder) {
  auto [last, warnings] = events_in(folder);
  if (last["begin"].is_null()) return "";
  const bool computes = is_locked(folder);
  std::string words =
      fmt::format("{}: {} on {} rank{} of {}, {}\n", folder, text(last["begin"], "deck"),
                  number(last["begin"], "ranks"), number(last["begin"], "ranks") == 1 ? "" : "s",
                  text(last["begin"], "host"), state_of(last, computes));
  words += place_of(last["any"]);
  if (!last["progress"].is_null()) {
    if (computes)
      words += fmt::format(
          "  {:.3g} ms simulated per s of wall time, remaining {} (h:mm:ss) if all stages take "
          "their full duration\n",
          1e3 * number(last["progress"], "speed"),
          model::clock_words(number(last["progress"], "remaining_s")));
    words += figures_of(last["progress"]);
  }
  if (!last["checkpoint"].is_null())
    words += fmt::format("  last checkpoint: {}, at {:.6g} s, written {} (h:mm:ss) ago\n",
                         text(last["checkpoint"], "file"), number(last["checkpoint"], "time_s"),
                         model::clock_words(seconds_since(last["checkpoint"])));
  // Lines come every few seconds; the static equilibrium of a ground and large files take longer.
  constexpr double silent = 120;  // s
  if (const double since = seconds_since(last["any"]); computes && since > silent)
    words += fmt::format(
        "  no event for {} (h:mm:ss): check that the process on {} still runs (the static "
        "equilibrium of a ground may take as long)\n",
        model::clock_words(since), text(last["begin"], "host"));
  for (const std::string& warning : warnings) words += "  warning: " + warning + "\n";
  return words;
}

}  // namespace trackbed::app
