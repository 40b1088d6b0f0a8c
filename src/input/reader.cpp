// Reading does not stop at a problem: a rejected value keeps its default and the visit continues.
// All messages have one form, "place: path = value must be ...".
//
// A value is checked for type, finiteness and limits, in this order; the message is about the first
// of them that fails. A warning is given only for an accepted value.
#include "input/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "input/limits.hpp"
#include "input/magnitudes.hpp"
#include "input/units.hpp"

namespace trackbed::input {

namespace {

using Kind = Node::Kind;

// The shell removes quotes of the command line: 60E1 is a number for TOML, but may be meant as a
// name.
bool is_text(const Node& node) {
  return node.kind == Kind::text || (node.from_override && !node.text.empty());
}

// TOML reads 60E2 as the number 6000.
std::string as_written(const Node& node) {
  return node.kind == Kind::text || node.text.empty() ? shown(node) : node.text;
}

// "5 mm": the unit was written beside the number.
bool starts_like_a_number(const std::string& text) {
  const std::size_t at = text.find_first_not_of(" +-.");
  return at != std::string::npos && std::isdigit(static_cast<unsigned char>(text[at])) != 0;
}

// The most frequent error after a wrong name is a unit in the value, or quotes around it. The
// message then states the unit, and the value in it.
std::string number_hint(const Node& node, const Limits& limits) {
  if (node.kind != Kind::text || !starts_like_a_number(node.text)) return "";
  if (node.text.starts_with('.')) return "; write a digit before the point: 0" + node.text;
  if (limits.unit == "-") return "; give a number without quotes";
  const std::optional<double> value = in_unit(node.text, limits.unit);
  return fmt::format("; give a number in {}{}", limits.unit,
                     value ? fmt::format(": {:.10g}", *value) : "");
}

// As written in a deck: "a", "b" or "c".
std::string listed(const std::vector<std::string_view>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += fmt::format("\"{}\"", words[i]);
  }
  return text;
}

// Whether `below` is the value or section `path` or is contained in it. The next character must end
// the word, or "load" would cover "load_case".
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

// An absent value leaves the variable unchanged: its default is the initial value of the struct.
void Reader::number(std::string_view name, double& value, const Limits& limits, std::string_view) {
  if (const Node* node = find(name)) {
    take_number(*node, path_of(name), limits, value);
    return;
  }
  if (limits.required) return missing(name, std::string(limits.unit));
  keep_default(name, make_number(value));
}

// TOML distinguishes 5 from 5.0. A number without a fraction is accepted as an integer if a double
// represents it exactly.
void Reader::integer(std::string_view name, std::int64_t& value, const Limits& limits,
                     std::string_view) {
  const Node* node = find(name);
  if (node == nullptr) {
    if (limits.required) return missing(name, std::string(limits.unit));
    return keep_default(name, make_integer(value));
  }
  constexpr double exact_to = 9007199254740992.0;  // 2^53: 1e6 is accepted as an integer
  std::int64_t whole = node->integer;
  if (node->kind == Kind::number && std::abs(node->number) <= exact_to &&
      node->number == std::floor(node->number))
    whole = static_cast<std::int64_t>(node->number);
  else if (node->kind != Kind::integer)
    return reject(*node, path_of(name), "must be a whole number" + number_hint(*node, limits));
  // Limits are doubles: bounds of the integers in use are far below 2^53.
  if (!within(limits, static_cast<double>(whole)))
    return reject(*node, path_of(name), "must be " + range_in_words(limits));
  value = whole;
}

void Reader::flag(std::string_view name, bool& value, std::string_view) {
  const Node* node = find(name);
  if (node == nullptr) return keep_default(name, make_flag(value));
  if (node->kind != Kind::flag) return reject(*node, path_of(name), "must be true or false");
  value = node->flag;
}

// With choices the message lists them all, also if a number was given.
void Reader::text(std::string_view name, std::string& value, std::string_view,
                  const std::vector<std::string_view>& choices, bool required) {
  const Node* node = find(name);
  if (node == nullptr) {
    if (required) return missing(name, "-");
    return keep_default(name, make_text(value));
  }
  if (!choices.empty() &&
      (!is_text(*node) || std::find(choices.begin(), choices.end(), node->text) == choices.end()))
    return problem(
        node, path_of(name),
        fmt::format(" = {} must be {}{}{}", as_written(*node), listed(choices),
                    node->is_value() && !is_text(*node) ? " (in quotes)" : "",
                    did_you_mean(nearest(node->text, {choices.begin(), choices.end()}))));
  if (!is_text(*node)) return reject(*node, path_of(name), "must be text (in quotes)");
  value = node->text;
}

// The existence of a file is checked here, where the line in the deck is known. The default is
// checked likewise, since it may name a file too.
void Reader::file(std::string_view name, std::string& value, std::string_view, FileRole role) {
  namespace fs = std::filesystem;
  const Node* node = find(name);
  if (node != nullptr && !is_text(*node))
    return reject(*node, path_of(name), "must be the name of a file (in quotes)");
  if (node == nullptr) keep_default(name, make_text(value));
  // An empty name means none, so that a deck can disable a default file.
  const std::string given = node != nullptr ? node->text : value;
  if (given.empty()) {
    value = given;
    return;
  }
  // Absolute paths, so that the effective input names the same file wherever it is read. Names on
  // the command line are relative to the working directory, in a deck to its folder.
  const bool from_override = node != nullptr && node->from_override;
  // Joined, not fs::absolute: the folder of a deck named without one is empty, which is not a path.
  const fs::path from = from_override ? fs::current_path() : fs::current_path() / folder_;
  const fs::path path = (from / given).lexically_normal();
  std::error_code error;
  if (accepts_missing_origins_ && role == FileRole::origin && !from_override)
    value = given;
  else if (!fs::exists(path, error))
    problem(node, path_of(name),
            fmt::format(" \"{}\" does not exist (names in a deck are relative to the folder of the "
                        "deck, on the command line to the working directory)",
                        given));
  else if (!fs::is_regular_file(path, error) &&
           !(role == FileRole::origin && fs::is_directory(path, error)))
    problem(node, path_of(name), fmt::format(" \"{}\" is not a file", given));
  else
    value = path.string();
}

// Each item is checked and named by its index, so that a list may cause several messages.
void Reader::numbers(std::string_view name, std::vector<double>& values, const Limits& limits,
                     std::string_view, std::size_t length) {
  const Node* node = find(name);
  if (node == nullptr) {
    if (limits.required) return missing(name, std::string(limits.unit));
    std::vector<Node> items;
    for (const double item : values) items.push_back(make_number(item));
    return keep_default(name, make_list(std::move(items)));
  }
  const std::string what =
      length == 0 ? "a list of numbers" : fmt::format("a list of {} numbers", length);
  if (!node->is_list()) return reject(*node, path_of(name), fmt::format("must be {}", what));
  if (length != 0 && node->items.size() != length)
    return reject(*node, path_of(name),
                  fmt::format("must be {}, not of {}", what, node->items.size()));
  // The list is taken as a whole or not at all.
  std::vector<double> found(node->items.size());
  bool ok = true;
  for (std::size_t i = 0; i < found.size(); ++i)
    ok &= take_number(node->items[i], fmt::format("{}[{}]", path_of(name), i), limits, found[i]);
  if (ok) values = std::move(found);
}

void Reader::texts(std::string_view name, std::vector<std::string>& values, std::string_view) {
  const Node* node = find(name);
  if (node == nullptr) {
    std::vector<Node> items;
    for (const std::string& item : values) items.push_back(make_text(item));
    return keep_default(name, make_list(std::move(items)));
  }
  std::vector<std::string> found;
  if (node->is_list())
    for (const Node& item : node->items)
      if (item.kind == Kind::text) found.push_back(item.text);
  if (!node->is_list() || found.size() != node->items.size())
    return reject(*node, path_of(name), "must be a list of texts (each in quotes)");
  values = std::move(found);
}

// As `describe` shows it.
void Reader::keep_default(std::string_view name, const Node& value) {
  defaults_[path_of(name)] = shown(value);
}

// Skipped if a value that it uses was rejected, so that one error causes one message.
void Reader::rule(std::string_view name, bool holds, std::string_view sentence,
                  const About& about) {
  note_early_reads(name, about);
  if (holds || has_rejected(about)) return;
  // A rule refers to its value if the file has one, else to the section; a default, which is never
  // from the command line, is shown too.
  const Node* section = open_.back().node;
  Place place = section != nullptr ? follow(*section, name) : Place{nullptr, false};
  std::string value;
  if (place.reached && place.node->is_value())
    value = fmt::format(" = {}", shown(*place.node));
  else if (const auto kept = defaults_.find(path_of(name)); kept != defaults_.end()) {
    if (place.node != nullptr && place.node->from_override) place.node = nullptr;
    // Of a value that the user has yet to give, the default is of no interest.
    if (!sentence.starts_with("must be given"))
      value = fmt::format(" = {} (default)", kept->second);
  }
  const std::string rest = fmt::format("{}: {}", value, sentence);
  if (about.severity == Severity::warning) return problems_.warn(place.node, path_of(name) + rest);
  // The parameter counts as rejected, so that other rules that use it do not report the same
  // problem.
  problem(place.node, path_of(name), rest);
}

// A rule about a parameter that is declared later would see its default. `leave` refuses it.
void Reader::note_early_reads(std::string_view rule, const About& about) {
  Frame& frame = open_.back();
  for (const std::string& read : about.reads) {
    const std::string first = read.substr(0, read.find_first_of(".["));
    if (std::find(frame.known.begin(), frame.known.end(), first) == frame.known.end())
      frame.early.emplace(first, rule);
  }
}

// A rejected value keeps its default: rules that use it would mislead. A path covers everything
// below it: "ground" covers ground.x and ground.layer[0].young.
bool Reader::has_rejected(const About& about) const {
  if (about.reads.empty()) return problems_.count() > open_.back().problems_before;
  return std::any_of(about.reads.begin(), about.reads.end(), [&](const std::string& read) {
    const std::string path = path_of(read);
    return std::any_of(rejected_.begin(), rejected_.end(), [&](const std::string& wrong) {
      return covers(path, wrong) || covers(wrong, path);
    });
  });
}

// Integers are accepted as numbers: 5 for 5.0.
bool Reader::take_number(const Node& node, const std::string& path, const Limits& limits,
                         double& value) {
  if (node.kind != Kind::number && node.kind != Kind::integer) {
    reject(node, path, "must be a number" + number_hint(node, limits));
    return false;
  }
  const double found = node.kind == Kind::number ? node.number : static_cast<double>(node.integer);
  if (!std::isfinite(found)) {
    reject(node, path, "must be a finite number");
    return false;
  }
  if (!within(limits, found)) {
    // In short form: -5 also if the file has -5.0.
    problem(&node, path, fmt::format(" = {} must be {}", shown(found), range_in_words(limits)));
    return false;
  }
  if (const Magnitudes range = magnitudes_of(limits.unit); !computable(range, found)) {
    const bool large = std::abs(found) > range.most;
    problem(&node, path,
            fmt::format(" = {} is too {} for this program, whose sums and products would lose "
                        "digits or overflow; its magnitude must be {} {:g}{}{}{}",
                        shown(found), large ? "large" : "small", large ? "at most" : "at least",
                        large ? range.most : range.least, limits.unit == "-" ? "" : " ",
                        limits.unit == "-" ? "" : limits.unit,
                        large || !within(limits, 0) ? "" : ", or 0"));
    return false;
  }
  if (!usual(limits, found)) {
    const bool has_unit = limits.unit != "-" && !limits.unit.empty();
    problems_.warn(
        &node, fmt::format("{} = {} is outside the usual values ({}{}{}){}", path, shown(found),
                           usual_in_words(limits), has_unit ? " " : "", has_unit ? limits.unit : "",
                           has_unit ? "; is its unit right?" : ""));
  }
  value = found;
  return true;
}

}  // namespace trackbed::input
