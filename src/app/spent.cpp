// Each parameter acts at some time: when stones are made, when a stage begins, in every window. The
// rules below say until when, for the few that have a last time; all others are never spent. A
// sentence is better than silence: a user who changes the grading of a bed that stands already
// would find the new one in the results' deck.
#include "app/spent.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "app/compatible.hpp"
#include "app/deck_files.hpp"
#include "app/deck_values.hpp"
#include "app/version.hpp"

namespace trackbed::app {

namespace {

// Where the run is that goes on.
struct Position {
  std::size_t stage;  // the one under way, or else the first that is still to come
  bool begun;         // it is under way
  bool ground_moved;
  bool same_run;  // its stages are those of the checkpoint's deck, by number
};

bool is_to_come(const Model& model, std::size_t from, std::initializer_list<StageKind> kinds) {
  for (std::size_t i = from; i < model.stages.size(); ++i)
    if (std::find(kinds.begin(), kinds.end(), model.stages[i].kind) != kinds.end()) return true;
  return false;
}

// Cribs cut at their end, other stages at their begin.
bool cuts_to_come(const Model& model, std::size_t now, std::size_t next) {
  for (std::size_t i = now; i < model.stages.size(); ++i)
    if (model.stages[i].profile > 0 && (i >= next || model.stages[i].kind == StageKind::cribs))
      return true;
  return false;
}

// What a stage looks at only when it begins.
// Loads, damping and friction are not among them: they act in every window, and `resume` sets them
// again.
bool acts_at_begin(std::string_view name, StageKind kind) {
  static constexpr std::array names = {"name",   "kind",         "duration", "cycles",
                                       "height", "ground_moves", "train"};
  if (name == "profile") return kind != StageKind::cribs;
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Why another value of `key` does not act any more, or nothing.
std::string why_spent(std::string_view key, const Model& model, const Position& at) {
  const std::size_t next = at.stage + (at.begun ? 1 : 0);  // first stage that has yet to begin
  if (key == "bed.crest" || key == "bed.slope")
    return cuts_to_come(model, at.stage, next) ? "" : "the bed has been cut";
  if (key.starts_with("bed."))
    return is_to_come(model, next, {StageKind::fill, StageKind::cribs}) ? ""
                                                                        : "the stones are made";
  if (key.starts_with("platen."))
    return is_to_come(model, at.stage, {StageKind::compact, StageKind::shear, StageKind::triaxial})
               ? ""
               : "nothing is compacted any more";
  if (key.starts_with("tamping."))
    return is_to_come(model, next, {StageKind::tamp}) ? "" : "nothing is tamped any more";
  if (key == "settle_average") return at.ground_moved ? "the ground moves already" : "";
  if (key.starts_with("time.") || key == "dem.safety")
    return next < model.stages.size() ? "" : "the last stage has its steps already";
  if (at.same_run && key.starts_with("region["))
    return "the histories of this run are measured in the old one";
  if (!key.starts_with("stage[")) return "";
  const std::size_t number = std::stoul(std::string(key.substr(6)));
  if (number < at.stage) return "this stage is over";
  const std::string_view name = key.substr(key.find("].") + 2);
  return number == at.stage && at.begun && acts_at_begin(name, model.stages[number].kind)
             ? "this stage has begun"
             : "";
}

// A ground is in the checkpoint once it has moved.
Position position_of(const io::File& checkpoint, const std::string& path, const Model& model,
                     const input::Deck& deck, GoesOn goes_on) {
  const bool begun = checkpoint.integer_attribute("/", "stage_finished") == 0;
  const auto counts = checkpoint.read_all<std::int64_t>("run/counts");
  const bool moved = checkpoint.has("ground");
  if (goes_on == GoesOn::in_another)
    return {stage_after(checkpoint, path, model, deck), false, moved, false};
  return {static_cast<std::size_t>(counts.at(0)) + (begun ? 0 : 1), begun, moved, true};
}

// Keys of the stages of another deck, numbered as this one numbers the stages of those names; a
// stage that this deck does not have is left out.
Values renumbered(const Values& then, const Model& model) {
  Values values;
  for (const auto& [key, value] : then) {
    if (!key.starts_with("stage[")) {
      values[key] = value;
      continue;
    }
    const std::size_t end = key.find("].");
    const auto name = then.find(key.substr(0, end) + "].name");
    for (std::size_t i = 0; name != then.end() && i < model.stages.size(); ++i)
      if (name->second == fmt::format("\"{}\"", model.stages[i].name))
        values[fmt::format("stage[{}{}", i, key.substr(end))] = value;
  }
  return values;
}

}  // namespace

std::vector<std::string> spent_changes(const par::Comm& comm, const io::File& checkpoint,
                                       const std::string& path, const Model& model,
                                       const input::Deck& deck, GoesOn goes_on) {
  const std::string effective = effective_deck(model);
  Values then = values_of(checkpoint.text_attribute("/", "deck"));
  if (goes_on == GoesOn::in_another) then = renumbered(then, model);
  then = with_moved_files(comm, checkpoint, then, effective);
  const Values now = values_of(effective);
  const Position at = position_of(checkpoint, path, model, deck, goes_on);
  std::vector<std::string> sentences;
  for (const auto& [key, value] : now) {
    const auto old = then.find(key);
    if (old == then.end() || old->second == value || !deck.gives(key)) continue;
    if (const std::string why = why_spent(key, model, at); !why.empty())
      sentences.push_back(fmt::format("{} = {} has no effect: {}, with {} ({})", deck.where(key),
                                      value, why, old->second, path));
  }
  return sentences;
}

}  // namespace trackbed::app
