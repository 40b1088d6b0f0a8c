// A deck: the text a user writes (TOML), read into declared parameters and checked; all problems
// are reported at once.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "trackbed/input/section.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::input {

// Visits every parameter of a program: usually `[&](Section& s) { parameters.declare(s); }`.
using Declaration = std::function<void(Section&)>;

class Deck {
 public:
  // Reads `path` on rank 0 and broadcasts the text. `overrides`: `key.path=value` (value in TOML
  // syntax; a bare word is text). Throws InputError for a missing file or a syntax error.
  // Collective.
  static Deck read(const par::Comm& comm, const std::string& path,
                   const std::vector<std::string>& overrides);
  // For tests. `origin`: its name in messages.
  static Deck parse(const std::string& text, const std::string& origin,
                    const std::vector<std::string>& overrides = {});
  // The effective input stored in a checkpoint: the files that the run started from need not exist
  // any more.
  static Deck stored(const std::string& text, const std::string& origin,
                     const std::vector<std::string>& overrides = {});
  ~Deck();
  Deck(Deck&&) noexcept;
  Deck& operator=(Deck&&) noexcept;

  // Fills the declared variables. Throws InputError with *all* problems, one sentence each:
  //   deck.toml:12: dem.skn is not a parameter; did you mean dem.skin?
  //   deck.toml:14: ground.layer[1].young = -5 must be above 0 Pa
  //   deck.toml: load.file "x.csv" does not exist          (no line if the key is absent)
  //   command line: dem.safety = "high" must be a number
  // Unknown keys, wrong types, out of range, missing required, bad choices, failed rules, files.
  // Returns warnings, sentences of the same form about values that are allowed but unusual.
  std::vector<std::string> fill(const Declaration& declaration) const;
  // `file:line: key` of a parameter, the start of a message about it in later checks (unstable
  // step).
  std::string where(const std::string& key) const;
  // A sentence of a module that has no access to the deck: if it begins with the key of a section
  // or parameter, with the position of this.
  std::string located(const std::string& sentence) const;
  bool sets(const std::string& key) const;  // whether the deck sets the parameter

 private:
  struct Text;
  explicit Deck(std::unique_ptr<Text> text);
  std::unique_ptr<Text> text_;
};

// All parameters with their current values as a deck, which reads back to the same values (numbers
// with 17 digits): the effective input stored in every result.
std::string effective(const Declaration& declaration);
// Whether a section, such as PadParameters, differs from its default: every parameter is compared,
// as text.
template <class T>
bool differs_from_default(T section, T none = {}) {
  const auto text = [](T& of) { return effective([&of](Section& s) { of.declare(s); }); };
  return text(section) != text(none);
}
// List of the sections; "all": Markdown reference (docs/input.md); for one section path the same on
// a terminal.
// Throws InputError with the nearest name if `section` does not exist.
std::string describe(const Declaration& declaration, const std::string& section = "");
// JSON schema, draft 2020-12.
std::string schema(const Declaration& declaration);
// The name of `known` nearest to `wrong` (edit distance), or empty if none is near.
std::string nearest(const std::string& wrong, const std::vector<std::string>& known);
// Every scalar parameter: for suggestions, for the comparison of decks on resume, and for tests
// that visit all of them.
struct ParameterInfo {
  std::string path, kind, unit, meaning;  // path: "ground.layer[].young"
  StateParts fixed_by = state::none;
};
std::vector<ParameterInfo> all_parameters(const Declaration& declaration);

}  // namespace trackbed::input
