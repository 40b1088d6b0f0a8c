// progress.jsonl in the folder of a run: a line of JSON for each event, for programs that watch the
// run and for `trackbed info DIR`. Keys and units: docs/running.md.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "trackbed/model/scheme.hpp"

namespace trackbed::app {

inline constexpr const char* progress_file = "progress.jsonl";

// A line that cannot be written is lost: the run does not depend on it. Holds references.
class Progress {
 public:
  Progress(const model::RunContext& context, const model::Scheme& scheme)
      : context_(context), scheme_(scheme) {}

  // Appends a line with `event`, the time and the stage, followed by `more`. Rank 0 writes.
  void note(const char* event,
            const nlohmann::ordered_json& more = nlohmann::ordered_json::object());
  // The first line of a command. `from`: the checkpoint with which it began, or empty.
  void begin(const std::string& from);

 private:
  const model::RunContext& context_;
  const model::Scheme& scheme_;
};

// State of the run in `folder` by its lock, progress.jsonl and summary.json, as lines of text;
// empty if it has no progress.jsonl. Reads files; on rank 0.
std::string describe_progress(const std::string& folder);

}  // namespace trackbed::app
