// Words end at blanks; numbers are read by from_chars, which is independent of the locale.
#include "fem/mesh/gmsh_words.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

// The word as found, printable on a terminal.
std::string shown(std::string_view word) {
  constexpr std::size_t most = 24;
  std::string text(word.substr(0, most));
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return word.size() > most ? text + "..." : text;
}

}  // namespace

void Words::fail(std::string_view sentence) const {
  throw InputError({fmt::format("{}:{}: {}", path_, line_, sentence)});
}

bool Words::more() {
  for (; at_ < text_.size() && is_blank(text_[at_]); ++at_)
    if (text_[at_] == '\n') ++next_line_;
  return at_ < text_.size();
}

std::string_view Words::next() {
  const bool there = more();
  line_ = next_line_;
  if (!there) fail("the file ends too early; is it complete?");
  const std::size_t begin = at_;
  while (at_ < text_.size() && !is_blank(text_[at_])) ++at_;
  return text_.substr(begin, at_ - begin);
}

Id Words::integer(std::string_view what) {
  const std::string_view word = next();
  Id value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size())
    fail(fmt::format("\"{}\" was found where {} is expected", shown(word), what));
  return value;
}

double Words::number(std::string_view what) {
  const std::string_view word = next();
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    fail(fmt::format("\"{}\" was found where {} is expected", shown(word), what));
  return value;
}

// Each item takes at least two characters: a wrong count must not allocate all memory.
std::size_t Words::count(std::string_view what) {
  const Id value = integer(fmt::format("the number of {}", what));
  const std::size_t rest = text_.size() - at_;
  if (value < 0 || static_cast<std::size_t>(value) > rest / 2)
    fail(
        fmt::format("{} {} are declared, more than the remaining file can contain; is it complete?",
                    value, what));
  return static_cast<std::size_t>(value);
}

std::string Words::quoted() {
  const bool there = more();
  line_ = next_line_;
  if (!there || text_[at_] != '"') fail("a name in quotes is expected here");
  const std::size_t end = text_.find_first_of("\"\n", at_ + 1);
  if (end == text_.npos || text_[end] != '"') fail("a name in quotes is not closed");
  std::string name(text_.substr(at_ + 1, end - at_ - 1));
  at_ = end + 1;
  return name;
}

void Words::expect(std::string_view word) {
  const std::string_view found = next();
  if (found != word) fail(fmt::format("\"{}\" was found where {} is expected", shown(found), word));
}

void Words::skip_to(std::string_view word, std::size_t begin) {
  while (more())
    if (next() == word) return;
  fail(fmt::format("the section that begins in line {} has no {}; is the file complete?", begin,
                   word));
}

}  // namespace trackbed::fem
