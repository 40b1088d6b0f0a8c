// The reader's path through the sections of a deck: which one is open, which names were looked up,
// and which remain unknown. A name is unknown only once its section is left, because the visit
// alone defines what a section may hold.
//
// Cost: linear comparison of names with the members of a section, some twenty names.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "input/reader.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::input {

namespace {

std::string last_word(const std::string& path) {
  return path.substr(path.rfind('.') + 1);  // the whole path if it has no point
}

}  // namespace

// A section that is not in the deck is visited all the same: its rules are evaluated, and missing
// required parameters are reported.
bool Reader::enter(std::string_view name, std::string_view) {
  const Node* node = find(name);
  const std::string path = path_of(name);
  if (node != nullptr && !node->is_table()) {
    reject(*node, path, fmt::format("must be a section, [{}]", path));
    return false;
  }
  open({path, node, {}, problems_.count()});
  return true;
}

// The deck's list replaces the program's as a whole; elements of both are not mixed.
std::optional<std::size_t> Reader::enter_list(std::string_view name, std::string_view,
                                              std::size_t) {
  const Node* node = find(name);
  if (node == nullptr) return std::nullopt;  // the program's own list stays
  const std::string path = path_of(name);
  const bool ok = node->is_list() && std::all_of(node->items.begin(), node->items.end(),
                                                 [](const Node& n) { return n.is_table(); });
  if (!ok) {
    reject(*node, path, fmt::format("must be a list of sections, each starting with [[{}]]", path));
    return std::nullopt;
  }
  open({path, node, {}, problems_.count()});
  return node->items.size();
}

void Reader::enter_element(std::size_t index) {
  const Frame& list = open_.back();
  open({fmt::format("{}[{}]", list.path, index),
        &list.node->items.at(index),
        {},
        problems_.count()});
}

// Names of the section that are still unknown are reported.
void Reader::leave() {
  const Frame frame = std::move(open_.back());
  open_.pop_back();
  for (const std::string& name : frame.known)
    if (const auto early = frame.early.find(name); early != frame.early.end())
      require(false, fmt::format("the rule about {} reads {}, which is declared after it",
                                 early->second, name)
                         .c_str());
  // A list has no names of its own: each of its elements is a frame that is left by itself.
  if (frame.node != nullptr && frame.node->is_table()) report_unknown(frame);
}

void Reader::open(Frame frame) { open_.push_back(std::move(frame)); }

// The name is also registered for a section that is not in the file. Every reading call registers
// its name here.
const Node* Reader::find(std::string_view name) {
  Frame& frame = open_.back();
  frame.known.emplace_back(name);
  return frame.node != nullptr ? frame.node->member(name) : nullptr;
}

// The path as shown in messages and written in overrides.
std::string Reader::path_of(std::string_view name) const {
  const std::string& section = open_.back().path;
  return section.empty() ? std::string(name) : fmt::format("{}.{}", section, name);
}

// Adds a problem about a rejected value. The variable keeps its default, and the path is stored for
// `has_rejected`.
void Reader::problem(const Node* place, const std::string& path, const std::string& rest) {
  problems_.add(place, path + rest);
  rejected_.push_back(path);
}

void Reader::reject(const Node& node, const std::string& path, const std::string& must) {
  problem(&node, path, fmt::format(" = {} {}", shown(node), must));
}

// There is no value to show, so the message refers to the section and states the unit.
void Reader::missing(std::string_view name, const std::string& unit) {
  problem(open_.back().node, path_of(name),
          " must be given" + (unit == "-" ? "" : fmt::format(" (in {})", unit)));
}

// An unknown name is a problem, not a warning: the parameter that was meant would keep its default
// unnoticed.
void Reader::report_unknown(const Frame& frame) {
  for (const auto& [name, value] : frame.node->members) {
    if (std::find(frame.known.begin(), frame.known.end(), name) != frame.known.end()) continue;
    unknown_.push_back({&value, frame.path, name, frame.known, problems_.count()});
    problem(&value, unknown_.back().path(), "");  // `finish` appends the rest
  }
}

void Reader::finish() {
  sections_ = open_.back().known;
  root_ = open_.back().node;
  leave();
  for (const Unknown& unknown : unknown_)
    problems_.append(unknown.problem, describe_unknown(unknown));
}

bool Reader::is_a_name(const std::string& word) const {
  return std::any_of(paths_.begin(), paths_.end(),
                     [&](const auto& known) { return last_word(known.path) == word; });
}

