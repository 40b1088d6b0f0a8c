// Problems of a deck, gathered while it is read and thrown all at once. Private to the room.
#pragma once

#include <string>
#include <vector>

#include "input/tree.hpp"

namespace trackbed::input {

// The end of a sentence about a wrong word; nothing if no name is near.
inline std::string did_you_mean(const std::string& word) {
  return word.empty() ? "" : "; did you mean " + word + "?";
}

// Copied with the deck's own problems for each reading, so that a deck can be read twice.
class Problems {
 public:
  explicit Problems(std::string origin) : origin_(std::move(origin)) {}

  // `origin:line: ` or `command line: `; `place` may be null (nothing in the text to point at).
  std::string start(const Node* place) const;
  void add(const Node* place, const std::string& sentence);
  // Adds to the sentence that was the `number`-th, counted from 0.
  void append(std::size_t number, const std::string& words) { list_.at(number).sentence += words; }
  void warn(const Node* place, const std::string& sentence);
  // In the order of `throw_if_any`.
  std::vector<std::string> warnings() const { return sorted(warnings_); }
  std::size_t count() const { return list_.size(); }
  // In the order of the file, then what has no line, then the command line. Throws InputError.
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
