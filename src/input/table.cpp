// A small CSV reader: numbers only, so cells hold no commas and need no escaping. A bad row is
// noted and reading goes on, so that a user repairs a table once.
//
// A library for CSV would bring quoting, dialects and types that no table of ours has. Cost: one
// pass over the text.
#include "trackbed/input/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

#include "trackbed/core/error.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::input {

namespace {

// Spreadsheets put it in front of a text in UTF-8 (U+FEFF); it would become part of the first name.
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

std::string_view stripped(std::string_view text) {
  // Quotes around a name or number are allowed.
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// An empty last cell counts: a row that ends with a comma has one column more. Views of the line: a
// profile of some kilometres has millions of cells.
void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.push_back(stripped(line.substr(begin, end - begin)));
    begin = end + 1;
  }
}

// from_chars, not strtod: the decimal point must not hang on the user's locale. It refuses a
// leading plus, which spreadsheets write.
// NaN and infinity, which from_chars takes, are no numbers of a table.
bool is_number(std::string_view cell, double& value) {
  const char* begin = cell.data() + (cell.starts_with('+') ? 1 : 0);
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  return error == std::errc() && stop == end && std::isfinite(value);
}

// Columns are found by name: tables of others have columns in their own order, and more of them.
struct Table {
  std::string path;
  std::vector<std::string> names;  // of the columns asked for
  std::string rising;              // of the one whose values must rise; empty: none
  std::vector<std::size_t> places{};
  std::size_t width = 0;  // columns of the file
  std::vector<std::vector<double>> columns{};
  std::vector<int> lines{};  // of the file, of each row
  std::vector<std::string> problems{};
  std::vector<std::string_view> cells{};  // of the present line

  // Spreadsheets of languages whose decimal sign is a comma put semicolons between columns. Said
  // once, of the first line: every row would be wrong in the same way. Whether it is so.
  bool has_other_separators(int line, std::string_view text) {
    const std::size_t at = text.find_first_of(";\t");
    if (at == text.npos || text.find(',') != text.npos) return false;
    problems.push_back(
        fmt::format("{}:{}: has {} between columns; commas are wanted there, and "
                    "points as decimal signs",
                    path, line, text[at] == ';' ? "semicolons" : "tabs"));
    return true;
  }

  // Names are compared letter by letter; a near one is suggested.
  void header(int line, std::string_view text) {
    split(text, cells);
    const std::vector<std::string> found(cells.begin(), cells.end());
    width = found.size();
    for (const std::string& name : names) {
      const auto at = std::find(found.begin(), found.end(), name);
      // Of a missing column: one past the last, by which `row` knows it.
      places.push_back(static_cast<std::size_t>(at - found.begin()));
      if (at != found.end()) continue;
      const std::string near = nearest(name, found);
      problems.push_back(fmt::format("{}:{}: there is no column {}{}", path, line, name,
                                     near.empty() ? "" : fmt::format("; is it {}?", near)));
    }
  }

  // After a problem columns may differ in length: they are then thrown away with the exception.
  void row(int line, std::string_view text) {
    split(text, cells);
    // A cell too few would shift all that follow it: the row is not read at all.
    if (cells.size() != width) {
      problems.push_back(fmt::format("{}:{}: has {} columns, the first line has {}", path, line,
                                     cells.size(), width));
      return;
    }
    lines.push_back(line);
    for (std::size_t c = 0; c < names.size(); ++c) {
      if (places[c] == width) continue;  // the missing column has been reported
      double value = 0;
      if (is_number(cells[places[c]], value)) {
        if (names[c] == rising) compare(line, columns[c], value);
        columns[c].push_back(value);
      } else {
        problems.push_back(fmt::format("{}:{}: {} = \"{}\" must be a number", path, line, names[c],
                                       cells[places[c]]));
      }
    }
  }

  void compare(int line, const std::vector<double>& column, double value) {
    if (!column.empty() && value <= column.back())
      problems.push_back(fmt::format("{}:{}: {} must rise from row to row, but {:g} follows {:g}",
                                     path, line, rising, value, column.back()));
  }
};

}  // namespace

// Local: each rank reads the file. Empty lines and lines that begin with '#' are passed over; the
// first other line names the columns.
std::vector<std::vector<double>> read_table(const std::string& path,
                                            const std::vector<std::string>& columns,
                                            const std::string& rising, std::vector<int>* lines) {
  std::ifstream in(path);
  if (!in) throw InputError({fmt::format("{}: cannot be read", path)});
  // All problems of the table in one error, as for decks.
  Table table{path, columns, rising};
  table.columns.resize(columns.size());
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    if (line == 1 && text.starts_with(byte_order_mark)) text.erase(0, byte_order_mark.size());
    const std::string_view content = stripped(text);
    if (content.empty() || content.starts_with('#')) continue;
    if (table.width == 0 && table.has_other_separators(line, content)) break;
    if (table.width == 0)
      table.header(line, text);
    else
      table.row(line, text);
  }
  if (table.width == 0 && table.problems.empty())
    table.problems.push_back(fmt::format("{}: is empty", path));
  if (!table.problems.empty()) throw InputError(std::move(table.problems));
  if (lines != nullptr) *lines = std::move(table.lines);
  return std::move(table.columns);
}

}  // namespace trackbed::input
