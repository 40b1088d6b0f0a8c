// Both decks are compared as the text that `effective` writes: equal values have equal texts
// (numbers have 17 digits), and a stored deck may no longer be valid, for example because a table
// beside it is missing.
//
// A declaration states which parts of a state fix a parameter (input/state_parts.hpp); all other
// parameters are free to change. Refusing any difference would be simpler, but a start from a
// checkpoint is meant for other loads, outputs or contact laws.
#include "app/restart/compatible.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "app/deck/deck_files.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/model/effective.hpp"

namespace trackbed::app {

using input::StateParts;

namespace {

// The parts of the state in a checkpoint, which fix parameters. `deck`: the one that made the
// state, not the new one.
StateParts parts_of(const io::File& checkpoint, const Values& deck) {
  using namespace input::state;
  const auto is = [&](const char* key, const char* value) {
    const auto found = deck.find(key);
    return found != deck.end() && found->second == value;
  };
  StateParts parts = any | earlier;
  const auto add = [&](bool holds, StateParts part) { parts |= holds ? part : none; };
  const bool solids = checkpoint.has("sleepers/solid"), moved = checkpoint.has("ground");
  add(is("model", "\"track\"") || is("model", "\"track_on_ground\""), passage);
  add(checkpoint.has("sleepers"), sleepers);
  add(solids, solid_sleepers);
  add(solids && is("solid.rails", "true"), solid_rails);
  add(checkpoint.has("tines"), tines);
  add(checkpoint.has("train"), train);
  add(moved, moved_ground);
  add(moved && is("dimension", "\"plane\""), moved_plane_ground);
  add(moved && is("ground.base", "\"viscous\""), moved_viscous_base);
  add(moved && !is("ground.integrator", "\"explicit\""), moved_implicitly);
  return parts;
}

// The parts that fix each parameter, by its path in the reference ("ground.layer[].young").
class FixedParameters {
 public:
  explicit FixedParameters(const input::Declaration& declaration) {
    for (const input::ParameterInfo& parameter : input::all_parameters(declaration))
      parts_[parameter.path] = parameter.fixed_by;
  }
  // Of a key ("ground.layer[1].young"). A parameter that only the stored deck has, because the
  // program no longer does, counts as fixed.
  StateParts operator()(const std::string& key) const {
    std::string path = key;
    if (const std::size_t open = key.find('['); open != key.npos)
      path.erase(open + 1, key.find(']') - open - 1);
    if (const auto found = parts_.find(path); found != parts_.end()) return found->second;
    // An empty list ("region = []") has no rows that could differ; rows are compared one by one.
    const auto row = parts_.lower_bound(path + "[].");
    return row != parts_.end() && row->first.starts_with(path + "[].") ? input::state::none
                                                                       : input::state::any;
  }

