// A small CSV reader: numbers only, so cells contain no commas and need no escaping. A bad row is
// recorded and reading continues, so that a user corrects a table once.
//
// Rejected: a CSV library, whose quoting, dialects and types are not needed. Cost: one pass over
// the text.
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

// Spreadsheets write it at the start of UTF-8 text (U+FEFF); it would become part of the first
// name.
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

std::string_view stripped(std::string_view text) {
  // Quotes around a name or number are allowed.
  const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// An empty last cell counts: a row that ends with a comma has one more column. Cells are views of
// the line: a profile of some kilometres has millions of them.
void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.push_back(stripped(line.substr(begin, end - begin)));
    begin = end + 1;
  }
}

// from_chars, not strtod: the decimal point must not depend on the user's locale. It rejects a
// leading plus, which spreadsheets write. NaN and infinity, which from_chars accepts, are rejected.
bool is_number(std::string_view cell, double& value) {
  const char* begin = cell.data() + (cell.starts_with('+') ? 1 : 0);
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  return error == std::errc() && stop == end && std::isfinite(value);
}

// Columns are found by name, since tables may have additional columns in any order.
struct Table {
  std::string path;
  std::vector<std::string> names;  // of the required columns
  std::string rising;              // column whose values must increase; empty: none
  std::vector<std::size_t> places{};
  std::size_t width = 0;  // columns of the file
  std::vector<std::vector<double>> columns{};
  std::vector<int> lines{};  // of the file, of each row
  std::vector<std::string> problems{};
  std::vector<std::string_view> cells{};  // of the present line

  // Spreadsheets in languages whose decimal sign is a comma put semicolons between columns.
  // Reported once, for the first line, since every row has the same problem. Returns whether it
  // has.
  bool has_other_separators(int line, std::string_view text) {
    const std::size_t at = text.find_first_of(";\t");
    if (at == text.npos || text.find(',') != text.npos) return false;
    problems.push_back(
        fmt::format("{}:{}: has {} between columns; use commas between columns and "
                    "points as decimal signs",
                    path, line, text[at] == ';' ? "semicolons" : "tabs"));
    return true;
  }

  // Names must match exactly; the nearest one is suggested otherwise.
  void header(int line, std::string_view text) {
    split(text, cells);
    const std::vector<std::string> found(cells.begin(), cells.end());
    width = found.size();
    for (const std::string& name : names) {
      const auto at = std::find(found.begin(), found.end(), name);
      // A missing column has the index one past the last, which `row` skips.
      places.push_back(static_cast<std::size_t>(at - found.begin()));
      if (at != found.end()) continue;
      const std::string near = nearest(name, found);
      problems.push_back(fmt::format(
          "{}:{}: there is no column {}{}", path, line, name,
          near.empty() ? "" : fmt::format("; rename column {} if it contains these values", near)));
    }
  }

  // After a problem columns may differ in length; they are then discarded by the exception.
  void row(int line, std::string_view text) {
    split(text, cells);
    // A missing cell would shift all that follow it, so the row is not read.
    if (cells.size() != width) {
      problems.push_back(
          fmt::format("{}:{}: has {} columns, but the line with the names of the columns has {}; "
                      "give each row {} columns",
                      path, line, cells.size(), width, width));
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
      problems.push_back(
          fmt::format("{}:{}: {} must increase from row to row, but {:g} follows {:g}", path, line,
                      rising, value, column.back()));
  }
};

}  // namespace

// Local: each rank reads the file. Empty lines and lines that begin with '#' are skipped; the first
// other line names the columns.
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
