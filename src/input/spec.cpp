// Collects a declaration into a tree without changing any variable, and prints from it the names
// and the current values (effective input). The reference, the schema, the effective deck and the
// suggestions all use this one tree and therefore have the same parameters.
#include "input/spec.hpp"

#include <fmt/format.h>

namespace trackbed::input {

namespace {

// Only reads the variables: the same declaration that fills a model can describe it.
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
  void file(std::string_view name, std::string& value, std::string_view meaning,
            FileRole) override {
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
  // Rules are evaluated by the reader only.
  void rule(std::string_view, bool, std::string_view, const About&) override {}

 protected:
  // An empty list is given one element, to describe what an element may hold.
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
  // Parts of an open section are moved only while none of them is open, so pointers remain valid.
  Spec& add(std::string_view name, std::string_view kind, const Limits& limits,
            std::string_view meaning) {
    const Spec& parent = *open_.back();
    Spec spec;
    spec.name = name, spec.kind = kind, spec.unit = limits.unit, spec.meaning = meaning;
    spec.fixed_by = fixed_by();
    spec.path = parent.path.empty() ? spec.name : fmt::format("{}.{}", parent.path, name);
    spec.limits = limits;
    return open_.back()->parts.emplace_back(std::move(spec));
  }

  Lists lists_;
  std::vector<Spec*> open_;
};

// Leaves of the tree, with paths as in the reference.
void list_scalars(const Spec& spec, std::vector<ParameterInfo>& found) {
  if (spec.is_section())
    for (const Spec& part : spec.parts) list_scalars(part, found);
  else if (spec.is_list())
    for (const Spec& part : spec.element()) list_scalars(part, found);
  else
    found.push_back({spec.path, spec.kind, spec.unit, spec.meaning, spec.fixed_by});
}

// The effective deck: every value used, including defaults, in the order of the declarations, so
// that equal models give equal texts.
Node values_of(const Spec& spec) {
  if (spec.is_list()) {
    Node list = make_list({});
    for (const Spec& element : spec.parts) list.items.push_back(values_of(element));
    return list;
  }
  // Leaves hold their value.
  if (!spec.is_section()) return spec.value;
  Node table;
  for (const Spec& part : spec.parts) table.members.push_back({part.name, values_of(part)});
  return table;
}

}  // namespace

// Does not change the model, although a declaration takes it by non-const reference.
Spec collect(const Declaration& declaration, Lists lists) {
  Spec root;
  Collector collector(root, lists);
  declaration(collector);
  return root;
}

// Used for suggestions: a name in the wrong section is identified by its last word.
std::vector<ParameterInfo> all_parameters(const Declaration& declaration) {
  std::vector<ParameterInfo> found;
  list_scalars(collect(declaration, Lists::at_least_one_element), found);
  return found;
}

// The current values of the variables: after reading, these include overrides and defaults.
std::string effective(const Declaration& declaration) {
  return deck_text(values_of(collect(declaration, Lists::as_they_are)));
}

}  // namespace trackbed::input
