// A checkpoint whose program did not know all parameters yet.
#include "app/compatible.hpp"

#include <gtest/gtest.h>

#include "app/version.hpp"
#include "trackbed/core/error.hpp"
#include "unit/io/scratch.hpp"

namespace trackbed::app {
namespace {

std::string without(std::string text, const std::string& line) {
  const std::size_t at = text.find(line);
  EXPECT_NE(at, std::string::npos) << line;
  return text.erase(at, line.size());
}

TEST(Compatible, ParametersThatCameLaterHaveTheirDefaults) {
  const io::Scratch scratch("compatible");
  Model model;
  io::File file(par::Comm::self(), scratch / "older.h5", io::Mode::create);
  file.attribute("/", "deck", without(effective_deck(model), "beside = 0.0\n"));
  const input::Deck deck = input::Deck::parse("", "deck.toml", {});
  EXPECT_NO_THROW(
      require_same_model(par::Comm::self(), file, "older.h5", effective_deck(model), deck));
  model.bed.beside = 0.1;
  EXPECT_THROW(require_same_model(par::Comm::self(), file, "older.h5", effective_deck(model), deck),
               InputError);
}

}  // namespace
}  // namespace trackbed::app
