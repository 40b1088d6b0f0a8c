// Checkpoints of older programs that did not have all parameters.
#include "app/restart/compatible.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "trackbed/core/error.hpp"
#include "trackbed/model/effective.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::app::compatible_test {
namespace {

std::string without(std::string text, const std::string& line) {
  const std::size_t at = text.find(line);
  EXPECT_NE(at, std::string::npos) << line;
  return text.erase(at, line.size());
}

TEST(Compatible, ParametersAddedLaterHaveTheirDefaults) {
  const io::Scratch scratch("compatible");
  model::Model model;
  io::File file(par::Comm::self(), scratch / "older.h5", io::Mode::create);
  file.attribute("/", "deck", without(model::effective_deck(model), "beside = 0.0\n"));
  const input::Deck deck = input::Deck::parse("", "deck.toml", {});
  EXPECT_NO_THROW(require_same_model(par::Comm::self(), file, "older.h5", model, deck));
  model.bed.beside = 0.1;
  EXPECT_THROW(require_same_model(par::Comm::self(), file, "older.h5", model, deck), InputError);
}

// Parameters of an existing row; a new row makes another deck.
TEST(Compatible, ParametersAddedToRowsHaveTheirDefaults) {
  const io::Scratch scratch("rows");
  model::Model model;
  model.ground.solids = {{"soil", {}}};
  io::File file(par::Comm::self(), scratch / "older.h5", io::Mode::create);
  file.attribute("/", "deck", without(model::effective_deck(model), "yield = \"none\"\n"));
  const Values now = values_of(model::effective_deck(model));
  ASSERT_TRUE(now.contains("ground.solid[0].yield"));
  EXPECT_EQ(stored_values(file, now).at("ground.solid[0].yield"), "\"none\"");
  model.ground.solids.push_back({"sand", {}});
  EXPECT_FALSE(stored_values(file, values_of(model::effective_deck(model)))
                   .contains("ground.solid[1].yield"));
}

// Pads with uplift had no preload, unlike the present default.
TEST(Compatible, PadsWithUpliftHadNoPreload) {
  const io::Scratch scratch("preload");
  model::Model model;
  model.kind = model::ModelKind::track;
  for (const bool uplift : {false, true}) {
    model.track.line.pad.uplift = uplift;
    const std::string path = scratch / (uplift ? "lifts.h5" : "pulls.h5");
    io::File file(par::Comm::self(), path, io::Mode::create);
    file.attribute("/", "deck", without(model::effective_deck(model), "preload = -1.0\n"));
    const Values now = values_of(model::effective_deck(model));
    EXPECT_EQ(stored_values(file, now).at("pad.preload"), uplift ? "0.0" : "-1.0");
  }
}

model::Model model_with_rows(model::ModelKind kind) {
  model::Model model;
  model.kind = kind;
  model.physics.materials.resize(1), model.physics.laws.resize(1);
  model.pressures.resize(1), model.stages.resize(1), model.regions.resize(1);
  model.sensors.resize(1);
  model.placed.stones.resize(2), model.placed.plates.resize(1), model.placed.boxes.resize(1);
  model.bed.layers.resize(2);
  model.ground.layers.resize(1), model.ground.blocks.resize(1), model.ground.solids.resize(1);
  model.ground.borders.resize(1), model.ground.sections.resize(1);
  model.track.vehicles.resize(1), model.track.line.track.zones.resize(1);
  model.track.passage.forces.resize(1);
  model.bonds.resize(1);
  return model;
}

// A key of a deck is the path of its parameter with the numbers of rows, also in tables of rows:
// otherwise it would not be known what fixes it.
TEST(Compatible, EveryKeyOfADeckIsAParameter) {
  for (const auto kind : {model::ModelKind::bed, model::ModelKind::track, model::ModelKind::ground,
                          model::ModelKind::track_on_ground, model::ModelKind::stones}) {
    model::Model model = model_with_rows(kind);
    std::set<std::string> paths;
    for (const auto& parameter : input::all_parameters(model::declaration_of(model)))
      paths.insert(parameter.path);
    const Values values = values_of(model::effective_deck(model));
    EXPECT_GT(values.size(), 100u);
    for (const auto& [key, value] : values)
      EXPECT_TRUE(paths.contains(std::regex_replace(key, std::regex("\\[[0-9]+\\]"), "[]"))) << key;
  }
}

TEST(Compatible, TablesOfRowsAreNumbered) {
  model::Model model = model_with_rows(model::ModelKind::stones);
  model.placed.stones[0].polyhedron.vertices = 11;
  const Values values = values_of(model::effective_deck(model));
  EXPECT_EQ(values.at("stone[0].polyhedron.vertices"), "11");
  EXPECT_NE(values.at("stone[1].polyhedron.vertices"), "11");
}

// The states of which the checkpoint contains a part fix parameters, and only they.
TEST(Compatible, PartsOfTheStateFixParameters) {
  const io::Scratch scratch("parts");
  const input::Deck deck = input::Deck::parse("", "deck.toml", {});
  const auto refuses = [&](const char* part, const auto& change) {
    model::Model model = model_with_rows(model::ModelKind::bed);
    const std::string path = scratch / (std::string("of_") + (*part == 0 ? "none" : part) + ".h5");
    io::File file(par::Comm::self(), path, io::Mode::create);
    file.attribute("/", "deck", model::effective_deck(model));
    if (*part != 0) file.attribute(part, "steps", std::int64_t{0});  // creates the group
    change(model);
    try {
      EXPECT_FALSE(require_same_model(par::Comm::self(), file, path, model, deck));
    } catch (const InputError&) {
      return true;
    }
    return false;
  };
  const auto young = [](model::Model& m) { m.ground.layers[0].solid.young *= 2; };
  EXPECT_FALSE(refuses("", young));
  EXPECT_TRUE(refuses("ground", young));
  const auto damping = [](model::Model& m) { m.ground.layers[0].solid.rayleigh_mass = 3; };
  EXPECT_FALSE(refuses("ground", damping));
  const auto thickness = [](model::Model& m) { m.ground.layers[0].thickness *= 2; };
  EXPECT_TRUE(refuses("", thickness));
  const auto spacing = [](model::Model& m) { m.sleepers.spacing += 0.01; };
  EXPECT_FALSE(refuses("", spacing));
  EXPECT_TRUE(refuses("sleepers", spacing));
  const auto pad = [](model::Model& m) { m.track.line.pad.damping *= 2; };
  EXPECT_FALSE(refuses("sleepers", pad));
  EXPECT_TRUE(refuses("train", pad));
  const auto tine = [](model::Model& m) { m.tamping.depth += 0.01; };
  EXPECT_FALSE(refuses("", tine));
  EXPECT_TRUE(refuses("tines", tine));
  const auto renamed = [](model::Model& m) { m.physics.materials[0].name = "other"; };
  EXPECT_TRUE(refuses("", renamed));
  const auto added = [](model::Model& m) { m.physics.materials.resize(2); };
  EXPECT_FALSE(refuses("", added));
}

}  // namespace
}  // namespace trackbed::app::compatible_test
