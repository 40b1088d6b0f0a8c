// The reference, the schema and the list of parameters come from the same declaration.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "unit/input/example.hpp"

namespace trackbed::input::reference_test {
namespace {

std::vector<std::string> paths() {
  Example e;
  std::vector<std::string> list;
  for (const ParameterInfo& parameter : all_parameters(declaration_of(e)))
    list.push_back(parameter.path);
  return list;
}

TEST(Reference, ListsAllParameters) {
  EXPECT_EQ(paths(), (std::vector<std::string>{"title", "box", "times", "tags", "table", "dem.skin",
                                               "dem.safety", "dem.law", "dem.rolling", "dem.steps",
                                               "layer[].name", "layer[].young", "layer[].depth"}));
}

TEST(Reference, DescribesAllParameters) {
  Example e;
  const std::string text = describe(declaration_of(e), "all");
  for (const std::string& path : paths()) {
    const std::string row = "\n| `" + path.substr(path.rfind('.') + 1) + "` |";
    EXPECT_NE(text.find(row), std::string::npos) << row;
  }
  EXPECT_NE(text.find("| `skin` | number | m | `0.002` | above 0 | Reach of the neighbour list. |"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("| Force \\| overlap law. |"), std::string::npos) << text;
  EXPECT_NE(text.find("## `[[layer]]`\n\nGround, from the top.\n"), std::string::npos) << text;
  EXPECT_TRUE(e.layers.empty());  // describing changes nothing
}

TEST(Reference, ListsTheSections) {
  Example e;
  const std::string text = describe(declaration_of(e));
  EXPECT_EQ(text.find("[dem]  "), 0U) << text;
  EXPECT_NE(text.find("\n[[layer]]                    Ground, from the top.\n"), std::string::npos)
      << text;
  EXPECT_EQ(text.find("skin"), std::string::npos) << text;
}

TEST(Reference, DescribesOneSection) {
  Example e;
  EXPECT_EQ(describe(declaration_of(e), "layer"),
            "[[layer]]\n  Ground, from the top.\n"
            "\n  name = \"layer\"\n      text\n      Name used by overrides.\n"
            "\n  young = must be given Pa\n      number, above 0\n      Young's modulus.\n"
            "\n  depth = 1.0 m\n      number, above 0 and at most 100\n      Thickness.\n");
  EXPECT_NE(describe(declaration_of(e), "dem.skin").find("skin = 0.002 m"), std::string::npos);
  EXPECT_EQ(describe(declaration_of(e), "Thick"),
            "\"Thick\" occurs in\n  layer.depth (m): Thickness.\n");
  try {
    describe(declaration_of(e), "dme");
    ADD_FAILURE() << "an unknown section was described";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "dme is not a section or parameter; did you mean dem?");
  }
}

TEST(Reference, SchemaHoldsAllParameters) {
  Example e;
  const auto json = nlohmann::json::parse(schema(declaration_of(e)));
  EXPECT_EQ(json["$schema"], "https://json-schema.org/draft/2020-12/schema");
  EXPECT_EQ(json["additionalProperties"], false);
  for (std::string path : paths()) {
    std::string pointer = "/properties/";
    for (const char c : path) pointer += c == '.' ? "/properties/" : std::string(1, c);
    if (const auto at = pointer.find("[]"); at != std::string::npos)
      pointer.replace(at, 2, "/items");
    EXPECT_TRUE(json.contains(nlohmann::json::json_pointer(pointer))) << pointer;
  }
  const auto& skin = json["properties"]["dem"]["properties"]["skin"];
  EXPECT_EQ(skin["type"], "number");
  EXPECT_EQ(skin["exclusiveMinimum"], 0);
  EXPECT_EQ(skin["default"], 0.002);
  EXPECT_EQ(skin["description"], "Reach of the neighbour list. (m)");
  EXPECT_EQ(json["properties"]["box"]["minItems"], 3);
  EXPECT_EQ(json["properties"]["dem"]["properties"]["law"]["enum"],
            (nlohmann::json{"linear", "hertz"}));
  EXPECT_EQ(json["properties"]["layer"]["items"]["required"], nlohmann::json{"young"});
}

}  // namespace
}  // namespace trackbed::input::reference_test
