// The Section that fills variables from a deck's tree and collects all problems. Private to the
// module.
//
// A declaration calls number(), table(), rule() ... in its own order. Each call looks its name up
// in the open section, checks the value, and writes the variable or adds a problem. Names in a
// section that no call looked up are unknown and are reported when the section is left.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "input/problems.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::input {

// One visit per object. Refers to the tree and to `problems`, which must outlive it.
class Reader : public Section {
 public:
  // `folder`: base of relative file names. `paths`: all parameters, for suggestions.
  Reader(const Node& root, std::string folder, std::vector<ParameterInfo> paths,
         Problems& problems);
  // To be called before the visit: files that the run started from need not exist.
  void accept_missing_origins() { accepts_missing_origins_ = true; }
  // To be called after the visit: reports unknown names at the top of the deck.
  void finish();

  void number(std::string_view name, double& value, const Limits& limits,
              std::string_view meaning) override;
  void integer(std::string_view name, std::int64_t& value, const Limits& limits,
               std::string_view meaning) override;
  void flag(std::string_view name, bool& value, std::string_view meaning) override;
  void text(std::string_view name, std::string& value, std::string_view meaning,
            const std::vector<std::string_view>& choices, bool required) override;
  void file(std::string_view name, std::string& value, std::string_view meaning,
            FileRole role) override;
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
  // An open section. Sections nest as the calls do, so a stack holds the state of the visit.
  struct Frame {
    std::string path;                // "ground.layer[1]"
    const Node* node = nullptr;      // null: not in the file
    std::vector<std::string> known;  // names looked up
    std::size_t problems_before = 0;
    std::map<std::string, std::string> early = {};  // name not looked up yet -> rule that reads it
  };
  // An unknown name. Its suggestion is made after the visit, when all sections of the deck's model
  // are known.
  struct Unknown {
    const Node* node;
    std::string section, name;
    std::vector<std::string> known;  // names of that section
    std::size_t problem;             // index of its message
    std::string path() const { return section.empty() ? name : section + "." + name; }
  };
  // The value of a parameter of the open section, or null; marks the name as known.
  const Node* find(std::string_view name);
  std::string path_of(std::string_view name) const;
  void problem(const Node* place, const std::string& path, const std::string& rest);
  bool has_rejected(const About& about) const;
  void note_early_reads(std::string_view rule, const About& about);
  // Of a parameter that the file does not set, for rules about it.
  void keep_default(std::string_view name, const Node& value);
  // "dem.skin = 5 must be ..."
  void reject(const Node& node, const std::string& path, const std::string& must);
  void missing(std::string_view name, const std::string& unit);
  // Checks type, finiteness and limits; if one fails, adds a problem about `node` and returns
  // false.
  bool take_number(const Node& node, const std::string& path, const Limits& limits, double& value);
  void report_unknown(const Frame& frame);
  std::string describe_unknown(const Unknown& unknown) const;
  bool is_a_name(const std::string& word) const;  // of a parameter of any section
  bool gives_section_of(const std::string& path) const;
  std::string suggestion(const Unknown& unknown) const;
  void open(Frame frame);

  std::string folder_;
  bool accepts_missing_origins_ = false;
  std::vector<ParameterInfo> paths_;
  Problems& problems_;
  std::vector<Frame> open_;
  std::vector<Unknown> unknown_;
  std::vector<std::string> sections_;  // names known at the top of the deck, after the visit
  const Node* root_ = nullptr;         // of the deck, after the visit
  std::map<std::string, std::string> defaults_;  // path -> value as shown
  // A rule is skipped if it uses one of these.
  std::vector<std::string> rejected_;  // paths of rejected values
};

}  // namespace trackbed::input
