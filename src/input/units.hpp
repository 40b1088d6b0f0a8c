// Values with a unit, "120 km/h", in the unit of a parameter: for messages. Private to the module.
#pragma once

#include <optional>
#include <string_view>

namespace trackbed::input {

// The value of `text` (a number, then a unit) in `unit`; empty if it is of another form or the unit
// is not one of the same quantity.
std::optional<double> in_unit(std::string_view text, std::string_view unit);

}  // namespace trackbed::input
