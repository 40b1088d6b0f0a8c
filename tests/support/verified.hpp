// Results of verification cases. Each is checked where it is measured, and stored as a row from
// which tests/verify/table.py makes docs/verification.md: every number in that document has been
// tested, and every tolerance has a reason, which is its last column.
#pragma once

#include <cmath>
#include <cstddef>
#include <source_location>
#include <string>

namespace trackbed::verified {

using Place = std::source_location;

// Why a tolerance has its size: an estimate of the error (scheme, element, step, rounding), the
// digits of a published value, or what a limit separates. A short phrase, without | and tabs, which
// separate columns. An empty one does not compile.
class Reason {
 public:
  template <std::size_t n>
  requires(n > 1) constexpr Reason(const char (&text)[n]) : text_(text) {}
  constexpr const char* text() const { return text_; }

 private:
  const char* text_;
};

// Named where it is used by several rows.
struct Tolerance {
  double size;  // in the unit of the row, or relative: see of()
  Reason reason;
  // The same fraction of `value`, whose sign does not matter.
  Tolerance of(double value) const { return {size * std::abs(value), reason}; }
};
using Limit = Tolerance;

// All in `unit` (SI; "-" for ratios). `quantity` distinguishes rows of one test. As EXPECT_NEAR,
// _LT and _GT; values must be the same on all ranks.
void near(const std::string& quantity, const std::string& unit, double measured, double reference,
          const Tolerance& tolerance, const Place& place = Place::current());
void below(const std::string& quantity, const std::string& unit, double measured,
           const Limit& limit, const Place& place = Place::current());
void above(const std::string& quantity, const std::string& unit, double measured,
           const Limit& limit, const Place& place = Place::current());

}  // namespace trackbed::verified
