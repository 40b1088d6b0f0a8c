// Both decks are compared as the text that `effective` writes: equal values have equal texts there
// (numbers have 17 digits), and a stored deck need not be valid any more, e.g. because a table
// beside it is gone.
//
// Compared are only parameters that the state depends on. Refusing any difference would be simpler,
// but to go on with other loads, outputs or contact laws is what a start from a checkpoint is for.
// A parameter that is not listed here is free to change.
#include "app/compatible.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "app/deck_files.hpp"
#include "app/version.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::app {

namespace {

// What lies in the checkpoint and so ties the decks that go on from it.
struct Holds {
  bool sleepers;      // placed
  bool solids;        // and they are solids
  bool solid_rails;   // on them
  bool moved_ground;  // has left its rest
  bool plane;         // a plane model
  bool quiet_base;    // of the ground
  bool implicit;      // steps made the ground's last window
  bool train;         // is on its way
  bool tines;         // are in it
};

// From the deck that made the state, not from the new one: it says what the state is.
Holds holds_of(const io::File& checkpoint, const Values& deck) {
  const auto is = [&](const char* key, const char* value) {
    const auto found = deck.find(key);
    return found != deck.end() && found->second == value;
  };
  return {.sleepers = checkpoint.has("sleepers"),
          .solids = checkpoint.has("sleepers/solid"),
          .solid_rails = is("solid.rails", "true"),
          .moved_ground = checkpoint.has("ground"),
          .plane = is("dimension", "\"plane\""),
          .quiet_base = is("ground.base", "\"quiet\""),
          .implicit = !is("ground.integrator", "\"explicit\""),
          .train = checkpoint.has("train"),
          .tines = checkpoint.has("tines")};
}

bool is_one_of(std::string_view key, const auto& keys) {
  for (const std::string_view known : keys)
    if (key == known) return true;
  return false;
}

// A ground that has moved carries deviations from its state of rest, which borders, springs and
// plane state made as much as materials did: others would set free forces that nothing holds, and a
// border held from now on would keep the velocity it has. Implicit steps go on from the
// displacement, velocity and acceleration that explicit ones leave, but leave the nodal forces of
// their predictor, which explicit steps would take for those of the present. Damping, tolerances
// and the integrators' constants are no part of a state.
bool matters_to_moved_ground(std::string_view key, const Holds& holds) {
  if (key.starts_with("pressure[")) return !key.ends_with("].name");  // the dead ones made the rest
  if (key == "ground.base" || key == "ground.sides" || key == "ground.base_motion") return true;
  if (key.starts_with("ground.side_")) return true;
  if (key == "ground.base_stiffness") return holds.quiet_base;
  if (key == "ground.plane") return holds.plane;
  if (key == "ground.integrator") return holds.implicit;
  if (key.starts_with("ground.border[")) return true;
  const bool solid = key.starts_with("ground.layer[") || key.starts_with("ground.block[") ||
                     key.starts_with("ground.solid[");
  return solid && !key.ends_with("].name") && key.find("].rayleigh_") == key.npos;
}

// A train on its way, and the rail below it, are what they were made of. Where the rail is uneven,
// its contact with wheels and the step may change.
bool matters_to_train(std::string_view key) {
  static constexpr std::array sections = {"rail.",    "pad.",   "ballast.", "track.",
                                          "vehicle[", "train.", "seat."};
  return std::any_of(sections.begin(), sections.end(),
                     [&](const char* section) { return key.starts_with(section); });
}

// Solids are strained as their stiffness wants it. Damping and the scheme's constant may change.
bool matters_to_solids(std::string_view key, const Holds& holds) {
  if (key == "solid.alpha" || key == "solid.rayleigh_stiffness" || key == "pad.damping")
    return false;
  const bool rail = key.starts_with("rail.") || key.starts_with("pad.");
  return key.starts_with("solid.") || (rail && holds.solid_rails);
}

// Stones know the domain; the load of the bed lies on the nodes of the ground's top; a ground that
// has not moved yet may still be of another kind.
bool matters(std::string_view key, const Holds& holds) {
  static constexpr std::array always = {
      "dimension",      "thickness",      "periodic",       "bed.x",          "bed.y",
      "bed.container",  "bed.split",      "bed.beside",     "ground.present", "ground.x",
      "ground.y",       "ground.zones_x", "ground.zones_y", "ground.zones_z", "ground.ratio_x",
      "ground.ratio_y", "ground.fine_x",  "ground.fine_y",  "ground.mesh",    "ground.mesh_top"};
  static constexpr std::array placed = {"sleepers.count", "sleepers.first",  "sleepers.spacing",
                                        "sleepers.width", "sleepers.height", "sleepers.length",
                                        "sleepers.bevel", "sleepers.y",      "sleepers.model"};
  if (is_one_of(key, always)) return true;
  // Placed at the begin of the run; where plates are follows from the deck and the time.
  for (const char* table : {"stone[", "plate[", "box[", "domain."})
    if (key.starts_with(table)) return true;
  if (is_one_of(key, placed)) return holds.sleepers;
  if (key.starts_with("tamping.")) return holds.tines;
  if (holds.solids && matters_to_solids(key, holds)) return true;
  if (key.starts_with("ground.layer[") &&
      (key.ends_with("].thickness") || key.ends_with("].zones")))
    return true;
  if (key.starts_with("ground.section[") || key == "ground.embankment_layers") return true;
  if (holds.train && matters_to_train(key)) return true;
  return holds.moved_ground && matters_to_moved_ground(key, holds);
}

std::string worded(const Values& values, const std::string& key) {
  const auto found = values.find(key);
  return found == values.end() ? "without it" : "with " + found->second;
}

// All defaults, of each table those of one row.
Values defaults_of(const std::string& kind) {
  Model model;
  if (kind == "\"track\"") model.kind = ModelKind::track;
  if (kind == "\"track_on_ground\"") model.kind = ModelKind::track_on_ground;
  if (kind == "\"ground\"") model.kind = ModelKind::ground, model.pressures.resize(1);
  if (kind == "\"stones\"") {
    model.kind = ModelKind::stones;
    model.placed.stones.resize(1), model.placed.plates.resize(1), model.placed.boxes.resize(1);
  }
  model.ground.layers.resize(1), model.ground.blocks.resize(1), model.ground.solids.resize(1);
  model.ground.borders.resize(1), model.ground.sections.resize(1);
  model.track.vehicles.resize(1), model.track.line.track.zones.resize(1);
  model.track.passage.forces.resize(1);
  return values_of(effective_deck(model));
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
  // Pads that lifted off did so at once before they had a preload.
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
  const Holds holds = holds_of(checkpoint, then);
  // Keys of either deck: one that is gone differs as much as one that is new.
  Values all = now;
  all.insert(then.begin(), then.end());
  std::vector<std::string> problems;
  // All differences in one list: a user who mends one and meets the next waits in a queue each
  // time.
  for (const auto& [key, value] : all) {
    // Stones keep the number of their material: those there were must stay where they stood.
    const bool numbered =
        key.starts_with("material[") && key.ends_with("].name") && then.contains(key);
    if (!numbered && !matters(key, holds)) continue;
    const auto new_one = now.find(key), old_one = then.find(key);
    if (new_one != now.end() && old_one != then.end() && new_one->second == old_one->second)
      continue;
    problems.push_back(fmt::format("{} {}: the checkpoint {} was made {}", deck.where(key),
                                   new_one == now.end() ? "is not there" : "= " + new_one->second,
                                   path, worded(then, key)));
  }
  for (const auto& [key, sentence] : changed_files(comm, checkpoint, path, effective, deck))
    // The name of a profile may change under a train (its contact does); half a passage over each
    // of two profiles of one name is a mistake.
    if (matters(key, holds) || (holds.train && key.starts_with("irregularity")))
      problems.push_back(sentence);
  if (!problems.empty()) throw InputError(problems);
}

std::vector<std::string> changed_springs(const io::File& checkpoint, const std::string& path,
                                         const std::string& effective, const input::Deck& deck) {
  const Values then = values_of(checkpoint.text_attribute("/", "deck"));
  const Values now = values_of(effective);
  const auto of = [](const Values& values, const std::string& key) {
    const auto found = values.find(key);
    return found == values.end() ? std::string() : found->second;
  };
  std::vector<std::string> sentences;
  for (const auto& [key, value] : now) {
    if (!key.starts_with("contact[") || !key.ends_with("].k_n")) continue;
    const std::string pair = key.substr(0, key.rfind('.')), before = of(then, key);
    const bool same = of(now, pair + ".first") == of(then, pair + ".first") &&
                      of(now, pair + ".second") == of(then, pair + ".second");
    if (before.empty() || !same || before == value) continue;
    sentences.push_back(fmt::format(
        "{} = {}: the stones of {} lie with overlaps that {} made; their forces jump by the "
        "ratio, so let them settle with much damping first",
        deck.where(key), value, path, before));
  }
  return sentences;
}

std::size_t stage_after(const io::File& checkpoint, const std::string& path, const Model& model,
                        const input::Deck& deck) {
  const std::string name = checkpoint.text_attribute("/", "stage");
  const auto refuse = [&](const std::string& why) {
    throw InputError({fmt::format("{} \"{}\" was written {}", deck.where("start"), path, why)});
  };
  if (checkpoint.integer_attribute("/", "stage_finished") == 0)
    refuse(
        fmt::format("within stage \"{}\"; a run can start from the end of a stage only (or "
                    "`trackbed resume` it)",
                    name));
  // By name, not by number: the deck that goes on may have other stages before it.
  std::size_t number = 0;
  while (number < model.stages.size() && model.stages[number].name != name) ++number;
  if (number == model.stages.size())
    refuse(fmt::format("after stage \"{}\", which this deck does not have", name));
  if (number + 1 == model.stages.size())
    refuse(
        fmt::format("after stage \"{}\", the last one of this deck: nothing is left to do", name));
  return number + 1;
}

}  // namespace trackbed::app
