#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trackbed/model/checks.hpp"

namespace trackbed::model {

// Only of what an engineer would look for in a deck of his own: numerical parameters are mostly
// left at their defaults on purpose.
std::string words_of_defaults(const Model& model, const input::Deck& deck) {
  const track::TrainParameters& train = model.track.train;
  const bool on_stages = model.has_stages();
  if (on_stages && !model.has_train()) return "";
  std::vector<std::string> words;
  const auto add = [&](const char* key, const std::string& value) {
    if (!deck.sets(key)) words.push_back(fmt::format("{}{}", key, value));
  };
  if (model.track.passage.loaded_by == track::LoadedBy::train) {
    if (!train.vehicles.empty())
      add("train.vehicles", fmt::format(" = [{}]", fmt::join(train.vehicles, ", ")));
    add("train.speed", fmt::format(" = {:g} m/s ({:g} km/h)", train.speed, 3.6 * train.speed));
  }
  for (const char* section : {"track", "rail", "pad", "ballast"})
    if (!deck.sets(section)) words.push_back(fmt::format("[{}]", section));
  if (on_stages) add("seat.before", fmt::format(" = {}", model.seat.before));
  if (words.empty()) return "";
  return fmt::format("not in the deck, defaults are used: {} (`trackbed describe SECTION`)",
                     fmt::join(words, ", "));
}

}  // namespace trackbed::model
