// Everything declared, as a tree: what `describe`, the schema, the effective input and the list of
// all parameters are printed from. Private to the room.
#pragma once

#include <string>
#include <vector>

#include "input/tree.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::input {

// Owns all its text: declarations hand in views that end with the visit.
struct Spec {
  // Words of ParameterInfo::kind; `section` and `list` (of sections) have parts.
  std::string name, path, kind = "section", unit = "-", meaning;
  Limits limits{};  // its `unit` is not used: it may point into text that is gone
  std::vector<std::string> choices{};
  std::size_t length = 0;     // of a list of numbers; 0: any
  Node value{};               // present value: the default
  std::vector<Spec> parts{};  // of a section; of a list: its elements, each a section

  bool is_section() const { return kind == "section"; }
  bool is_list() const { return kind == "list"; }
  // What an element of a list may hold.
  // Only after `collect` with at_least_one_element: the list is else perhaps empty.
  const std::vector<Spec>& element() const { return parts.front().parts; }
};

// The effective deck shows lists as they are; the reference must show an element of an empty one.
enum class Lists { as_they_are, at_least_one_element };
Spec collect(const Declaration& declaration, Lists lists);

}  // namespace trackbed::input
