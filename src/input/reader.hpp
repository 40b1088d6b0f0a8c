// The Section that fills variables from a deck's tree and notes every problem. Private to the room.
//
// How it works: a declaration calls number(), table(), rule() ... in its own order; each call looks
// its name up in the open section, checks what it finds, and writes the variable or notes a
// problem. What a section holds beyond the names asked for is unknown and is reported when it is
// left.
#pragma once

#include <string>
#include <vector>

#include "input/problems.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::input {

// One visit per object. Refers to the tree and to `problems`, which must outlive it.
class Reader : public Section {
 public:
  // `folder`: where relative file names start. `paths`: all parameters, for suggestions.
  Reader(const Node& root, std::string folder, std::vector<ParameterInfo> paths,
         Problems& problems);
  // Before the visit: files that the run began with are not looked for.
  void take_origins_as_they_are() { origins_as_they_are_ = true; }
  // After the visit: what the file has at its top that nobody asked for.
  void finish();

  void number(std::string_view name, double& value, const Limits& limits,
              std::string_view meaning) override;
  void integer(std::string_view name, std::int64_t& value, const Limits& limits,
               std::string_view meaning) override;
  void flag(std::string_view name, bool& value, std::string_view meaning) override;
  void text(std::string_view name, std::string& value, std::string_view meaning,
            const std::vector<std::string_view>& choices, bool required) override;
  void file(std::string_view name, std::string& value, std::string_view meaning,
            Named named) override;
  void numbers(std::string_view name, std::vector<double>& values, const Limits& limits,
               std::string_view meaning, std::size_t length) override;
  void texts(std::string_view name, std::vector<std::string>& values,
             std::string_view meaning) override;
  void rule(std::string_view name, bool holds, std::string_view sentence,
            const About& about) override;

 protected:
  bool enter(std::string_view name, std::string_view meaning) override;
  std::optional<std::size_t> enter_list(std::string_view name, std::string_view meaning,
                                        std::size_t present) override;
  void enter_element(std::size_t index) override;
  void leave() override;

 private:
  // An open section. Sections nest as the calls do, so a stack of them is where the visit is.
  struct Frame {
    std::string path;                // "ground.layer[1]"
    const Node* node = nullptr;      // null: not in the file
    std::vector<std::string> known;  // names asked for so far
    std::size_t problems_before = 0;
  };
  // A name that nobody asked for. What may have been meant is known after the visit: sections of
  // the deck's model, which its end alone knows all, and no others.
  struct Unknown {
    const Node* node;
    std::string section, name;
    std::vector<std::string> known;  // names of that section
    std::size_t problem;             // number of its sentence
    std::string path() const { return section.empty() ? name : section + "." + name; }
  };
  // The value of a parameter of the open section, or null; notes that it is known.
  const Node* find(std::string_view name);
  std::string path_of(std::string_view name) const;
  void problem(const Node* place, const std::string& path, const std::string& rest);
  bool in_doubt(const About& about) const;
  // "dem.skin = 5 must be ..."
  void refuse(const Node& node, const std::string& path, const std::string& must);
  void missing(std::string_view name, const std::string& unit);
  // Checks type, finiteness and limits; says what is wrong with `node` and returns false.
  bool take_number(const Node& node, const std::string& path, const Limits& limits, double& value);
  void report_unknown(const Frame& frame);
  std::string what_it_is_not(const Unknown& unknown) const;
  std::string suggestion(const Unknown& unknown) const;
  void open(Frame frame);

  std::string folder_;
  bool origins_as_they_are_ = false;
  std::vector<ParameterInfo> paths_;
  Problems& problems_;
  std::vector<Frame> open_;
  std::vector<Unknown> unknown_;
  std::vector<std::string> sections_;  // names known at the top, once the visit is over
  // A rule asks this list whether what it reads can be trusted.
  std::vector<std::string> refused_;  // paths of values that were not taken
};

}  // namespace trackbed::input