namespace {

// "ground.layer[1]" -> "ground.layer[]", or with other brackets.
std::string without_numbers(const std::string& path, const std::string& brackets = "[]") {
  std::string out;
  bool number = false;
  for (const char c : path) {
    if (c == '[') out += brackets;
    number = (number || c == '[') && c != ']';
    if (!number && c != ']') out += c;
  }
  return out;
}

}  // namespace

// A name of another model's deck, or a typing error.
std::string Reader::describe_unknown(const Unknown& unknown) const {
  const std::string path = unknown.path();
  const bool elsewhere = std::any_of(paths_.begin(), paths_.end(), [&](const auto& known) {
    return known.path == path || known.path.starts_with(path + ".") ||
           known.path.starts_with(path + "[");
  });
  const char* kind = unknown.node->is_value() ? "parameter" : "section";
  if (elsewhere) return fmt::format(" is not a {} of a deck with this `model`; leave it out", kind);
  if (const std::string near = suggestion(unknown); !near.empty())
    return fmt::format(" is not a {}{}", kind, did_you_mean(near));
  std::string where;
  if (is_a_name(unknown.name))
    where =
        fmt::format("; `trackbed describe {}` lists other parameters of this name", unknown.name);
  else if (!unknown.section.empty())
    where = fmt::format("; `trackbed describe {}` lists those of this section",
                        without_numbers(unknown.section, ""));
  return fmt::format(" is not a {}{}", kind, where);
}

namespace {

std::string top_of(const std::string& path) { return path.substr(0, path.find_first_of(".[")); }

}  // namespace

// Whether the deck has the section of this parameter.
bool Reader::gives_section_of(const std::string& path) const {
  const Node* node = root_;
  std::size_t begin = 0;
  for (std::size_t end; node != nullptr && (end = path.find('.', begin)) != std::string::npos;
       begin = end + 1) {
    const std::string name = path.substr(begin, end - begin);
    node = node->member(name.substr(0, name.find('[')));
    if (node != nullptr && node->is_list()) node = node->items.empty() ? nullptr : &node->items[0];
  }
  return node != nullptr;
}

// The nearest name of the same section, else the nearest one of the lists and sections within it,
// else of the other sections that the deck has: a parameter may be in the wrong one, and its full
// path then shows where it belongs. The name of a parameter of a section that the deck lacks would
// mislead, unlike one that is only similar to it, or a name without a section.
std::string Reader::suggestion(const Unknown& unknown) const {
  const auto choose = [&](auto&& fits) -> std::string {
    std::vector<const ParameterInfo*> possible;
    std::vector<std::string> words;
    for (const ParameterInfo& parameter : paths_)
      if (fits(parameter.path))
        possible.push_back(&parameter), words.push_back(last_word(parameter.path));
    const std::string near = nearest(unknown.name, words);
    std::vector<std::string> found;
    for (const ParameterInfo* parameter : possible)
      // "stage[0].start ...; did you mean start?" would seem to suggest the same name.
      if (!near.empty() && last_word(parameter->path) == near)
        found.push_back(parameter->path + (parameter->path == near && !unknown.section.empty()
                                               ? " at the top of the deck"
                                               : ""));
    constexpr std::size_t most = 3;
    if (found.size() > most) found.resize(most);
    return fmt::format("{}", fmt::join(found, " or "));
  };
  const auto known = [&](const std::string& path) {
    return std::find(sections_.begin(), sections_.end(), top_of(path)) != sections_.end();
  };
  const auto given = [&](const std::string& path) { return known(path) && gives_section_of(path); };
  if (const std::string near = nearest(unknown.name, unknown.known); !near.empty()) {
    if (unknown.section.empty()) return near;
    // The right name in the wrong section is as likely as a wrong name.
    const std::string exact = choose(
        [&](const std::string& path) { return given(path) && last_word(path) == unknown.name; });
    return fmt::format("{}.{}{}{}", unknown.section, near, exact.empty() ? "" : " or ", exact);
  }
  if (!unknown.section.empty()) {
    const std::string within = without_numbers(unknown.section);
    const std::string inner = choose([&](const std::string& path) {
      return path.starts_with(within + ".") || path.starts_with(within + "[");
    });
    if (!inner.empty()) return inner;
  }
  // A short name is similar to many.
  constexpr std::size_t least = 5;
  const bool is_long = unknown.name.size() >= least || unknown.section.empty();
  const std::string there = choose([&](const std::string& path) {
    return given(path) && (is_long || last_word(path) == unknown.name);
  });
  if (!there.empty() || (!unknown.section.empty() && is_a_name(unknown.name))) return there;
  return is_long ? choose(known) : "";
}

}  // namespace trackbed::input
