// All declarations as a tree, from which `describe`, the schema, the effective input and the list
// of all parameters are printed. Private to the module.
#pragma once

#include <string>
#include <vector>

#include "input/tree.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::input {

// Owns all its text: declarations pass views that are valid only during the visit.
struct Spec {
  // Words of ParameterInfo::kind; `section` and `list` (of sections) have parts.
  std::string name, path, kind = "section", unit = "-", meaning;
  StateParts fixed_by = state::none;
  Limits limits{};  // its `unit` must not be used: it may refer to freed text
  std::vector<std::string> choices{};
  std::size_t length = 0;     // of a list of numbers; 0: any
  Node value{};               // current value: the default
  std::vector<Spec> parts{};  // of a section; of a list: its elements, each a section

  bool is_section() const { return kind == "section"; }
  bool is_list() const { return kind == "list"; }
  // What an element of a list may hold. Requires `collect` with at_least_one_element, since the
  // list may be empty otherwise.
  const std::vector<Spec>& element() const { return parts.front().parts; }
};

// The effective deck shows lists unchanged; the reference needs one element of an empty list.
enum class Lists { as_they_are, at_least_one_element };
Spec collect(const Declaration& declaration, Lists lists);

}  // namespace trackbed::input
