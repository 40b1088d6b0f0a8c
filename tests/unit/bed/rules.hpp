// Visits a declaration like the reader of decks and stores the rules that do not hold.
#pragma once

#include <set>
#include <string>

#include "trackbed/input/section.hpp"

namespace trackbed {

class BrokenRules : public input::Section {
 public:
  template <class T>
  static std::set<std::string> of(T parameters) {
    BrokenRules section;
    parameters.declare(section);
    return section.broken_;
  }
  void number(std::string_view, double&, const input::Limits&, std::string_view) override {}
  void integer(std::string_view, std::int64_t&, const input::Limits&, std::string_view) override {}
  void flag(std::string_view, bool&, std::string_view) override {}
  void text(std::string_view, std::string&, std::string_view, const std::vector<std::string_view>&,
            bool) override {}
  void file(std::string_view, std::string&, std::string_view, input::FileRole) override {}
  void numbers(std::string_view, std::vector<double>&, const input::Limits&, std::string_view,
               std::size_t) override {}
  void texts(std::string_view, std::vector<std::string>&, std::string_view) override {}
  void rule(std::string_view name, bool holds, std::string_view, const input::About&) override {
    if (!holds) broken_.emplace(name);
  }

 protected:
  bool enter(std::string_view, std::string_view) override { return true; }
  std::optional<std::size_t> enter_list(std::string_view, std::string_view,
                                        std::size_t present) override {
    return present;
  }
  void enter_element(std::size_t) override {}
  void leave() override {}

 private:
  std::set<std::string> broken_;
};

}  // namespace trackbed
