// Each parameter acts at certain times: when stones are made, when a stage begins, or in every
// window. The rules below define the last time for the few parameters that have one. A change
// without effect must be reported: otherwise, for example, a new grading of an existing bed would
// be in the deck of the results.
#include "app/restart/spent.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "app/deck/deck_files.hpp"
#include "app/deck/deck_values.hpp"
#include "app/restart/compatible.hpp"
#include "trackbed/model/course.hpp"
#include "trackbed/model/effective.hpp"

namespace trackbed::app {

namespace {

// Position in the run at which it continues.
struct Position {
  std::size_t stage;  // the present one, or the next one between stages
  bool begun;         // whether this stage has begun
  bool ground_moved;
  bool same_run;  // its stages are those of the checkpoint's deck, by number
};

bool is_to_come(const model::Model& model, std::size_t from,
                std::initializer_list<model::StageKind> kinds) {
  for (std::size_t i = from; i < model.stages.size(); ++i)
    if (std::find(kinds.begin(), kinds.end(), model.stages[i].kind) != kinds.end()) return true;
  return false;
}

// Cribs are cut at the end of the stage; other stages cut when they begin.
bool cuts_to_come(const model::Model& model, std::size_t now, std::size_t next) {
  for (std::size_t i = now; i < model.stages.size(); ++i)
    if (model.stages[i].profile > 0 &&
        (i >= next || model.stages[i].kind == model::StageKind::cribs))
      return true;
  return false;
}

// Parameters that a stage uses only when it begins. Loads, damping and friction act in every
// window, and `resume` sets them again.
bool acts_at_begin(std::string_view name, model::StageKind kind) {
  static constexpr std::array names = {"name",   "kind",         "duration", "cycles",
                                       "height", "ground_moves", "train"};
  if (name == "profile") return kind != model::StageKind::cribs;
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Why a change of `key` has no effect any more, or empty.
std::string why_spent(std::string_view key, const model::Model& model, const Position& at) {
  const std::size_t next = at.stage + (at.begun ? 1 : 0);  // first stage that has yet to begin
  if (key == "bed.crest" || key == "bed.slope")
    return cuts_to_come(model, at.stage, next) ? ""
                                               : "no remaining stage cuts the bed to a profile";
  if (key.starts_with("bed."))
    return is_to_come(model, next, {model::StageKind::fill, model::StageKind::cribs})
               ? ""
               : "the stones have already been made";
  if (key.starts_with("platen."))
    return is_to_come(
               model, at.stage,
               {model::StageKind::compact, model::StageKind::shear, model::StageKind::triaxial})
               ? ""
               : "the platen loads the bed in no remaining stage";
  if (key.starts_with("tamping."))
    return is_to_come(model, next, {model::StageKind::tamp}) ? ""
                                                             : "no stage of kind tamp will begin";
  if (key == "settle_average") return at.ground_moved ? "the ground already moves" : "";
  if (key.starts_with("time.") || key == "dem.safety")
    return next < model.stages.size() ? "" : "the steps of the last stage are already chosen";
  if (at.same_run && key.starts_with("region["))
    return "the histories of this run contain this region as it was defined at the start";
  if (at.same_run && key.starts_with("sensor["))
    return "the histories of this run contain this sensor as it was defined at the start";
  if (at.same_run && key == "dem.energy_balance")
    return "the histories of this run were begun with or without the balance of energy";
  if (at.same_run && key == "output.histories")
    return "the parts whose histories this run contains were chosen at the start";
  if (key.starts_with("bond[")) {
    static constexpr std::array at_making = {"present",  "from", "low",   "high",
                                             "material", "gap",  "radius"};
    const std::size_t kind = std::stoul(std::string(key.substr(5)));
    const std::string_view name = key.substr(key.find("].") + 2);
    const bool over = model.bonds_from(kind) < next;
    return over && std::find(at_making.begin(), at_making.end(), name) != at_making.end()
               ? "these bonds have already been made"
               : "";
  }
  if (!key.starts_with("stage[")) return "";
  const std::size_t number = std::stoul(std::string(key.substr(6)));
  if (number < at.stage) return "this stage is over";
  const std::string_view name = key.substr(key.find("].") + 2);
  return number == at.stage && at.begun && acts_at_begin(name, model.stages[number].kind)
             ? "this stage has already begun"
             : "";
}

// A ground is in the checkpoint once it has moved.
Position position_of(const io::File& checkpoint, const std::string& path, const model::Model& model,
                     const input::Deck& deck, Continuation goes_on) {
  const bool moved = checkpoint.has("ground");
  if (goes_on == Continuation::in_another)
    return {stage_after(checkpoint, path, model, deck), false, moved, false};
  const model::Course course = model::course_in(checkpoint);
  return {course.stage + (course.begun ? 0 : 1), course.begun, moved, true};
}

// Keys of the stages of another deck, renumbered by the names of this deck's stages; stages that
// this deck does not have are left out.
Values renumbered(const Values& then, const model::Model& model) {
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

// Regions and sensors that only one of both decks has: the columns of the histories of a run cannot
// begin or end within it.
std::vector<std::string> other_rows_of_histories(const Values& then, const Values& now,
                                                 const std::string& path) {
  std::vector<std::string> sentences;
  const auto only_in = [&](const Values& one, const Values& other, const char* sentence) {
    for (const auto& [key, value] : one)
      if ((key.starts_with("region[") || key.starts_with("sensor[")) && key.ends_with("].name") &&
          !other.contains(key))
        sentences.push_back(fmt::format("{} = {}: {} {}", key, value, path, sentence));
  };
  only_in(now, then,
          "does not contain this name; a resumed run cannot add regions or sensors; leave out the "
          "override that adds it");
  only_in(then, now,
          "contains this name; a resumed run must keep its regions and sensors; leave out the "
          "override that removes it");
  return sentences;
}

}  // namespace

std::vector<std::string> spent_changes(const par::Comm& comm, const io::File& checkpoint,
                                       const std::string& path, const model::Model& model,
                                       const input::Deck& deck, Continuation goes_on) {
  const std::string effective = model::effective_deck(model);
  Values then = values_of(checkpoint.text_attribute("/", "deck"));
  if (goes_on == Continuation::in_another) then = renumbered(then, model);
  then = with_moved_files(comm, checkpoint, then, effective);
  const Values now = values_of(effective);
  const Position at = position_of(checkpoint, path, model, deck, goes_on);
  std::vector<std::string> sentences;
  if (at.same_run) sentences = other_rows_of_histories(then, now, path);
  for (const auto& [key, value] : now) {
    const auto old = then.find(key);
    if (old == then.end() || old->second == value || !deck.sets(key)) continue;
    if (const std::string why = why_spent(key, model, at); !why.empty())
      sentences.push_back(
          fmt::format("{} = {} has no effect: {}; leave it out (the value in {} is {})",
                      deck.where(key), value, why, path, old->second));
  }
  return sentences;
}

}  // namespace trackbed::app
