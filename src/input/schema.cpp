// JSON schema (draft 2020-12): editors use it to complete and check a deck.
// Rules that relate several parameters are not in it, since JSON schema has no arithmetic; the
// program checks them.
//
// Written by the same visit as the other outputs; tests compare the file in docs/ with the
// program's output.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "input/spec.hpp"

namespace trackbed::input {

namespace {

using Json = nlohmann::ordered_json;

// Defaults as JSON values.
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

// `usually` is left out: JSON schema has no warnings.
void add_limits(Json& json, const Limits& limits) {
  if (limits.above != -unbounded) json["exclusiveMinimum"] = limits.above;
  if (limits.at_least != -unbounded) json["minimum"] = limits.at_least;
  if (limits.at_most != unbounded) json["maximum"] = limits.at_most;
}

// The unit is part of the description, the only text that editors show.
Json scalar_schema(const Spec& spec) {
  Json json;
  // JSON schema too accepts 1e6 as an integer.
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
  // The unit "-" is left out.
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
  // As strict as the reader: editors mark an unknown key.
  json["additionalProperties"] = false;
  json["properties"] = Json::object();
  for (const Spec& part : parts) {
    json["properties"][part.name] = schema_of(part);
    if (part.limits.required) json["required"].push_back(part.name);
  }
  return json;
}

}  // namespace

// Keys have the order of the declarations, so that differences between versions stay small.
std::string schema(const Declaration& declaration) {
  const Spec root = collect(declaration, Lists::at_least_one_element);
  Json json;
  json["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  json["title"] = "trackbed deck";
  json.update(object_schema(root.parts));
  return json.dump(2) + "\n";
}

}  // namespace trackbed::input
