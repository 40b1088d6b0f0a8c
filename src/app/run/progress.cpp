#include "app/run/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "trackbed/core/unix_time.hpp"
#include "trackbed/model/effective.hpp"

namespace trackbed::app {

namespace {

using Json = nlohmann::ordered_json;

std::string host() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "?";
}

// The last line of a run that was killed may have no end.
bool ends_within_a_line(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file || file.tellg() == 0) return false;
  file.seekg(-1, std::ios::end);
  return file.get() != '\n';
}

}  // namespace

void Progress::note(const char* event, const Json& more) {
  if (!context_.comm.root()) return;
  const model::Course& course = context_.course;
  // After the last stage, where a run continues that was killed before its summary, there is none.
  const bool within = course.stage < scheme_.stages();
  Json line{{"event", event},
            {"unix_time_s", unix_time()},
            {"wall_time_s", context_.log.wall_time()},
            {"time_s", course.clock.time()},
            {"stage", within ? scheme_.stage() : ""},
            {"stage_number", std::min(course.stage + 1, scheme_.stages())},
            {"stages", scheme_.stages()},
            {"window", course.clock.window()},
            {"windows_at_most", course.clock.windows()},
            {"windows_of_run", course.windows}};
  line.update(more);
  // In one piece, so that a reader never sees half a line of a run that goes on.
  std::ofstream(context_.folder + "/" + progress_file, std::ios::app)
      << line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void Progress::begin(const std::string& from) {
  if (context_.comm.root()) {
    const std::string path = context_.folder + "/" + progress_file;
    if (ends_within_a_line(path)) std::ofstream(path, std::ios::app) << "\n";
  }
  note("begin", {{"deck", context_.name},
                 {"from", from},
                 {"ranks", context_.comm.size()},
                 {"host", host()},
                 {"version", model::version()}});
}

}  // namespace trackbed::app
