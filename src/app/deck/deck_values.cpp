#include "app/deck/deck_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace trackbed::app {

namespace {

constexpr std::array of_no_effect = {"title",
                                     "passage.duration",
                                     "output.wall_time",
                                     "output.stop_after",
                                     "output.checkpoint_interval",
                                     "output.checkpoint_wall_interval"};

bool has_effect(const std::string& key) {
  return std::find(of_no_effect.begin(), of_no_effect.end(), key) == of_no_effect.end();
}

}  // namespace

// Both are decks of the same stages and tables: keys of one are those of the other.
std::vector<std::string> changes(const Values& before, const Values& now) {
  std::vector<std::string> sentences;
  for (const auto& [key, value] : now) {
    const auto old = before.find(key);
    if (old == before.end() || old->second == value || !has_effect(key)) continue;
    sentences.push_back(fmt::format("{} = {} (previously {})", key, value, old->second));
  }
  return sentences;
}

std::vector<std::string> changes_without_effect(const Values& before, const Values& now) {
  std::vector<std::string> overrides;
  for (const auto& [key, value] : now)
    if (const auto old = before.find(key);
        old != before.end() && old->second != value && !has_effect(key))
      overrides.push_back(key + "=" + value);
  return overrides;
}

}  // namespace trackbed::app
