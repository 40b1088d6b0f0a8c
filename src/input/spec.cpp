// Collects a declaration into a tree without changing any variable, and prints from it what a deck
// could say: the names, and the present values as effective input.
// One visit feeds the page, the schema, the effective deck and the suggestions, so none of them can
// know a parameter that the others do not.
#include "input/spec.hpp"

#include <fmt/format.h>

namespace trackbed::input {

namespace {

// Visits a declaration without changing a variable.
// References of variables are only read: the same declaration that fills a model can describe it.
class Collector : public Section {
 public:
  Collector(Spec& root, Lists lists) : lists_(lists) { open_.push_back(&root); }

  void number(std::string_view name, double& value, const Limits& limits,
              std::string_view meaning) override {
    add(name, "number", limits, meaning).value = make_number(value);
  }
  void integer(std::string_view name, std::int64_t& value, const Limits& limits,
               std::string_view meaning) override {
    add(name, "integer", limits, meaning).value = make_integer(value);
  }
  void flag(std::string_view name, bool& value, std::string_view meaning) override {
    add(name, "flag", {}, meaning).value = make_flag(value);
  }
  void text(std::string_view name, std::string& value, std::string_view meaning,
            const std::vector<std::string_view>& choices, bool required) override {
    Spec& spec = add(name, choices.empty() ? "text" : "choice", {.required = required}, meaning);
    spec.choices.assign(choices.begin(), choices.end());
    spec.value = make_text(value);
  }
  void file(std::string_view name, std::string& value, std::string_view meaning, Named) override {
    add(name, "file", {}, meaning).value = make_text(value);
  }
  void numbers(std::string_view name, std::vector<double>& values, const Limits& limits,
               std::string_view meaning, std::size_t length) override {
    Spec& spec = add(name, "numbers", limits, meaning);
    spec.length = length;
    spec.value = make_list({});
    for (const double value : values) spec.value.items.push_back(make_number(value));
  }
  void texts(std::string_view name, std::vector<std::string>& values,
             std::string_view meaning) override {
    Spec& spec = add(name, "texts", {}, meaning);
    spec.value = make_list({});
    for (const std::string& value : values) spec.value.items.push_back(make_text(value));
  }
  // Rules are for the reader to judge: here nobody gave a value.
  void rule(std::string_view, bool, std::string_view, const About&) override {}

 protected:
  // A list without elements still has to show what one may hold: the visit is given one.
  bool describes() const override { return lists_ == Lists::at_least_one_element; }
  bool enter(std::string_view name, std::string_view meaning) override {
    open_.push_back(&add(name, "section", {}, meaning));
    return true;
  }
  std::optional<std::size_t> enter_list(std::string_view name, std::string_view meaning,
                                        std::size_t present) override {
    open_.push_back(&add(name, "list", {}, meaning));
    return present;
  }
  void enter_element(std::size_t) override {
    Spec& list = *open_.back();
    Spec& element = list.parts.emplace_back();
    element.path = fmt::format("{}[]", list.path);
    open_.push_back(&element);
  }
  void leave() override { open_.pop_back(); }

 private:
  // Parts of an open section move only while no part of it is open: pointers stay good.
  Spec& add(std::string_view name, std::string_view kind, const Limits& limits,
            std::string_view meaning) {
    const Spec& parent = *open_.back();
    Spec spec;
    spec.name = name, spec.kind = kind, spec.unit = limits.unit, spec.meaning = meaning;
    spec.path = parent.path.empty() ? spec.name : fmt::format("{}.{}", parent.path, name);
    spec.limits = limits;
    return open_.back()->parts.emplace_back(std::move(spec));
  }

  Lists lists_;
  std::vector<Spec*> open_;
};

// Leaves of the tree, with paths as the reference names them.
void list_scalars(const Spec& spec, std::vector<ParameterInfo>& found) {
  if (spec.is_section())
    for (const Spec& part : spec.parts) list_scalars(part, found);
  else if (spec.is_list())
    for (const Spec& part : spec.element()) list_scalars(part, found);
  else
    found.push_back({spec.path, spec.kind, spec.unit, spec.meaning});
}

// The effective deck: every value the program went by, defaults included.
// In the order of the declarations, so that equal models give equal texts whatever their decks.
Node values_of(const Spec& spec) {
  if (spec.is_list()) {
    Node list = make_list({});
    for (const Spec& element : spec.parts) list.items.push_back(values_of(element));
    return list;
  }
  // Leaves have their value already.
  if (!spec.is_section()) return spec.value;
  Node table;
  for (const Spec& part : spec.parts) table.members.emplace_back(part.name, values_of(part));
  return table;
}

}  // namespace

// A `const` visit in all but type: a declaration takes the model by reference.
Spec collect(const Declaration& declaration, Lists lists) {
  Spec root;
  Collector collector(root, lists);
  declaration(collector);
  return root;
}

// For suggestions: a name in the wrong section is found by its last word.
std::vector<ParameterInfo> all_parameters(const Declaration& declaration) {
  std::vector<ParameterInfo> found;
  list_scalars(collect(declaration, Lists::at_least_one_element), found);
  return found;
}

// Of the variables as they are now: called after reading, it shows overrides and defaults alike.
std::string effective(const Declaration& declaration) {
  return deck_text(values_of(collect(declaration, Lists::as_they_are)));
}

}  // namespace trackbed::input
