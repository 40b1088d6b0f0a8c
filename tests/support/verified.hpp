// Figures of verification cases. Each is checked where it is measured, and kept as a row that
// tests/verify/table.py makes docs/verification.md of: what the page says, a test has seen.
#pragma once

#include <source_location>
#include <string>

namespace trackbed::verified {

using Place = std::source_location;

// All in `unit` (SI; "-" for ratios). `quantity` tells rows of one test apart. As EXPECT_NEAR, _LT
// and _GT; values must be the same on all ranks.
void near(const std::string& quantity, const std::string& unit, double measured, double reference,
          double tolerance, const Place& place = Place::current());
void below(const std::string& quantity, const std::string& unit, double measured, double limit,
           const Place& place = Place::current());
void above(const std::string& quantity, const std::string& unit, double measured, double limit,
           const Place& place = Place::current());

}  // namespace trackbed::verified
