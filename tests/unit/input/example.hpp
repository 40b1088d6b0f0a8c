// A small program's parameters, one of every kind.
#pragma once

#include "trackbed/core/error.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::input {

struct Layer {
  std::string name = "layer";
  double young = 1e8;
  double depth = 1;

  void declare(Section& s) {
    s.text("name", name, "Name used by overrides.");
    s.number("young", young, {.unit = "Pa", .above = 0, .required = true}, "Young's modulus.");
    s.number("depth", depth, {.unit = "m", .above = 0, .at_most = 100}, "Thickness.");
  }
};

enum class Law { linear, hertz };

struct Contact {
  double skin = 0.002;
  double safety = 0.2;
  Law law = Law::linear;
  bool rolling = false;
  std::int64_t steps = 10;

  void declare(Section& s) {
    s.number("skin", skin, {.unit = "m", .above = 0}, "Reach of the neighbour list.");
    s.number("safety", safety, {.above = 0, .at_most = 1}, "Fraction of the critical step.");
    s.choice("law", law, {"linear", "hertz"}, "Force | overlap law.");
    s.flag("rolling", rolling, "Rolling resistance acts.");
    s.integer("steps", steps, {.at_least = 1}, "Sub-steps.");
    s.rule("safety", safety != 0.5 || steps != 7, "half the step and 7 steps cannot be combined");
  }
};

struct Example {
  std::string title;
  std::vector<double> box = {0, 1, 2}, times;
  std::vector<std::string> tags = {"a \"b\" \\ c"};
  std::string table;
  Contact dem;
  std::vector<Layer> layers;

  void declare(Section& s) {
    s.text("title", title, "Stored in every result.");
    s.numbers("box", box, {.unit = "m", .at_least = -1e300}, "Edges.", 3);
    s.numbers("times", times, {.unit = "s"}, "Sampling times.");
    s.texts("tags", tags, "Words.");
    s.file("table", table, "Loads over time.");
    s.table("dem", dem, "Stones.");
    s.tables("layer", layers, "Ground, from the top.");
  }
};

inline Declaration declaration_of(Example& example) {
  return [&example](Section& s) { example.declare(s); };
}

// The problems of a deck, or none.
inline std::vector<std::string> problems_of(const std::string& text,
                                            const std::vector<std::string>& overrides = {}) {
  Example example;
  try {
    Deck::parse(text, "deck.toml", overrides).fill(declaration_of(example));
  } catch (const InputError& error) {
    return error.problems();
  }
  return {};
}

inline Example filled(const std::string& text, const std::vector<std::string>& overrides = {}) {
  Example example;
  Deck::parse(text, "deck.toml", overrides).fill(declaration_of(example));
  return example;
}

}  // namespace trackbed::input
