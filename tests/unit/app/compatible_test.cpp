// Checkpoints of older programs that did not have all parameters.
#include "app/restart/compatible.hpp"

#include <gtest/gtest.h>

#include "trackbed/core/error.hpp"
#include "trackbed/model/effective.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::app {
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

}  // namespace
}  // namespace trackbed::app
