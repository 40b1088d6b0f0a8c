// Both decks are compared as the text that `effective` writes: equal values have equal texts
// (numbers have 17 digits), and a stored deck may no longer be valid, for example because a table
// beside it is missing.
//
// Only parameters on which the state depends are compared. Refusing any difference would be
// simpler, but a start from a checkpoint is meant for other loads, outputs or contact laws. A
// parameter that is not listed here is free to change.
#include "app/restart/compatible.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "app/deck/deck_files.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/model/effective.hpp"

namespace trackbed::app {

namespace {

// Contents of the checkpoint, which restrict the decks that can continue from it.
struct Contents {
  bool sleepers;      // placed
  bool solids;        // sleepers are solids
  bool solid_rails;   // rails on them are solids
  bool moved_ground;  // the ground has moved from static equilibrium
  bool plane;         // a plane model
  bool viscous_base;  // of the ground
  bool implicit;      // the ground's last window was an implicit step
  bool train;         // a train is under way
  bool tines;         // tines are inserted
};

// From the deck that made the state and not from the new one.
Contents contents_of(const io::File& checkpoint, const Values& deck) {
  const auto is = [&](const char* key, const char* value) {
    const auto found = deck.find(key);
    return found != deck.end() && found->second == value;
  };
  return {.sleepers = checkpoint.has("sleepers"),
          .solids = checkpoint.has("sleepers/solid"),
          .solid_rails = is("solid.rails", "true"),
          .moved_ground = checkpoint.has("ground"),
          .plane = is("dimension", "\"plane\""),
          .viscous_base = is("ground.base", "\"viscous\""),
          .implicit = !is("ground.integrator", "\"explicit\""),
          .train = checkpoint.has("train"),
          .tines = checkpoint.has("tines")};
}

bool is_one_of(std::string_view key, const auto& keys) {
  for (const std::string_view known : keys)
    if (key == known) return true;
  return false;
}

// The state of a moved ground is its displacement from static equilibrium, which depends on
// boundary conditions, springs and plane state as well as on materials: other values would release
// forces that nothing balances, and a border fixed from now on would keep its velocity. Implicit
// steps can continue from the displacement, velocity and acceleration of explicit ones, but they
// leave the nodal forces of their predictor, which explicit steps would take for the present
// forces. Damping, tolerances and the integrators' constants are not part of the state.
bool matters_to_moved_ground(std::string_view key, const Contents& holds) {
  if (key.starts_with("pressure[")) return !key.ends_with("].name");  // dead ones: equilibrium
  if (key == "ground.base" || key == "ground.sides" || key == "ground.base_motion") return true;
  if (key.starts_with("ground.side_")) return true;
  if (key == "ground.base_stiffness") return holds.viscous_base;
  if (key == "ground.plane") return holds.plane;
  if (key == "ground.integrator") return holds.implicit;
  if (key.starts_with("ground.border[")) return true;
  const bool solid = key.starts_with("ground.layer[") || key.starts_with("ground.block[") ||
                     key.starts_with("ground.solid[");
  return solid && !key.ends_with("].name") && key.find("].rayleigh_") == key.npos;
}

// The state of a running train and of the rail below it depends on their parameters.
// Irregularities, the wheel-rail contact and the step may change.
bool matters_to_train(std::string_view key) {
  static constexpr std::array sections = {"rail.",    "pad.",   "ballast.", "track.",
                                          "vehicle[", "train.", "seat."};
  return std::any_of(sections.begin(), sections.end(),
                     [&](const char* section) { return key.starts_with(section); });
}

// Strains of solids depend on their stiffness. Damping and the scheme's constant may change.
bool matters_to_solids(std::string_view key, const Contents& holds) {
  if (key == "solid.alpha" || key == "solid.rayleigh_stiffness" || key == "pad.damping")
    return false;
  const bool rail = key.starts_with("rail.") || key.starts_with("pad.");
  return key.starts_with("solid.") || (rail && holds.solid_rails);
}

// The stones depend on the domain, and the load of the bed on the nodes of the ground's top; the
// material of a ground that has not moved yet may still change.
bool matters(std::string_view key, const Contents& holds) {
  static constexpr std::array always = {"dimension",
                                        "thickness",
                                        "periodic",
                                        "bed.x",
                                        "bed.y",
                                        "bed.container",
                                        "bed.split",
                                        "bed.beside",
                                        "ground.present",
                                        "ground.x",
                                        "ground.y",
                                        "ground.elements_x",
                                        "ground.elements_y",
                                        "ground.elements_z",
                                        "ground.ratio_x",
                                        "ground.ratio_y",
                                        "ground.fine_x",
                                        "ground.fine_y",
                                        "ground.mesh",
                                        "ground.mesh_top"};
  static constexpr std::array placed = {"sleepers.count", "sleepers.first",  "sleepers.spacing",
                                        "sleepers.width", "sleepers.height", "sleepers.length",
                                        "sleepers.bevel", "sleepers.y",      "sleepers.model"};
  if (is_one_of(key, always)) return true;
  // Placed at the start of the run; positions of plates follow from the deck and the time.
  for (const char* table : {"stone[", "plate[", "box[", "domain."})
    if (key.starts_with(table)) return true;
  if (is_one_of(key, placed)) return holds.sleepers;
  if (key.starts_with("tamping.")) return holds.tines;
  if (holds.solids && matters_to_solids(key, holds)) return true;
  if (key.starts_with("ground.layer[") &&
      (key.ends_with("].thickness") || key.ends_with("].elements")))
    return true;
  if (key.starts_with("ground.section[") || key == "ground.embankment_layers") return true;
  if (holds.train && matters_to_train(key)) return true;
  return holds.moved_ground && matters_to_moved_ground(key, holds);
}

std::string worded(const Values& values, const std::string& key) {
  const auto found = values.find(key);
  return found == values.end() ? "without this parameter" : "with " + found->second;
}

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
  if (kind == "\"track\"") model.set_kind(model::ModelKind::track);
  if (kind == "\"track_on_ground\"") model.set_kind(model::ModelKind::track_on_ground);
  if (kind == "\"ground\"") model.kind = model::ModelKind::ground, model.pressures.resize(1);
  if (kind == "\"stones\"") {
    model.kind = model::ModelKind::stones;
    model.placed.stones.resize(1), model.placed.plates.resize(1), model.placed.boxes.resize(1);
  }
  model.ground.layers.resize(1), model.ground.blocks.resize(1), model.ground.solids.resize(1);
  model.ground.borders.resize(1), model.ground.sections.resize(1);
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

void require_same_model(const par::Comm& comm, const io::File& checkpoint, const std::string& path,
                        const std::string& effective, const input::Deck& deck) {
  const Values now = values_of(effective);
  const Values then = with_moved_files(comm, checkpoint, stored_values(checkpoint, now), effective);
  const Contents holds = contents_of(checkpoint, then);
  // Keys of both decks: a missing one differs as much as a new one.
  Values all = now;
  all.insert(then.begin(), then.end());
  std::vector<std::string> problems;
  // All differences are reported together: otherwise a user would wait in a queue for each of them.
  for (const auto& [key, value] : all) {
    // Stones store the number of their material: the order of the old materials must not change.
    const bool numbered =
        key.starts_with("material[") && key.ends_with("].name") && then.contains(key);
    if (!numbered && !matters(key, holds)) continue;
    const auto new_one = now.find(key), old_one = then.find(key);
    if (new_one != now.end() && old_one != then.end() && new_one->second == old_one->second)
      continue;
    problems.push_back(fmt::format(
        "{} {}: the checkpoint {} was made {}; both must be equal", deck.where(key),
        new_one == now.end() ? "is missing" : "= " + new_one->second, path, worded(then, key)));
  }
  for (const auto& [key, sentence] : changed_files(comm, checkpoint, path, effective, deck))
    // Another profile may be named during a passage; a changed file of the same name is a mistake.
    if (matters(key, holds) || (holds.train && key.starts_with("irregularity")))
      problems.push_back(sentence);
  if (!problems.empty()) throw InputError(problems);
}

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
        fmt::format("{} = {}: the stones of {} have overlaps that belong to {}, so that contact "
                    "forces jump with the stiffness; let the stones settle with high damping first",
                    deck.where(key), value, path, before->second));
  }
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
    refuse(fmt::format("after stage \"{}\", which this deck does not have", name));
  if (number + 1 == model.stages.size())
    refuse(fmt::format("after stage \"{}\", the last stage of this deck: no stage is left", name));
  return number + 1;
}

}  // namespace trackbed::app
