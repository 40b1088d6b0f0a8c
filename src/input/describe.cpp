// The reference of all parameters: Markdown for docs/input.md, plain lines for a terminal.
// Both are printed from the declarations and their defaults, so that the document agrees with the
// program; a test compares the two.
//
// A list is described by one element, which the collector creates if the program's own list is
// empty.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "input/limits.hpp"
#include "input/lower.hpp"
#include "input/spec.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::input {

namespace {

// The section header as written in a deck.
std::string header_of(const Spec& section, bool in_list) {
  if (section.path.empty()) return "Top of the deck";
  return in_list ? fmt::format("[[{}]]", section.path) : fmt::format("[{}]", section.path);
}

// Whether it has parts, and so a heading of its own.
bool is_group(const Spec& spec) { return spec.is_section() || spec.is_list(); }

std::string kind_in_words(const Spec& spec) {
  if (spec.kind == "integer") return "whole number";
  if (spec.kind == "flag") return "true or false";
  if (spec.kind == "texts") return "list of texts";
  if (spec.kind == "numbers")
    return spec.length == 0 ? "list of numbers" : fmt::format("list of {} numbers", spec.length);
  if (spec.kind != "choice") return spec.kind;
  std::vector<std::string> words = spec.choices;
  for (std::string& word : words)
    if (word.empty()) word = "\"\"";
  return fmt::format("one of {}", fmt::join(words, ", "));
}

// As the value would be written in a deck, so that it can be copied.
std::string default_in_words(const Spec& spec) {
  return spec.limits.required ? "must be given" : shown(spec.value);
}

// Values outside of the limits are rejected, outside of `usually` warned of; one column for both.
std::string range_of(const Spec& spec) {
  Limits limits = spec.limits;
  limits.unit = "-";  // the unit has its own column
  const std::string range = range_in_words(limits), often = usual_in_words(limits);
  if (often.empty()) return range;
  return fmt::format("{}{}usually {}", range, range.empty() ? "" : "; ", often);
}

// What it means, and from when on it cannot be changed in runs that continue.
std::string meaning_of(const Spec& spec) {
  using namespace state;
  static constexpr std::array<std::pair<StateParts, const char*>, 11> words{{
      {any, "when a run continues from a checkpoint"},
      {earlier, "for list entries that existed when the checkpoint was written"},
      {sleepers, "once sleepers are placed"},
      {solid_sleepers, "once solid sleepers are placed"},
      {solid_rails, "once solid rails are placed"},
      {tines, "while tines are inserted"},
      {train, "while a train is under way"},
      {moved_ground, "once the ground has moved"},
      {moved_plane_ground, "once a plane ground has moved"},
      {moved_viscous_base, "once a ground on a viscous base has moved"},
      {moved_implicitly, "once the ground has taken implicit steps"},
  }};
  std::vector<std::string> parts;
  for (const auto& [part, name] : words)
    if ((spec.fixed_by & part) != 0) parts.emplace_back(name);
  if (parts.empty()) return spec.meaning;
  if ((spec.fixed_by & any) != 0) parts.resize(1);
  return fmt::format("{} Cannot be changed {}.", spec.meaning, fmt::join(parts, " or "));
}

// A bar would end the cell of a Markdown table.
std::string cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

constexpr int section_column = 28;  // characters, of the names in the list of sections

constexpr const char* about_top =
    "Values before the first section of the deck. Words in brackets at the end of a meaning, such "
    "as "
    "(space) or (fill), name the dimension, kind or model in which the parameter has an effect.";

// In the order of the declarations, each section followed by those within it.
void markdown(const Spec& section, const std::vector<Spec>& parts, bool in_list, std::string& out) {
  const bool has_scalars =
      std::any_of(parts.begin(), parts.end(), [](const Spec& part) { return !is_group(part); });
  if (!section.path.empty() || has_scalars)
    out += fmt::format("\n## `{}`\n\n{}\n", header_of(section, in_list),
                       section.path.empty() ? about_top : section.meaning);
  // Values before inner sections, as required in a deck.
  if (has_scalars)
    out += "\n| parameter | kind | unit | default | range | meaning |\n|---|---|---|---|---|---|\n";
  for (const Spec& part : parts)
    if (!is_group(part))
      out += fmt::format("| `{}` | {} | {} | `{}` | {} | {} |\n", part.name,
                         cell(kind_in_words(part)), cell(part.unit), cell(default_in_words(part)),
                         range_of(part), cell(meaning_of(part)));
  for (const Spec& part : parts)
    if (is_group(part))
      markdown(part, part.is_list() ? part.element() : part.parts, part.is_list(), out);
}

// The same content, one parameter per paragraph: a terminal has no tables.
void plain(const Spec& section, const std::vector<Spec>& parts, bool in_list, std::string& out) {
  out += fmt::format("{}\n  {}\n", header_of(section, in_list), section.meaning);
  for (const Spec& part : parts) {
    if (is_group(part)) continue;
    const std::string range = range_of(part);
    out += fmt::format("\n  {} = {}{}\n      {}{}\n      {}\n", part.name, default_in_words(part),
                       part.unit == "-" ? "" : " " + part.unit, kind_in_words(part),
                       range.empty() ? "" : fmt::format(", {}", range), meaning_of(part));
  }
  for (const Spec& part : parts)
    if (is_group(part)) {
      out += '\n';
      plain(part, part.is_list() ? part.element() : part.parts, part.is_list(), out);
    }
}

// `layer[].x` and `layer.x` name the same parameter.
std::string without_brackets(std::string path) {
  for (std::size_t at; (at = path.find("[]")) != std::string::npos;) path.erase(at, 2);
  return path;
}

// Collects all names along its search, for the suggestion if nothing is found. Paths are unique.
const Spec* find(const Spec& spec, const std::string& path, std::vector<std::string>& known) {
  for (const Spec& part : spec.is_list() ? spec.element() : spec.parts) {
    known.push_back(without_brackets(part.path));
    if (known.back() == path) return &part;
    if (!is_group(part)) continue;
    if (const Spec* found = find(part, path, known)) return found;
  }
  return nullptr;
}

// A line for each section, those within it indented.
void outline(const std::vector<Spec>& parts, int depth, std::string& out) {
  constexpr int indent = 2;
  for (const Spec& part : parts) {
    if (!is_group(part)) continue;
    out += fmt::format("{:{}}{:<{}} {}\n", "", indent * depth, header_of(part, part.is_list()),
                       section_column - indent * depth, part.meaning);
    outline(part.is_list() ? part.element() : part.parts, depth + 1, out);
  }
}

// A line for each section or parameter whose path or meaning contains `word`.
void mention(const Spec& spec, const std::string& word, std::string& out) {
  for (const Spec& part : spec.is_list() ? spec.element() : spec.parts) {
    const std::string path = without_brackets(part.path);
    if (lower(path + " " + part.meaning).find(word) != std::string::npos)
      out += fmt::format("  {}{}: {}\n", path, part.unit == "-" ? "" : " (" + part.unit + ")",
                         part.meaning);
    if (is_group(part)) mention(part, word, out);
  }
}

}  // namespace

