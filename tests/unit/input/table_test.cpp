#include "trackbed/input/table.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "trackbed/core/error.hpp"

namespace trackbed::input::table_test {
namespace {

using Columns = std::vector<std::vector<double>>;
using Sentences = std::vector<std::string>;

class Csv {
 public:
  explicit Csv(const std::string& text) { std::ofstream("table_test.csv") << text; }
  ~Csv() { std::remove("table_test.csv"); }
  Columns read(const Sentences& columns, const std::string& rising = "") const {
    return read_table("table_test.csv", columns, rising);
  }
  Sentences problems(const Sentences& columns, const std::string& rising = "") const {
    try {
      read(columns, rising);
    } catch (const InputError& error) {
      return error.problems();
    }
    return {};
  }
};

TEST(Table, ReadsNamedColumnsInTheRequestedOrder) {
  const Csv csv("# seat loads\ntime, note ,load\r\n0, 1, 2.5\n\n1e-3,2,-4e3\n\"2\",3,+1\n");
  EXPECT_EQ(csv.read({"load", "time"}), (Columns{{2.5, -4000, 1}, {0, 0.001, 2}}));
  std::vector<int> lines;
  read_table("table_test.csv", {"time"}, "", &lines);
  EXPECT_EQ(lines, (std::vector<int>{3, 5, 6}));
}

// The byte order mark of UTF-8 that spreadsheets write at the start.
TEST(Table, SkipsAByteOrderMark) {
  const std::string mark = "\xEF\xBB\xBF";
  EXPECT_EQ(Csv(mark + "time,load\r\n0,1\r\n").read({"time", "load"}), (Columns{{0}, {1}}));
  EXPECT_EQ(Csv(mark + "\"time\",load\n0,1\n").read({"time"}), Columns{{0}});
  EXPECT_EQ(Csv(mark + "# loads\ntime\n2\n").read({"time"}), Columns{{2}});
  EXPECT_EQ(Csv(mark).problems({"time"}), Sentences{"table_test.csv: is empty"});
}

TEST(Table, ReportsAllProblemsAtOnce) {
  const Csv csv("time,laod\n0,1\n1\n2,x\n3,\n4,nan\n5,6,7\n");
  EXPECT_EQ(csv.problems({"time", "load"}),
            (Sentences{"table_test.csv:1: there is no column load; rename column laod if it "
                       "contains these values",
                       "table_test.csv:3: has 1 columns, but the line with the names of the "
                       "columns has 2; give each row 2 columns",
                       "table_test.csv:7: has 3 columns, but the line with the names of the "
                       "columns has 2; give each row 2 columns"}));
  EXPECT_EQ(csv.problems({"laod"}),
            (Sentences{"table_test.csv:3: has 1 columns, but the line with the names of the "
                       "columns has 2; give each row 2 columns",
                       "table_test.csv:4: laod = \"x\" must be a number",
                       "table_test.csv:5: laod = \"\" must be a number",
                       "table_test.csv:6: laod = \"nan\" must be a number",
                       "table_test.csv:7: has 3 columns, but the line with the names of the "
                       "columns has 2; give each row 2 columns"}));
  EXPECT_EQ(Csv("").problems({"a"}), Sentences{"table_test.csv: is empty"});
  EXPECT_THROW(read_table("no_such.csv", {"a"}), InputError);
}

// Spreadsheets in languages with decimal commas: one message, not one per row.
TEST(Table, RequiresCommasBetweenColumns) {
  const std::string words =
      " between columns; use commas between columns and points as decimal signs";
  EXPECT_EQ(Csv("# loads\ntime;load\n0,5;1\n0,6;2\n").problems({"time", "load"}),
            Sentences{"table_test.csv:2: has semicolons" + words});
  EXPECT_EQ(Csv("time\tload\n0\t1\n").problems({"time", "load"}),
            Sentences{"table_test.csv:1: has tabs" + words});
  EXPECT_EQ(Csv("time,note;load\n0,1\n").read({"time"}), Columns{{0}});
}

TEST(Table, ReportsRowsThatDoNotIncrease) {
  const Csv csv("load,time\n1,0\n1,0.2\n# later\n1,0.1\n1,0.1\n1,0.3\n");
  EXPECT_EQ(csv.problems({"time", "load"}), Sentences{});
  EXPECT_EQ(
      csv.problems({"time", "load"}, "time"),
      (Sentences{"table_test.csv:5: time must increase from row to row, but 0.1 follows 0.2",
                 "table_test.csv:6: time must increase from row to row, but 0.1 follows 0.1"}));
}

}  // namespace
}  // namespace trackbed::input::table_test
