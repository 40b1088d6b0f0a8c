// `trackbed info DIR` of a run that is computing, or has ended.
#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <fstream>

#include "app/restart/track_resume.hpp"
#include "app/run/progress.hpp"
#include "trackbed/model/log.hpp"

namespace trackbed::app {

namespace {

using Json = nlohmann::ordered_json;

// What is known of a run: the last line of each kind since its last command began.
struct Known {
  Json begin, last, progress, checkpoint, end;
};

// Lines that are not JSON, of a run that was killed while it wrote, are passed over.
Known known_of(const std::string& folder) {
  Known known;
  std::ifstream file(folder + "/" + progress_file);
  for (std::string text; std::getline(file, text);) {
    const Json line = Json::parse(text, nullptr, false);
    if (!line.is_object() || !line.contains("event") || !line["event"].is_string()) continue;
    const std::string event = line["event"];
    if (event == "begin") known.progress = known.end = Json(), known.begin = line;
    if (event == "progress") known.progress = line;
    if (event == "checkpoint") known.checkpoint = line;
    if (event == "end") known.end = line;
    known.last = line;
  }
  return known;
}

double number(const Json& line, const char* key) {
  const auto found = line.find(key);
  return found != line.end() && found->is_number() ? found->get<double>() : 0;
}

std::string text(const Json& line, const char* key) {
  const auto found = line.find(key);
  return found != line.end() && found->is_string() ? found->get<std::string>() : "?";
}

// A run that computes holds the lock. Only tested if no end is known: the test takes the lock for
// a moment, and a run that begins in it would be refused.
bool is_locked(const std::string& folder) {
  const int lock = ::open((folder + "/.lock").c_str(), O_RDONLY | O_CLOEXEC);
  if (lock < 0) return false;
  const bool held = ::flock(lock, LOCK_SH | LOCK_NB) != 0;
  ::close(lock);
  return held;
}

std::string date(double unix_time) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(static_cast<std::time_t>(unix_time)));
}

double seconds_since(const Json& line) {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
             .count() -
         number(line, "unix_time_s");
}

std::string state_of(const Known& known, bool computes) {
  if (!known.end.is_null()) {
    const std::string outcome = text(known.end, "outcome"),
                      at = date(number(known.end, "unix_time_s"));
    if (outcome == "failed") return fmt::format("failed at {}: {}", at, text(known.end, "message"));
    return fmt::format("{} at {}", outcome, at);
  }
  if (computes) return fmt::format("computing since {}", date(number(known.begin, "unix_time_s")));
  return fmt::format("was killed after {}; trackbed resume continues it",
                     date(number(known.last, "unix_time_s")));
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

// Warnings of the run, as its summary lists them.
std::string warnings_of(const std::string& folder) {
  std::ifstream file(folder + "/summary.json");
  const Json summary = Json::parse(file, nullptr, false);
  if (!summary.is_object() || !summary.contains("warnings") || !summary["warnings"].is_array())
    return "";
  std::string words;
  for (const Json& warning : summary["warnings"])
    if (warning.is_string()) words += "  warning: " + warning.get<std::string>() + "\n";
  return words;
}

}  // namespace

std::string case_in_words(const std::string& folder) {
  const Known known = known_of(folder);
  if (known.begin.is_null()) return "";
  const bool computes = known.end.is_null() && is_locked(folder);
  std::string words =
      fmt::format("{}: {} on {} rank{} of {}, {}\n", folder, text(known.begin, "deck"),
                  number(known.begin, "ranks"), number(known.begin, "ranks") == 1 ? "" : "s",
                  text(known.begin, "host"), state_of(known, computes));
  words += place_of(known.last);
  if (!known.progress.is_null()) {
    if (computes)
      words += fmt::format(
          "  {:.3g} ms simulated per s of wall time, remaining {} (h:mm:ss) if all stages take "
          "their full duration\n",
          1e3 * number(known.progress, "speed"),
          model::clock_words(number(known.progress, "remaining_s")));
    words += figures_of(known.progress);
  }
  if (!known.checkpoint.is_null())
    words += fmt::format("  last checkpoint: {}, at {:.6g} s, written {} (h:mm:ss) ago\n",
                         text(known.checkpoint, "file"), number(known.checkpoint, "time_s"),
                         model::clock_words(seconds_since(known.checkpoint)));
  // Lines come every few seconds; the static equilibrium of a ground and large files take longer.
  constexpr double silent = 120;  // s
  if (const double since = seconds_since(known.last); computes && since > silent)
    words += fmt::format(
        "  no sign of life for {} (h:mm:ss): the static equilibrium of a ground may take as long, "
        "otherwise look whether its machine still works\n",
        model::clock_words(since));
  return words + warnings_of(folder);
}

}  // namespace trackbed::app
