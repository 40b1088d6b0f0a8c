// Problems of a deck, collected while it is read and reported all at once. Private to the module.
#pragma once

#include <string>
#include <vector>

#include "input/tree.hpp"

namespace trackbed::input {

// The end of a message about an unknown word; empty if no name is near.
inline std::string did_you_mean(const std::string& word) {
  return word.empty() ? "" : "; did you mean " + word + "?";
}

// Copied with the deck's own problems for each reading, so that a deck can be read repeatedly.
class Problems {
 public:
  explicit Problems(std::string origin) : origin_(std::move(origin)) {}

  // `origin:line: ` or `command line: `; `place` may be null (no location in the text).
  std::string start(const Node* place) const;
  void add(const Node* place, const std::string& sentence);
  // Appends to sentence `number`, counted from 0.
  void append(std::size_t number, const std::string& words) { list_.at(number).sentence += words; }
  void warn(const Node* place, const std::string& sentence);
  // In the order of `throw_if_any`.
  std::vector<std::string> warnings() const { return sorted(warnings_); }
  std::size_t count() const { return list_.size(); }
  // In the order of the file, then those without a line, then those of the command line. Throws
  // InputError.
  void throw_if_any() const;

 private:
  struct Problem {
    int order;
    std::string sentence;
  };
  Problem located(const Node* place, const std::string& sentence) const;
  static std::vector<std::string> sorted(std::vector<Problem> list);

  std::string origin_;
  std::vector<Problem> list_, warnings_;
};

}  // namespace trackbed::input
