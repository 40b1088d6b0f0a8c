// Problems of a deck, gathered while it is read and thrown all at once. Private to the room.
#pragma once

#include <string>
#include <vector>

#include "input/tree.hpp"

namespace trackbed::input {

class Problems {
 public:
  explicit Problems(std::string origin) : origin_(std::move(origin)) {}

  // `origin:line: ` or `command line: `; `place` may be null (nothing in the text to point at).
  std::string start(const Node* place) const;
  void add(const Node* place, const std::string& sentence);
  std::size_t count() const { return list_.size(); }
  // In the order of the file, then what has no line, then the command line. Throws InputError.
  void throw_if_any() const;

 private:
  struct Problem {
    int order;
    std::string sentence;
  };
  std::string origin_;
  std::vector<Problem> list_;
};

}  // namespace trackbed::input
