// Reading never stops at a problem: a refused value keeps its default and the visit goes on. All
// sentences have one form, "place: path = value must be ...", so that a user can search for them.
//
// The order of checks on a value is type, finiteness, limits: each sentence is about the first
// thing that is wrong. A warning is given only for a value that is taken.
#include "input/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "input/limits.hpp"
#include "input/magnitudes.hpp"

namespace trackbed::input {

namespace {

using Kind = Node::Kind;

// Quotes of a command line are taken off by the shell: 60E1 is a number to TOML, a name to us.
bool is_text(const Node& node) {
  return node.kind == Kind::text || (node.commanded && !node.text.empty());
}

// "5 mm": somebody wrote the unit beside the number.
bool starts_like_a_number(const std::string& text) {
  const std::size_t at = text.find_first_not_of(" +-.");
  return at != std::string::npos && std::isdigit(static_cast<unsigned char>(text[at])) != 0;
}

// The commonest slip after a wrong name: a unit in the value, or quotes around it.
// The sentence then says the unit, which is what the user wanted to be sure of.
std::string number_hint(const Node& node, const Limits& limits) {
  if (node.kind != Kind::text || !starts_like_a_number(node.text)) return "";
  return limits.unit == "-" ? "; give a number without quotes"
                            : fmt::format("; give a number in {}", limits.unit);
}

// "a, b or c", as people write lists; a word that is empty as a deck has it.
std::string listed(const std::vector<std::string_view>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += words[i].empty() ? "\"\"" : words[i];
  }
  return text;
}

// Whether `below` is the value or section `path` or lies in it.
// The next letter must end the word, or "load" would cover "load_case".
bool covers(std::string_view path, std::string_view below) {
  return below.starts_with(path) &&
         (below.size() == path.size() || below[path.size()] == '.' || below[path.size()] == '[');
}

}  // namespace

// The root is the first open section: names at the top of a deck are looked up like any others.
Reader::Reader(const Node& root, std::string folder, std::vector<ParameterInfo> paths,
               Problems& problems)
    : folder_(std::move(folder)), paths_(std::move(paths)), problems_(problems) {
  open({"", &root, {}, 0});
}

// An absent value leaves the variable as it is: its default is whatever the struct was made with.
void Reader::number(std::string_view name, double& value, const Limits& limits, std::string_view) {
  if (const Node* node = find(name))
    take_number(*node, path_of(name), limits, value);
  else if (limits.required)
    missing(name, std::string(limits.unit));
}

// TOML tells 5 from 5.0; people do not. A number without a fraction counts as whole as long as a
// double holds it exactly.
void Reader::integer(std::string_view name, std::int64_t& value, const Limits& limits,
                     std::string_view) {
  const Node* node = find(name);
  if (node == nullptr) {
    if (limits.required) missing(name, std::string(limits.unit));
    return;
  }
  constexpr double exact_to = 9007199254740992.0;  // 2^53: 1e6 is welcome as a whole number
  std::int64_t whole = node->integer;
  if (node->kind == Kind::number && std::abs(node->number) <= exact_to &&
      node->number == std::floor(node->number))
    whole = static_cast<std::int64_t>(node->number);
  else if (node->kind != Kind::integer)
    return refuse(*node, path_of(name), "must be a whole number" + number_hint(*node, limits));
  // Limits are numbers: bounds of integers in use are far below 2^53.
  if (!within(limits, static_cast<double>(whole)))
    return refuse(*node, path_of(name), "must be " + range_in_words(limits));
  value = whole;
}

void Reader::flag(std::string_view name, bool& value, std::string_view) {
  const Node* node = find(name);
  if (node == nullptr) return;
  if (node->kind != Kind::flag) return refuse(*node, path_of(name), "must be true or false");
  value = node->flag;
}

// With choices the sentence lists them all, also to who gave a number.
void Reader::text(std::string_view name, std::string& value, std::string_view,
                  const std::vector<std::string_view>& choices, bool required) {
  const Node* node = find(name);
  if (node == nullptr) {
    if (required) missing(name, "-");
    return;
  }
  if (!choices.empty() &&
      (!is_text(*node) || std::find(choices.begin(), choices.end(), node->text) == choices.end()))
    return refuse(*node, path_of(name),
                  fmt::format("must be {}{}", listed(choices),
                              did_you_mean(nearest(node->text, {choices.begin(), choices.end()}))));
  if (!is_text(*node)) return refuse(*node, path_of(name), "must be text (in quotes)");
  value = node->text;
}

// That a file is there is checked now, at the deck's line, and not minutes later by who opens it.
// The default goes the same way: it may name a file too.
void Reader::file(std::string_view name, std::string& value, std::string_view, Named named) {
  namespace fs = std::filesystem;
  const Node* node = find(name);
  if (node != nullptr && !is_text(*node))
    return refuse(*node, path_of(name), "must be the name of a file (in quotes)");
  // An empty name means none: so a deck can take a default file away.
  const std::string given = node != nullptr ? node->text : value;
  if (given.empty()) {
    value = given;
    return;
  }
  // Whole paths, so that the effective input means the same file wherever it is read.
  // On the command line names are meant from where one stands, in a deck from where it lies.
  const bool commanded = node != nullptr && node->commanded;
  // Joined, not made absolute: the folder of a deck named without one is empty, which is no path.
  const fs::path from = commanded ? fs::current_path() : fs::current_path() / folder_;
  const fs::path path = (from / given).lexically_normal();
  std::error_code error;
  if (origins_as_they_are_ && named == Named::origin && !commanded)
    value = given;
  else if (!fs::exists(path, error))
    problem(node, path_of(name), fmt::format(" \"{}\" does not exist", given));
  else if (!fs::is_regular_file(path, error) &&
           !(named == Named::origin && fs::is_directory(path, error)))
    problem(node, path_of(name), fmt::format(" \"{}\" is not a file", given));
  else
    value = path.string();
}

