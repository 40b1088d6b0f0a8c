// Results of verification cases. Each is checked where it is measured, and stored as a row from
// which tests/verify/table.py makes docs/verification.md: every number in that document has been
// tested.
#pragma once

#include <source_location>
#include <string>

namespace trackbed::verified {

using Place = std::source_location;

// All in `unit` (SI; "-" for ratios). `quantity` distinguishes rows of one test. As EXPECT_NEAR,
// _LT and _GT; values must be the same on all ranks.
void near(const std::string& quantity, const std::string& unit, double measured, double reference,
          double tolerance, const Place& place = Place::current());
void below(const std::string& quantity, const std::string& unit, double measured, double limit,
           const Place& place = Place::current());
void above(const std::string& quantity, const std::string& unit, double measured, double limit,
           const Place& place = Place::current());

}  // namespace trackbed::verified
