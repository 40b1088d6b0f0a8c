// A parameter is declared once. A struct of parameters names each of its variables to a Section:
//
//   struct Skin {
//     double skin = 0.002;
//     void declare(input::Section& s) {
//       s.number("skin", skin, {.unit = "m", .above = 0}, "Reach of the neighbour list.");
//     }
//   };
//
// and that one list serves parsing, checking, `describe`, the JSON schema, docs/input.md and the
// effective input stored in every result: each is an implementation of Section that visits it.
// The value the variable holds at the visit is the default.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "trackbed/input/state_parts.hpp"

namespace trackbed::input {

inline constexpr double unbounded = std::numeric_limits<double>::infinity();

struct Limits {
  std::string_view unit = "-";
  double above = -unbounded;     // value > above
  double at_least = -unbounded;  // value >= at_least
  double at_most = unbounded;    // value <= at_most
  bool required = false;         // no default: an input without it is rejected
  // Usual range; a value outside (for instance in another unit) is accepted with a warning.
  double usually_from = -unbounded, usually_to = unbounded;
};

enum class Severity { problem, warning };  // warning: allowed but unusual

// Options of a rule.
struct About {
  Severity severity = Severity::problem;
  // Parameters and sections that the rule uses, named relative to the same section. The rule is
  // skipped if one of them was rejected, because it then still has its default. Empty: the rule is
  // skipped if the open section has a problem.
  std::vector<std::string> reads = {};
};

class Section;

// Until it ends, or `end` is called, parameters declared in the section are fixed by given parts of
// a state.
class FixedScope {
 public:
  FixedScope(Section& section, StateParts parts);
  ~FixedScope() { end(); }
  FixedScope(const FixedScope&) = delete;
  FixedScope& operator=(const FixedScope&) = delete;
  void end();

 private:
  Section* section_;
  StateParts before_;
};

// What a parameter of kind file names. origin: a file or folder that a run starts from; it need not
// exist any more when the run is resumed.
enum class FileRole { file, origin };

class Section {
 public:
  virtual ~Section() = default;

  virtual void number(std::string_view name, double& value, const Limits& limits,
                      std::string_view meaning) = 0;
  virtual void integer(std::string_view name, std::int64_t& value, const Limits& limits,
                       std::string_view meaning) = 0;
  virtual void flag(std::string_view name, bool& value, std::string_view meaning) = 0;
  // Free text; with `choices` one of those words.
  virtual void text(std::string_view name, std::string& value, std::string_view meaning,
                    const std::vector<std::string_view>& choices = {}, bool required = false) = 0;
  // A file that must exist; relative names are resolved against the deck's folder. Empty: none.
  virtual void file(std::string_view name, std::string& value, std::string_view meaning,
                    FileRole role = FileRole::file) = 0;
  // `length` 0: any length.
  virtual void numbers(std::string_view name, std::vector<double>& values, const Limits& limits,
                       std::string_view meaning, std::size_t length = 0) = 0;
  virtual void texts(std::string_view name, std::vector<std::string>& values,
                     std::string_view meaning) = 0;
  // A condition on several parameters ("top must be above bottom"). If it does not hold, it is
  // reported as a problem of parameter `name` ("top", or of an inner section "layer[1].thickness").
  // Only the reader evaluates it.
  virtual void rule(std::string_view name, bool holds, std::string_view sentence,
                    const About& about = {}) = 0;

  // Parameters declared during the returned scope cannot change when a run continues from a
  // checkpoint that contains one of `parts`, in addition to those of enclosing scopes.
  [[nodiscard]] FixedScope fixed_by(StateParts parts) { return {*this, fixed_by_ | parts}; }
  // Parameters declared during the returned scope may change, whatever the enclosing scopes.
  [[nodiscard]] FixedScope free_to_change() { return {*this, state::none}; }

  // A word of a fixed list held as an enum: `words` in the order of the enum's values from 0.
  template <class E>
  requires std::is_enum_v<E>
  void choice(std::string_view name, E& value, const std::vector<std::string_view>& words,
              std::string_view meaning) {
    std::string word(words.at(static_cast<std::size_t>(value)));
    text(name, word, meaning, words);
    for (std::size_t i = 0; i < words.size(); ++i)
      if (words[i] == word) value = static_cast<E>(i);
  }
  // A table [name]: T has `void declare(Section&)`. Absent: all its defaults.
  template <class T>
  void table(std::string_view name, T& value, std::string_view meaning) {
    if (!enter(name, meaning)) return;
    value.declare(*this);
    leave();
  }
  // An array of tables [[name]], in the order of the file. Each may have a `name` parameter, by
  // which overrides address it (`stage.passage.duration=2`), else by number from 0.
  template <class T>
  void tables(std::string_view name, std::vector<T>& values, std::string_view meaning) {
    const std::optional<std::size_t> count = enter_list(name, meaning, values.size());
    if (!count) return;
    if (*count != values.size()) values.resize(*count);
    if (describes() && values.empty()) {  // show what an element may hold
      T blank{};
      enter_element(0);
      blank.declare(*this);
      leave();
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      enter_element(i);
      values[i].declare(*this);
      leave();
    }
    leave();
  }

 protected:
  StateParts fixed_by() const { return fixed_by_; }
  virtual bool describes() const { return false; }
  virtual bool enter(std::string_view name, std::string_view meaning) = 0;
  // Returns how many elements there are (the reader: in the file), or nothing to skip the list.
  virtual std::optional<std::size_t> enter_list(std::string_view name, std::string_view meaning,
                                                std::size_t present) = 0;
  virtual void enter_element(std::size_t index) = 0;
  virtual void leave() = 0;

 private:
  friend class FixedScope;
  StateParts fixed_by_ = state::none;
};

inline FixedScope::FixedScope(Section& section, StateParts parts)
    : section_(&section), before_(section.fixed_by_) {
  section.fixed_by_ = parts;
}
inline void FixedScope::end() {
  if (section_ != nullptr) section_->fixed_by_ = before_;
  section_ = nullptr;
}

}  // namespace trackbed::input
