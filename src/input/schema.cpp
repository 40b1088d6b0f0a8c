// JSON schema (draft 2020-12): editors complete and check a deck while it is typed.
// Rules that tie parameters together are not in it: JSON schema has no sums and products. The
// program checks them all the same.
//
// Written by the same visit as everything else; tests compare the file in docs/ with what the
// program prints.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "input/spec.hpp"

namespace trackbed::input {

namespace {

using Json = nlohmann::ordered_json;

// Defaults, in JSON's own kinds.
Json value_of(const Node& node) {
  switch (node.kind) {
    case Node::Kind::number:
      return node.number;
    case Node::Kind::integer:
      return node.integer;
    case Node::Kind::flag:
      return node.flag;
    case Node::Kind::list: {
      Json list = Json::array();
      for (const Node& item : node.items) list.push_back(value_of(item));
      return list;
    }
    default:
      return node.text;
  }
}

// `usually` is left out: JSON schema knows no warnings.
void add_limits(Json& json, const Limits& limits) {
  if (limits.above != -unbounded) json["exclusiveMinimum"] = limits.above;
  if (limits.at_least != -unbounded) json["minimum"] = limits.at_least;
  if (limits.at_most != unbounded) json["maximum"] = limits.at_most;
}

// The unit stands in the description, the only text that editors show.
Json scalar_schema(const Spec& spec) {
  Json json;
  // An integer like 1e6 is a whole number for JSON schema too.
  if (spec.kind == "number" || spec.kind == "integer") {
    json["type"] = spec.kind;
    add_limits(json, spec.limits);
  } else if (spec.kind == "flag") {
    json["type"] = "boolean";
  } else if (spec.kind == "numbers") {
    json["type"] = "array";
    json["items"] = {{"type", "number"}};
    add_limits(json["items"], spec.limits);
    if (spec.length != 0) json["minItems"] = json["maxItems"] = spec.length;
  } else if (spec.kind == "texts") {
    json["type"] = "array";
    json["items"] = {{"type", "string"}};
  } else {
    json["type"] = "string";
    if (!spec.choices.empty()) json["enum"] = spec.choices;
  }
  // A unit "-" says nothing and is left out.
  json["description"] =
      spec.unit == "-" ? spec.meaning : fmt::format("{} ({})", spec.meaning, spec.unit);
  if (!spec.limits.required) json["default"] = value_of(spec.value);
  return json;
}

Json object_schema(const std::vector<Spec>& parts);

// Sections are objects, lists of sections arrays of objects.
Json schema_of(const Spec& spec) {
  if (!spec.is_section() && !spec.is_list()) return scalar_schema(spec);
  Json json;
  if (spec.is_list()) {
    json["type"] = "array";
    json["items"] = object_schema(spec.element());
  } else {
    json = object_schema(spec.parts);
  }
  json["description"] = spec.meaning;
  return json;
}

Json object_schema(const std::vector<Spec>& parts) {
  Json json;
  json["type"] = "object";
  // As strict as the reader: an unknown key is underlined while it is typed.
  json["additionalProperties"] = false;
  json["properties"] = Json::object();
  for (const Spec& part : parts) {
    json["properties"][part.name] = schema_of(part);
    if (part.limits.required) json["required"].push_back(part.name);
  }
  return json;
}

}  // namespace

// The order of keys is that of the declarations: the file's history then shows only what changed.
std::string schema(const Declaration& declaration) {
  const Spec root = collect(declaration, Lists::at_least_one_element);
  Json json;
  json["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  json["title"] = "trackbed deck";
  json.update(object_schema(root.parts));
  return json.dump(2) + "\n";
}

}  // namespace trackbed::input
