// A text as words with line numbers, for the reader of mesh files. For any bytes the result is a
// word, a number or a message (InputError).
#pragma once

#include <string>
#include <string_view>

#include "trackbed/core/types.hpp"

namespace trackbed::fem {

class Words {
 public:
  Words(std::string_view text, std::string path) : text_(text), path_(std::move(path)) {}

  bool more();              // whether there is another word
  std::string_view next();  // fails at the end
  // `what` names the expected item in messages.
  Id integer(std::string_view what);
  double number(std::string_view what);  // finite
  // Number of items that follow: at least 0, and at most what the remaining text can contain.
  std::size_t count(std::string_view what);
  std::string quoted();  // between quotes, on one line
  // Fails unless this is the next word.
  void expect(std::string_view word);
  // Skips all words up to and including this one; the section began in line `begin`.
  void skip_to(std::string_view word, std::size_t begin);

  std::size_t line() const { return line_; }  // of the last word
  [[noreturn]] void fail(std::string_view sentence) const;

 private:
  std::string_view text_;
  std::string path_;
  std::size_t at_ = 0, line_ = 1, next_line_ = 1;
};

}  // namespace trackbed::fem