 private:
  std::map<std::string, StateParts> parts_;
};

std::string value_of(const Values& values, const std::string& key) {
  const auto found = values.find(key);
  return found == values.end() ? "" : found->second;
}

// "contact[0]", "contact[1]" ... with Hertz's law, which takes its stiffness from the materials.
std::vector<std::string> rows_of_hertz(const Values& values) {
  std::vector<std::string> rows;
  for (const auto& [key, value] : values)
    if (key.starts_with("contact[") && key.ends_with("].law") && value == "\"hertz\"")
      rows.push_back(key.substr(0, key.rfind('.')));
  return rows;
}

// Whether the stiffness of contacts depends on it. `row`: that of the key.
bool makes_stiffness(const Values& values, const std::string& key, const std::string& row) {
  const std::vector<std::string> hertz = rows_of_hertz(values);
  if (key.starts_with("contact[")) {
    if (key.ends_with("].law")) return true;
    const bool given = std::find(hertz.begin(), hertz.end(), row) == hertz.end();
    return given && (key.ends_with("].k_n") || key.ends_with("].k_s"));
  }
  if (!key.ends_with("].young") && !key.ends_with("].poisson")) return false;
  const std::string name = value_of(values, row + ".name");
  return key.starts_with("material[") &&
         std::any_of(hertz.begin(), hertz.end(), [&](const std::string& pair) {
           return value_of(values, pair + ".first") == name ||
                  value_of(values, pair + ".second") == name;
         });
}

// What a row of [[contact]] or [[material]] is about.
std::string names_of_row(const Values& values, const std::string& row) {
  return value_of(values, row + ".name") + value_of(values, row + ".first") +
         value_of(values, row + ".second");
}

// All default values, with one row of each table.
Values defaults_of(const std::string& kind) {
  model::Model model;
  if (kind == "\"track\"") model.kind = model::ModelKind::track;
  if (kind == "\"track_on_ground\"") model.kind = model::ModelKind::track_on_ground;
  if (kind == "\"ground\"") model.kind = model::ModelKind::ground, model.pressures.resize(1);
  if (kind == "\"stones\"") {
    model.kind = model::ModelKind::stones;
    model.placed.stones.resize(1), model.placed.plates.resize(1), model.placed.boxes.resize(1);
  }
  model.ground.layers.resize(1), model.ground.blocks.resize(1), model.ground.solids.resize(1);
  model.ground.borders.resize(1), model.ground.sections.resize(1);
  model.sensors.resize(1);
  model.track.vehicles.resize(1), model.track.line.track.zones.resize(1);
  model.track.passage.forces.resize(1);
  return values_of(model::effective_deck(model));
}

}  // namespace

Values stored_values(const io::File& checkpoint, const Values& now) {
  Values then = values_of(checkpoint.text_attribute("/", "deck"));
  const auto model = now.find("model");
  const Values defaults = defaults_of(model == now.end() ? "" : model->second);
  const Values given = then;
  for (const auto& [key, value] : now) {
    if (given.contains(key)) continue;
    std::string row_of_defaults = key;
    if (const std::size_t open = key.find('['); open != key.npos) {
      const std::size_t close = key.find(']', open);
      const std::string row = key.substr(0, close + 2);  // with the dot
      const auto of_row = given.lower_bound(row);
      if (of_row == given.end() || !of_row->first.starts_with(row)) continue;  // a new row
      row_of_defaults.replace(open + 1, close - open - 1, "0");
    }
    if (const auto found = defaults.find(row_of_defaults); found != defaults.end())
      then[key] = found->second;
  }
  // Before the preload existed, pads with uplift lifted off at zero force.
  if (const auto lifts = given.find("pad.uplift");
      lifts != given.end() && lifts->second == "true" && !given.contains("pad.preload"))
    then["pad.preload"] = values_of(input::effective([](input::Section& s) {
                            track::PadParameters pad;
                            pad.preload = 0;
                            s.table("pad", pad, "");
                          })).at("pad.preload");
  return then;
}

bool require_same_model(const par::Comm& comm, const io::File& checkpoint, const std::string& path,
                        const model::Model& model, const input::Deck& deck) {
  const std::string effective = model::effective_deck(model);
  const Values now = values_of(effective);
  const Values then = with_moved_files(comm, checkpoint, stored_values(checkpoint, now), effective);
  const StateParts parts = parts_of(checkpoint, then);
  model::Model declared = model;
  const FixedParameters fixed_by(model::declaration_of(declared));
  // Keys of both decks: a missing one differs as much as a new one.
  Values all = now;
  all.insert(then.begin(), then.end());
  std::vector<std::string> problems;
  bool same = true;
  // All differences are reported together: otherwise a user would wait in a queue for each of them.
  for (const auto& [key, value] : all) {
    const auto new_one = now.find(key), old_one = then.find(key);
    const bool gone = new_one == now.end(), is_new = old_one == then.end();
    if (!gone && !is_new && new_one->second == old_one->second) continue;
    same = false;
    const StateParts holds = is_new ? parts & ~input::state::earlier : parts;
    if ((fixed_by(key) & holds) == 0) continue;
    const std::string made = is_new ? "without this parameter; leave it out"
                                    : fmt::format("with {}; {}", old_one->second,
                                                  gone ? "give this value" : "both must be equal");
    problems.push_back(fmt::format("{} {}: the checkpoint {} was made {}", deck.where(key),
                                   gone ? "is missing" : "= " + new_one->second, path, made));
  }
  const bool train = (parts & input::state::train) != 0;
  const StateParts content = parts | (train ? input::state::content_with_train : 0);
  for (const auto& [key, sentence] : changed_files(comm, checkpoint, path, effective, deck))
    if ((fixed_by(key) & content) != 0) problems.push_back(sentence);
  if (!problems.empty()) throw InputError(problems);
  return same;
}

namespace {

// The value of a parameter of the stage in which the checkpoint was written.
std::string value_of_stage(const io::File& checkpoint, const Values& then, const char* name) {
  const std::string stage = fmt::format("\"{}\"", checkpoint.text_attribute("/", "stage"));
  for (const auto& [key, value] : then)
    if (key.starts_with("stage[") && key.ends_with("].name") && value == stage)
      return value_of(then, key.substr(0, key.rfind('.') + 1) + name);
  return {};
}

}  // namespace

std::vector<std::string> changed_springs(const io::File& checkpoint, const std::string& path,
                                         const std::string& effective, const input::Deck& deck) {
  const Values then = values_of(checkpoint.text_attribute("/", "deck"));
  const Values now = values_of(effective);
  std::vector<std::string> sentences;
  for (const auto& [key, value] : now) {
    const std::string row = key.substr(0, key.find("].") + 1);
    if (!makes_stiffness(now, key, row)) continue;
    if (names_of_row(now, row) != names_of_row(then, row)) continue;  // of other materials
    const auto before = then.find(key);
    if (before == then.end() || before->second == value) continue;
    sentences.push_back(
        fmt::format("{} = {} ({} in {}): the stored overlaps of the stones are in equilibrium with "
                    "the previous value, so that the contact forces jump at the start; first let "
                    "the stones settle with high damping (stage.local_damping)",
                    deck.where(key), value, before->second, path));
  }
  if (const std::string soft = value_of_stage(checkpoint, then, "stiffness");
      !soft.empty() && soft != "1.0")
    sentences.push_back(
        fmt::format("{} was written in a stage with stiffness = {}: the stored overlaps of the "
                    "stones are in equilibrium with softer contacts, so that the contact forces "
                    "jump at the start; take the state of a later stage",
                    path, soft));
  return sentences;
}

std::size_t stage_after(const io::File& checkpoint, const std::string& path,
                        const model::Model& model, const input::Deck& deck) {
  const std::string name = checkpoint.text_attribute("/", "stage");
  const auto refuse = [&](const std::string& why) {
    throw InputError({fmt::format("{} \"{}\" was written {}", deck.where("start"), path, why)});
  };
  if (checkpoint.integer_attribute("/", "stage_finished") == 0)
    refuse(
        fmt::format("within stage \"{}\"; a run can start only from the end of a stage (or use "
                    "`trackbed resume`)",
                    name));
  // By name and not by number: the new deck may have other stages before it.
  std::size_t number = 0;
  while (number < model.stages.size() && model.stages[number].name != name) ++number;
  if (number == model.stages.size())
    refuse(
        fmt::format("after stage \"{}\", which this deck does not have; give the deck a stage of "
                    "this name, or start from another checkpoint",
                    name));
  if (number + 1 == model.stages.size())
    refuse(fmt::format(
        "after stage \"{}\", the last stage of this deck: no stage is left; add a stage after it",
        name));
  return number + 1;
}

namespace {

// Parameters of a bed that a bed of copies has for itself, and not from its cell.
bool is_of_copies(const std::string& key) {
  constexpr std::array own = {"bed.x", "bed.y", "bed.cell", "bed.crest", "bed.slope", "bed.seed"};
  return std::find(own.begin(), own.end(), key) != own.end();
}

}  // namespace

std::vector<std::string> changed_stones(const io::File& cell, const std::string& path,
                                        const std::string& effective, const input::Deck& deck) {
  const Values then = values_of(cell.text_attribute("/", "deck"));
  std::vector<std::string> sentences;
  for (const auto& [key, value] : values_of(effective)) {
    const auto before = then.find(key);
    if (!key.starts_with("bed.") || is_of_copies(key) || !deck.sets(key)) continue;
    if (before == then.end() || before->second == value) continue;
    sentences.push_back(
        fmt::format("{} = {} ({} in {}): stones are copied from this cell, so that the value has "
                    "no effect on them; give that of the cell, or make another cell",
                    deck.where(key), value, before->second, path));
  }
  return sentences;
}

}  // namespace trackbed::app
