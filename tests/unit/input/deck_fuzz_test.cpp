// Any text is either read or rejected with messages. Effective input reads back bitwise identical.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "unit/input/example.hpp"

namespace trackbed::input::deck_fuzz_test {
namespace {

const char* const valid =
    "title = 'x'\nbox = [1, 2.5, -3e2]\ntimes = [0.1]\ntags = ['p', \"q\"]\n\n"
    "[dem]\nskin = 0.001 # m\nlaw = 'hertz'\nrolling = true\nsteps = 1e6\nsafety = 0.5\n\n"
    "[[layer]]\nname = 'sand'\nyoung = 5e7\n\n[[layer]]\nyoung = 1e9\ndepth = 4\n";

class Mutator {
 public:
  std::string mutate(std::string text) {
    const std::size_t edits = 1 + below(4);
    for (std::size_t i = 0; i < edits && !text.empty(); ++i) edit(text);
    return text;
  }

 private:
  std::size_t below(std::size_t n) { return random_() % n; }
  void edit(std::string& text) {
    static const std::vector<std::string> tokens = {
        "[",     "]",          "[[",       "]]",
        "=",     "\"",         "'",        "\n",
        ".",     "nan",        "-inf",     "1e999",
        "0x7f",  "true",       "{}",       "{a=1}",
        "[[1]]", "#",          "\\",       "\0",
        "'''",   "1_000",      "-",        "+",
        "layer", "dem",        "12:30:00", ",",
        "é",     "2020-01-01", "[dem.a]",  "99999999999999999999"};
    const std::size_t at = below(text.size());
    const std::size_t line_begin = text.rfind('\n', at) + 1;
    const std::size_t line_end = std::min(text.find('\n', line_begin), text.size() - 1);
    switch (below(6)) {
      case 0:
        text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text.erase(at, 1 + below(5));
        break;
      case 2:
        text.insert(at, tokens[below(tokens.size())]);
        break;
      case 3:
        if (line_end >= line_begin) text.erase(line_begin, line_end - line_begin + 1);
        break;
      case 4:
        if (line_end >= line_begin)
          text.insert(line_begin, text.substr(line_begin, line_end - line_begin + 1));
        break;
      default:
        text.resize(at);
    }
  }
  std::mt19937_64 random_{20240607};
};

TEST(DeckFuzz, ReadsOrRejectsAnyText) {
  Mutator mutator;
  int read = 0, rejected = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::string text = mutator.mutate(valid);
    try {
      filled(text);
      ++read;
    } catch (const InputError& error) {
      ++rejected;
      ASSERT_FALSE(error.problems().empty());
      for (const std::string& problem : error.problems())
        EXPECT_EQ(problem.substr(0, 10), "deck.toml:") << text;
    }
  }
  // Both outcomes occur.
  EXPECT_GT(read, 100);
  EXPECT_GT(rejected, 500);
}

TEST(DeckFuzz, ReadsOrRejectsAnyOverride) {
  Mutator mutator;
  for (int i = 0; i < 2000; ++i) {
    const std::string text = mutator.mutate("layer.sand.young=[1.5, 'a', {b = 2}]");
    EXPECT_NO_THROW(problems_of(valid, {text})) << text;
  }
}

// Any mantissa and sign, with a magnitude that is allowed for all units.
double any_number(std::mt19937_64& random) {
  const double mantissa = std::bit_cast<double>((random() >> 12) | 0x3ff0000000000000);
  const int exponent = static_cast<int>(random() % 26) - 9;
  return (random() % 2 == 0 ? 1 : -1) * std::ldexp(mantissa, exponent);
}

TEST(Effective, ReadsBackBitwiseIdentical) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 500; ++i) {
    Example e;
    e.title = "line\nbreak \"quoted\" \\ \t \x01 \x7f é";
    e.box = {any_number(random), -0.0, 1e-12};
    e.times.resize(random() % 20);
    for (double& time : e.times) time = any_number(random);
    e.dem.skin = std::abs(any_number(random));
    e.dem.steps = static_cast<std::int64_t>(random() >> 1) | 1;
    e.dem.law = random() % 2 ? Law::hertz : Law::linear;
    e.layers.resize(random() % 3);
    for (Layer& layer : e.layers) layer.young = std::abs(any_number(random));
    const std::string text = effective(declaration_of(e));
    Example back;
    back.layers.resize(1);  // the program's own list must be replaced by an empty one
    Deck::parse(text, "effective", {}).fill(declaration_of(back));
    ASSERT_EQ(effective(declaration_of(back)), text);
    const auto bits = [](const std::vector<double>& values) {
      std::vector<std::uint64_t> list;
      for (const double value : values) list.push_back(std::bit_cast<std::uint64_t>(value));
      return list;
    };
    ASSERT_EQ(bits(back.box), bits(e.box)) << text;
    ASSERT_EQ(bits(back.times), bits(e.times)) << text;
    ASSERT_EQ(back.dem.skin, e.dem.skin);
    ASSERT_EQ(back.dem.steps, e.dem.steps);
    ASSERT_EQ(back.dem.law, e.dem.law);
    ASSERT_EQ(back.title, e.title);
    ASSERT_EQ(back.tags, e.tags);
    ASSERT_EQ(back.layers.size(), e.layers.size());
    for (std::size_t k = 0; k < e.layers.size(); ++k)
      ASSERT_EQ(back.layers[k].young, e.layers[k].young);
  }
}

}  // namespace
}  // namespace trackbed::input::deck_fuzz_test
