// Values are read into the variables; every problem is reported with exactly these messages.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "unit/input/example.hpp"

namespace trackbed::input::deck_test {
namespace {

using Sentences = std::vector<std::string>;

TEST(Deck, FillsEveryKind) {
  const Example e = filled(
      "title = 'x'\nbox = [1, 2.5, -3e2]\ntimes = [0.1]\ntags = ['p', 'q']\n"
      "[dem]\nskin = 1\nlaw = 'hertz'\nrolling = true\nsteps = 1e6\n"
      "[[layer]]\nname = 'sand'\nyoung = 5e7\n[[layer]]\nyoung = 1e9\ndepth = 4\n");
  EXPECT_EQ(e.title, "x");
  EXPECT_EQ(e.box, (std::vector<double>{1, 2.5, -300}));
  EXPECT_EQ(e.times, std::vector<double>{0.1});
  EXPECT_EQ(e.tags, (Sentences{"p", "q"}));
  EXPECT_EQ(e.dem.skin, 1);
  EXPECT_EQ(e.dem.safety, 0.2);  // default
  EXPECT_EQ(e.dem.law, Law::hertz);
  EXPECT_TRUE(e.dem.rolling);
  EXPECT_EQ(e.dem.steps, 1000000);
  ASSERT_EQ(e.layers.size(), 2U);
  EXPECT_EQ(e.layers[0].name, "sand");
  EXPECT_EQ(e.layers[1].young, 1e9);
  EXPECT_EQ(e.layers[1].depth, 4);
}

TEST(Deck, ReportsAllProblemsAtOnceInTheOrderOfTheFile) {
  EXPECT_EQ(problems_of("box = [1, 2]\n"
                        "[dem]\n"
                        "skn = 0.1\n"
                        "safety = 'high'\n"
                        "law = 'hetrz'\n"
                        "rolling = 1\n"
                        "steps = 0\n"
                        "[[layer]]\n"
                        "depth = 200\n"
                        "[[layer]]\n"
                        "young = -5.0\n"
                        "[loda]\n"
                        "table = 5\n"),
            (Sentences{
                "deck.toml:1: box = [1, 2] must be a list of 3 numbers, not of 2",
                "deck.toml:3: dem.skn is not a parameter; did you mean dem.skin?",
                "deck.toml:4: dem.safety = \"high\" must be a number",
                "deck.toml:5: dem.law = \"hetrz\" must be \"linear\" or \"hertz\"; did you mean "
                "hertz?",
                "deck.toml:6: dem.rolling = 1 must be true or false",
                "deck.toml:7: dem.steps = 0 must be at least 1",
                "deck.toml:8: layer[0].young must be given (in Pa)",
                "deck.toml:9: layer[0].depth = 200 must be above 0 and at most 100 m",
                "deck.toml:11: layer[1].young = -5 must be above 0 Pa",
                "deck.toml:12: loda is not a section",
            }));
}

TEST(Deck, ReportsWhatAValueMustBe) {
  EXPECT_EQ(problems_of("title = 5\ntags = ['a', 1]\nbox = 3\ntimes = [1, 'x']\ntable = 1\n"
                        "dem = 7\nlayer = [1, 2]\n"),
            (Sentences{
                "deck.toml:1: title = 5 must be text (in quotes)",
                "deck.toml:2: tags = [\"a\", 1] must be a list of texts (each in quotes)",
                "deck.toml:3: box = 3 must be a list of 3 numbers",
                "deck.toml:4: times[1] = \"x\" must be a number",
                "deck.toml:5: table = 1 must be the name of a file (in quotes)",
                "deck.toml:6: dem = 7 must be a section, [dem]",
                "deck.toml:7: layer = [1, 2] must be a list of sections, each starting with "
                "[[layer]]",
            }));
  EXPECT_EQ(problems_of("[dem]\nskin = nan\nsafety = inf\nsteps = 1.5\n[dem.law]\nx = 1\n"),
            (Sentences{
                "deck.toml:2: dem.skin = nan must be a finite number",
                "deck.toml:3: dem.safety = inf must be a finite number",
                "deck.toml:4: dem.steps = 1.5 must be a whole number",
                "deck.toml:5: dem.law = {...} must be \"linear\" or \"hertz\"",
            }));
  EXPECT_EQ(problems_of("[dem]\nskin = '5 mm'\nsafety = '0.5'\nlaw = 2020-01-01\n"),
            (Sentences{
                "deck.toml:2: dem.skin = \"5 mm\" must be a number; give a number in m: 0.005",
                "deck.toml:3: dem.safety = \"0.5\" must be a number; give a number without quotes",
                "deck.toml:4: dem.law = 2020-01-01 must be \"linear\" or \"hertz\" (in quotes)",
            }));
  // As it was written, whatever TOML makes of it and precedes it in the line.
  EXPECT_EQ(problems_of("[dem]\nlaw = 60E2\n"),
            Sentences{"deck.toml:2: dem.law = 60E2 must be \"linear\" or \"hertz\" (in quotes)"});
  EXPECT_EQ(
      problems_of("dem = {'\u00e9' = 1, law = 6_0}  # 7\n"),
      (Sentences{"deck.toml:1: dem.law = 6_0 must be \"linear\" or \"hertz\" (in quotes)",
                 "deck.toml:1: dem.\u00e9 is not a parameter; `trackbed describe dem` lists those "
                 "of this section"}));
  EXPECT_EQ(problems_of("", {"dem.law=60E2"}),
            Sentences{"command line: dem.law = 60E2 must be \"linear\" or \"hertz\""});
}

// Within the limits of the parameter, but outside of the range of usable magnitudes: rejected.
TEST(Deck, RejectsUnusableMagnitudes) {
  EXPECT_EQ(
      problems_of("box = [1, -1e300, 1e-300]\n[dem]\nskin = 1e25\n"
                  "[[layer]]\nyoung = 1e25\n"),
      (Sentences{
          "deck.toml:1: box[1] = -1e+300 is too large for this program, whose sums and "
          "products would lose digits or overflow; its magnitude must be at most 1e+06 m",
          "deck.toml:1: box[2] = 1e-300 is too small for this program, whose sums and "
          "products would lose digits or overflow; its magnitude must be at least 1e-25 m, or 0",
          "deck.toml:3: dem.skin = 1e+25 is too large for this program, whose sums and "
          "products would lose digits or overflow; its magnitude must be at most 1e+06 m",
          "deck.toml:5: layer[0].young = 1e+25 is too large for this program, whose sums and "
          "products would lose digits or overflow; its magnitude must be at most 1e+15 Pa",
      }));
  EXPECT_EQ(problems_of("box = [1, -1e6, 1e-12]\n"), Sentences{});
}

TEST(Deck, FindsTheNearestNameElsewhereIfNoneIsNear) {
  EXPECT_EQ(problems_of("skin = 1\nyuong = 2\nnothing_like_it = 3\n[dem]\ntitel = \"a\"\n"),
            (Sentences{
                "deck.toml:1: skin is not a parameter; did you mean dem.skin?",
                "deck.toml:2: yuong is not a parameter; did you mean layer[].young?",
                "deck.toml:3: nothing_like_it is not a parameter",
                "deck.toml:5: dem.titel is not a parameter; did you mean title at the top of the "
                "deck?",
            }));
}

// The same name in sections that the deck lacks is no suggestion, in lists of the section it is
// one.
TEST(Deck, SuggestsNoParametersOfSectionsThatAreMissing) {
  EXPECT_EQ(problems_of("[dem]\nyoung = 2\n"),
            (Sentences{"deck.toml:2: dem.young is not a parameter; `trackbed describe young` lists "
                       "other parameters of this name"}));
  EXPECT_EQ(problems_of("[dem]\nyoung = 2\n[[layer]]\nyoung = 1\n"),
            (Sentences{"deck.toml:2: dem.young is not a parameter; did you mean layer[].young?"}));
}

// A name of four letters is similar to some name of any section.
TEST(Deck, SuggestsNoNamesOfOtherSectionsForShortOnes) {
  EXPECT_EQ(problems_of("[dem]\ntitl = 2\n"),
            (Sentences{"deck.toml:2: dem.titl is not a parameter; `trackbed describe dem` lists "
                       "those of this section"}));
}

TEST(Deck, ExplainsLinesThatAreNotToml) {
  const auto ends_with = [](const std::string& deck, const std::string& hint) {
    const Sentences found = problems_of(deck);
    ASSERT_EQ(found.size(), 1U) << deck;
    EXPECT_TRUE(found[0].ends_with(hint)) << found[0];
    EXPECT_TRUE(found[0].starts_with("deck.toml:2: ")) << found[0];
  };
  ends_with("[dem]\nskin = 0,002\n", "; decimals are written with a point");
  ends_with("[dem]\nskin = 2 mm  # of stones\n",
            "; give the number alone, in the unit that `trackbed describe skin` states");
  ends_with("[[layer]]\n[layer]\nyoung = 2\n",
            "; the tables of a list have two brackets, such as [[material]]");
}

TEST(Deck, LocatesSentencesThatBeginWithAKey) {
  const Deck deck = Deck::parse("title = 'a'\n[dem]\nskin = 1\n", "deck.toml");
  EXPECT_EQ(deck.located("dem.skin: is odd"), "deck.toml:3: dem.skin: is odd");
  EXPECT_EQ(deck.located("dem has 3 stones"), "deck.toml:2: dem has 3 stones");
  EXPECT_EQ(deck.located("dem.law is odd"), "deck.toml: dem.law is odd");
  EXPECT_EQ(deck.located("the bed is odd"), "the bed is odd");
  EXPECT_EQ(deck.located(""), "");
}

TEST(Deck, ReportsSyntaxErrorsWithTheirLine) {
  const auto start = [](const std::string& text) {
    const Sentences problems = problems_of(text);
    return problems.size() == 1 ? problems[0].substr(0, problems[0].find(' ')) : "other";
  };
  EXPECT_EQ(start("title = 'a'\n[dem\n"), "deck.toml:2:");
  EXPECT_EQ(start("title = 'a'\n\ntitle = 'b'\n"), "deck.toml:3:");
  EXPECT_EQ(start("[dem]\nsteps = 99999999999999999999\n"), "deck.toml:2:");
}

TEST(Deck, TakesOverrides) {
  const std::string text =
      "[dem]\nskin = 1\n[[layer]]\nname = 'sand'\nyoung = 1\n[[layer]]\nname = 'clay'\nyoung = 2\n";
  const Example e =
      filled(text, {"dem.skin=2.5", "dem.law=hertz", "title = two words ", "layer.clay.young=7",
                    "layer.0.depth=3", "layer[1].depth=4", "box=[4,5,6]", "box.1=9", "times=[]"});
  EXPECT_EQ(e.dem.skin, 2.5);
  EXPECT_EQ(e.dem.law, Law::hertz);
  EXPECT_EQ(e.title, "two words");
  EXPECT_EQ(e.layers[1].young, 7);
  EXPECT_EQ(e.layers[0].depth, 3);
  EXPECT_EQ(e.layers[1].depth, 4);
  EXPECT_EQ(e.box, (std::vector<double>{4, 9, 6}));
  EXPECT_EQ(filled("", {"dem.skin=3"}).dem.skin, 3);    // creates the section
  EXPECT_EQ(filled("", {"title=60E1"}).title, "60E1");  // a number in a deck
}

TEST(Deck, ReportsWhatIsWrongOnTheCommandLine) {
  EXPECT_EQ(problems_of("titel = 'a'\n[[layer]]\nname = 'sand'\nyoung = 1\n",
                        {"dem.safety=high", "dem.skn=1", "layer.clay.young=2", "layer.1.young=2",
                         "nonsense", "dem.safety.x=1", "layer.sand.depth=-1", "=3", "dm.skin=1"}),
            (Sentences{
                "deck.toml:1: titel is not a parameter; did you mean title?",
                "command line: layer.clay.young: the list has no element clay; its elements: sand",
                "command line: layer.1.young: the list has no element 1; its elements: sand",
                "command line: \"nonsense\" must have the form key=value",
                "command line: dem.safety.x: dem.safety is a value, not a section",
                "command line: \"\" is not the name of a parameter",
                "command line: dem.safety = \"high\" must be a number",
                "command line: dem.skn is not a parameter; did you mean dem.skin?",
                "command line: layer[0].depth = -1 must be above 0 and at most 100 m",
                "command line: dm is not a section; did you mean dem?",
            }));
}

TEST(Deck, ChecksRulesWhenTheValuesAreGood) {
  EXPECT_EQ(problems_of("[dem]\nsteps = 7\nsafety = 0.5\n"),
            Sentences{"deck.toml:3: dem.safety = 0.5: half the step and 7 steps cannot be "
                      "combined"});
  EXPECT_EQ(problems_of("[dem]\nskin = -1\nsteps = 7\nsafety = 0.5\n"),
            Sentences{"deck.toml:2: dem.skin = -1 must be above 0 m"});
}

// Rules across sections: the line is that of the named value, or of its section if it is not given.
TEST(Deck, ChecksRulesAcrossSections) {
  struct Two {
    Example example;
    void declare(Section& s) {
      example.declare(s);
      const auto& layers = example.layers;
      s.rule("layer[0].depth", layers.empty() || layers[0].depth > example.dem.skin, "is too thin",
             {.reads = {"layer[0].depth", "dem.skin"}});
      s.rule("dem.steps", example.dem.steps < 1000, "are many",
             {.severity = Severity::warning, .reads = {"dem"}});
    }
  };
  const auto problems = [](const std::string& text) {
    Two two;
    try {
      return Deck::parse(text, "deck.toml").fill([&](Section& s) { two.declare(s); });
    } catch (const InputError& error) {
      return error.problems();
    }
  };
  EXPECT_EQ(problems("box = 1\n[dem]\nskin = 5\n[[layer]]\nyoung = 1\ndepth = 4\n"),
            (Sentences{"deck.toml:1: box = 1 must be a list of 3 numbers",
                       "deck.toml:6: layer[0].depth = 4: is too thin"}));
  EXPECT_EQ(problems("[dem]\nskin = 5\n[[layer]]\nyoung = 1\n"),
            Sentences{"deck.toml:3: layer[0].depth = 1.0 (default): is too thin"});
  EXPECT_EQ(problems("[dem]\nskin = 5\n[[layer]]\nyoung = 1\ndepth = -4\n"),
            Sentences{"deck.toml:5: layer[0].depth = -4 must be above 0 and at most 100 m"});
  // Rules that use parameters of a rejected section are skipped.
  EXPECT_EQ(problems("dem = 5\n[[layer]]\nyoung = 1\ndepth = 0.001\n"),
            Sentences{"deck.toml:1: dem = 5 must be a section, [dem]"});
  EXPECT_EQ(problems("[dem]\nsteps = 1000\n"),
            Sentences{"deck.toml:2: dem.steps = 1000: are many"});
  EXPECT_EQ(problems("[dem]\nsteps = 1000\nskin = -1\n"),
            Sentences{"deck.toml:3: dem.skin = -1 must be above 0 m"});
}

TEST(Deck, FindsFilesBesideTheDeck) {
  namespace fs = std::filesystem;
  const par::Comm world = par::Comm::world();
  const fs::path folder = fs::path("deck_files_" + std::to_string(world.size()));
  if (world.root()) {
    fs::create_directories(folder);
    std::ofstream(folder / "a.csv") << "x\n";
    std::ofstream(folder / "deck.toml") << "table = 'a.csv'\n";
    std::ofstream(folder / "wrong.toml") << "\ntable = 'b.csv'\n";
  }
  world.barrier();
  Example e;
  const Deck deck = Deck::read(world, folder / "deck.toml", {});
  deck.fill(declaration_of(e));
  EXPECT_EQ(e.table, fs::absolute(folder / "a.csv").string());
  const auto sentence = [&](const std::string& file, const Sentences& overrides) -> std::string {
    try {
      Deck::read(world, folder / file, overrides).fill(declaration_of(e));
    } catch (const InputError& error) {
      return error.what();
    }
    return "no problem";
  };
  EXPECT_EQ(sentence("wrong.toml", {}),
            (folder / "wrong.toml").string() +
                ":2: table \"b.csv\" does not exist (names in a deck are relative to the folder of "
                "the deck, on the command line to the working directory)");
  EXPECT_EQ(sentence("deck.toml", {"table=."}), "command line: table \".\" is not a file");
  EXPECT_EQ(sentence("none.toml", {}), (folder / "none.toml").string() + ": does not exist");
  world.barrier();
  if (world.root()) fs::remove_all(folder);
}

TEST(Deck, GivesTheLocationOfAParameter) {
  const Deck deck = Deck::parse("[dem]\nskin = 1\n[[layer]]\nname = 'sand'\nyoung = 1\n",
                                "deck.toml", {"dem.safety=1"});
  EXPECT_EQ(deck.where("dem.skin"), "deck.toml:2: dem.skin");
  EXPECT_EQ(deck.where("layer[0].young"), "deck.toml:5: layer[0].young");
  EXPECT_EQ(deck.where("layer.sand.young"), "deck.toml:5: layer.sand.young");
  EXPECT_EQ(deck.where("dem.safety"), "command line: dem.safety");
  EXPECT_EQ(deck.where("dem.steps"), "deck.toml: dem.steps");
  EXPECT_EQ(deck.where("layer[4].young"), "deck.toml: layer[4].young");
}

TEST(Nearest, CountsSwapsAndReturnsNothingIfNoNameIsNear) {
  EXPECT_EQ(nearest("yuong", {"depth", "young"}), "young");
  EXPECT_EQ(nearest("Skin", {"span", "skin"}), "skin");
  EXPECT_EQ(nearest("skn", {"law", "skin"}), "skin");
  EXPECT_EQ(nearest("pressure", {"law", "skin"}), "");
  EXPECT_EQ(nearest("x", {"y", "z"}), "");
  EXPECT_EQ(nearest("", {"y"}), "");
}

}  // namespace
}  // namespace trackbed::input::deck_test