// A list of the sections (nothing given), all parameters, one section or a single parameter, by the
// same path that overrides use; any other word is looked for in all of them.
std::string describe(const Declaration& declaration, const std::string& section) {
  const Spec root = collect(declaration, Lists::at_least_one_element);
  std::string out;
  if (section.empty()) {
    outline(root.parts, 0, out);
    return out +
           "\nParameters: describe SECTION, describe WORD (a word to look for), or describe "
           "all (as in docs/input.md).\n";
  }
  if (section == "all") {
    markdown(root, root.parts, false, out);
    return out.substr(std::min<std::size_t>(out.size(), 1));  // no blank line at the start
  }
  std::vector<std::string> known;
  const Spec* found = find(root, without_brackets(section), known);
  if (found == nullptr) {
    constexpr std::size_t shortest = 3;  // shorter words are in nearly every line
    if (section.size() >= shortest) mention(root, lower(section), out);
    if (!out.empty()) return fmt::format("\"{}\" occurs in\n{}", section, out);
    // Compared with whole paths, since the user typed a path.
    const std::string near = nearest(section, known);
    throw InputError({fmt::format("{} is not a section or parameter{}", section,
                                  near.empty() ? "" : fmt::format("; did you mean {}?", near))});
  }
  if (is_group(*found)) {
    plain(*found, found->is_list() ? found->element() : found->parts, found->is_list(), out);
    return out;
  }
  Spec around;  // a single parameter is shown as a section of one
  around.path = found->path.substr(
      0, found->path.rfind('.') == std::string::npos ? 0 : found->path.rfind('.'));
  plain(around, {*found}, false, out);
  return out;
}

}  // namespace trackbed::input
