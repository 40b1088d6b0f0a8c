// Units that are usual beside those of the parameters.
#include "input/units.hpp"

#include <array>
#include <charconv>
#include <string>

namespace trackbed::input {

namespace {

// 1 `name` = `times` / `over` of `unit`; a quotient, so that decimal factors are exact.
struct Unit {
  std::string_view name, unit;
  double times, over = 1;
};

constexpr std::array<Unit, 34> units{
    {{"mm", "m", 1, 1000},     {"cm", "m", 1, 100},      {"km", "m", 1000},
     {"km/h", "m/s", 10, 36},  {"kmh", "m/s", 10, 36},   {"kph", "m/s", 10, 36},
     {"mm/s", "m/s", 1, 1000}, {"kPa", "Pa", 1e3},       {"MPa", "Pa", 1e6},
     {"GPa", "Pa", 1e9},       {"kN/m2", "Pa", 1e3},     {"MN/m2", "Pa", 1e6},
     {"N/mm2", "Pa", 1e6},     {"kN", "N", 1e3},         {"MN", "N", 1e6},
     {"N/mm", "N/m", 1e3},     {"kN/m", "N/m", 1e3},     {"kN/mm", "N/m", 1e6},
     {"MN/m", "N/m", 1e6},     {"kN s/m", "N s/m", 1e3}, {"kNs/m", "N s/m", 1e3},
     {"Ns/m", "N s/m", 1},     {"t", "kg", 1e3},         {"g", "kg", 1, 1000},
     {"t/m3", "kg/m3", 1e3},   {"g/cm3", "kg/m3", 1e3},  {"ms", "s", 1, 1000},
     {"us", "s", 1, 1000000},  {"min", "s", 60},         {"h", "s", 3600},
     {"kHz", "Hz", 1e3},       {"deg", "degrees", 1},    {"cm4", "m4", 1, 1e8},
     {"cm2", "m2", 1, 1e4}}};

// "t/m^3" and "t/m³" are "t/m3".
std::string plain(std::string_view unit) {
  std::string text(unit);
  for (const auto& [from, to] : {std::pair<std::string_view, std::string_view>{"^", ""},
                                 {"²", "2"},
                                 {"³", "3"},
                                 {"µ", "u"},
                                 {"°", "degrees"}})
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos;)
      text.replace(at, from.size(), to);
  return text;
}

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

}  // namespace

std::optional<double> in_unit(std::string_view text, std::string_view unit) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return {};
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  const std::string given = plain(trimmed(text)), wanted = plain(unit);
  if (given == wanted) return value;
  for (const Unit& known : units)
    if (known.name == given && known.unit == wanted) return value * known.times / known.over;
  return {};
}

}  // namespace trackbed::input