// Each item is checked and named by its place, so that a list may give several sentences.
void Reader::numbers(std::string_view name, std::vector<double>& values, const Limits& limits,
                     std::string_view, std::size_t length) {
  const Node* node = find(name);
  if (node == nullptr) {
    if (limits.required) missing(name, std::string(limits.unit));
    return;
  }
  const std::string what =
      length == 0 ? "a list of numbers" : fmt::format("a list of {} numbers", length);
  if (!node->is_list()) return refuse(*node, path_of(name), fmt::format("must be {}", what));
  if (length != 0 && node->items.size() != length)
    return refuse(*node, path_of(name),
                  fmt::format("must be {}, not of {}", what, node->items.size()));
  // All or nothing: half a list would be a value nobody wrote.
  std::vector<double> found(node->items.size());
  bool ok = true;
  for (std::size_t i = 0; i < found.size(); ++i)
    ok &= take_number(node->items[i], fmt::format("{}[{}]", path_of(name), i), limits, found[i]);
  if (ok) values = std::move(found);
}

void Reader::texts(std::string_view name, std::vector<std::string>& values, std::string_view) {
  const Node* node = find(name);
  if (node == nullptr) return;
  std::vector<std::string> found;
  if (node->is_list())
    for (const Node& item : node->items)
      if (item.kind == Kind::text) found.push_back(item.text);
  if (!node->is_list() || found.size() != node->items.size())
    return refuse(*node, path_of(name), "must be a list of texts (each in quotes)");
  values = std::move(found);
}

// Left out while in doubt: one slip, one sentence.
void Reader::rule(std::string_view name, bool holds, std::string_view sentence,
                  const About& about) {
  if (holds || in_doubt(about)) return;
  // A rule points at the value it is about where the file has one, else at the section.
  const Node* section = open_.back().node;
  const Place place = section != nullptr ? follow(*section, name) : Place{nullptr, false};
  const std::string rest = fmt::format(
      "{}: {}", place.reached && place.node->is_value() ? " = " + shown(*place.node) : "",
      sentence);
  if (about.weight == Weight::warning) return problems_.warn(place.node, path_of(name) + rest);
  // What is wrong with it is said: rules that read it too would say it again in other words.
  problem(place.node, path_of(name), rest);
}

// A value that was refused keeps its default: rules that read it would only confuse.
// A path covers all below it, read or refused: "ground" stands for ground.x and for
// ground.layer[0].young.
bool Reader::in_doubt(const About& about) const {
  if (about.reads.empty()) return problems_.count() > open_.back().problems_before;
  return std::any_of(about.reads.begin(), about.reads.end(), [&](const std::string& read) {
    const std::string path = path_of(read);
    return std::any_of(refused_.begin(), refused_.end(), [&](const std::string& wrong) {
      return covers(path, wrong) || covers(wrong, path);
    });
  });
}

// Whole numbers are taken for numbers, as everybody writes 5 for 5.0.
bool Reader::take_number(const Node& node, const std::string& path, const Limits& limits,
                         double& value) {
  if (node.kind != Kind::number && node.kind != Kind::integer) {
    refuse(node, path, "must be a number" + number_hint(node, limits));
    return false;
  }
  const double found = node.kind == Kind::number ? node.number : static_cast<double>(node.integer);
  if (!std::isfinite(found)) {
    refuse(node, path, "must be a finite number");
    return false;
  }
  if (!within(limits, found)) {
    // As people write it: -5 also where the file has -5.0.
    problem(&node, path, fmt::format(" = {} must be {}", shown(found), range_in_words(limits)));
    return false;
  }
  if (const Magnitudes range = magnitudes_of(limits.unit); !computable(range, found)) {
    const bool large = std::abs(found) > range.most;
    problem(&node, path,
            fmt::format(" = {} is too {} to be computed with beside other values of 16 digits; "
                        "{} {:g}{}{} in size{}",
                        shown(found), large ? "large" : "small", large ? "at most" : "at least",
                        large ? range.most : range.least, limits.unit == "-" ? "" : " ",
                        limits.unit == "-" ? "" : limits.unit,
                        large || !within(limits, 0) ? "" : ", or 0"));
    return false;
  }
  if (!usual(limits, found))
    problems_.warn(&node, fmt::format("{} = {} is far from the usual values ({}{}); is its unit "
                                      "right?",
                                      path, shown(found), usual_in_words(limits),
                                      limits.unit == "-" ? "" : fmt::format(" {}", limits.unit)));
  value = found;
  return true;
}

}  // namespace trackbed::input
