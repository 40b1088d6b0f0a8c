// A text as words, each with its line, for the reader of mesh files. Whatever the bytes are, the
// answer is a word, a number or a sentence (InputError).
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
  // `what` says in messages what should stand here.
  Id integer(std::string_view what);
  double number(std::string_view what);  // finite
  // How many of something follow: not below 0, and no more than the rest of the text can hold.
  std::size_t count(std::string_view what);
  std::string quoted();  // between quotes, on one line
  // The word that must come next; `section` began in line `begin`.
  void expect(std::string_view word);
  // Passes over everything up to and with the word.
  void skip_to(std::string_view word, std::size_t begin);

  std::size_t line() const { return line_; }  // of the last word
  [[noreturn]] void fail(std::string_view sentence) const;

 private:
  std::string_view text_;
  std::string path_;
  std::size_t at_ = 0, line_ = 1, next_line_ = 1;
};

}  // namespace trackbed::fem
