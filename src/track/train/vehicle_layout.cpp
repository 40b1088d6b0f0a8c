#include "trackbed/track/vehicle_layout.hpp"

#include <algorithm>

namespace trackbed::track {

namespace {

constexpr int count_of_kinds = static_cast<int>(VehicleKind::of_like) + 1;  // the last one

std::string_view name_of_kind(VehicleKind kind) {
  switch (kind) {
    case VehicleKind::coach:
      return "coach";
    case VehicleKind::sprung:
      return "sprung";
    case VehicleKind::wheel:
      return "wheel";
    case VehicleKind::forces:
      return "forces";
    case VehicleKind::bogie:
      return "bogie";
    case VehicleKind::of_like:
      return "";
  }
  return "";
}

constexpr VehicleLayout layout_of_kind(VehicleKind kind) {
  switch (kind) {
    case VehicleKind::of_like:  // until it is completed
    case VehicleKind::coach:
      return {.body = true, .pitches = true, .bogies = 2, .wheelsets = 4};
    case VehicleKind::bogie:
      return {.body = true, .bogies = 1, .wheelsets = 2};
    case VehicleKind::sprung:
      return {.body = true, .wheelsets = 1};
    case VehicleKind::wheel:
      return {.wheelsets = 1};
    case VehicleKind::forces:
      return {.constant = true};
  }
  return {};
}

// As listed in vehicle_layout.hpp.
constexpr bool layout_is_possible(const VehicleLayout& layout) {
  if (layout.constant || !layout.body)
    return !layout.body && !layout.pitches && layout.bogies == 0 &&
           layout.wheelsets == (layout.constant ? 0 : 1);
  return layout.wheelsets == std::max(1, 2 * layout.bogies) &&
         (layout.bogies > 1 || !layout.pitches);
}

constexpr bool layouts_are_possible() {
  for (int kind = 0; kind < count_of_kinds; ++kind)
    if (!layout_is_possible(layout_of_kind(static_cast<VehicleKind>(kind)))) return false;
  return true;
}
static_assert(layouts_are_possible(), "Train builds only the layouts listed in vehicle_layout.hpp");

}  // namespace

VehicleLayout layout_of(VehicleKind kind) { return layout_of_kind(kind); }

std::vector<std::string_view> vehicle_kinds() {
  std::vector<std::string_view> names;
  for (int kind = 0; kind < count_of_kinds; ++kind)
    names.push_back(name_of_kind(static_cast<VehicleKind>(kind)));
  return names;
}

std::vector<double> axles_of(const VehicleParameters& v) {
  const VehicleLayout layout = layout_of(v.kind);
  if (layout.constant) return v.axles;
  if (layout.bogies == 0) return {v.length / 2};
  if (layout.bogies == 1) return {v.length / 2 - v.wheelbase / 2, v.length / 2 + v.wheelbase / 2};
  const double front = v.length / 2 - (layout.bogies - 1) * v.bogie_distance / 2 - v.wheelbase / 2;
  std::vector<double> axles;
  for (int bogie = 0; bogie < layout.bogies; ++bogie)
    for (const double behind : {0.0, v.wheelbase})
      axles.push_back(front + bogie * v.bogie_distance + behind);
  return axles;
}

// Axle forces begin at the front.
double axle_span_of(const VehicleParameters& v) {
  const VehicleLayout layout = layout_of(v.kind);
  if (layout.constant)
    return v.axles.empty() ? 0 : *std::max_element(v.axles.begin(), v.axles.end());
  return layout.bogies > 0 ? (layout.bogies - 1) * v.bogie_distance + v.wheelbase : 0;
}

double mass_of(const VehicleParameters& v) {
  const VehicleLayout layout = layout_of(v.kind);
  return (layout.body ? v.body_mass : 0) + layout.bogies * v.bogie_mass +
         layout.wheelsets * v.wheelset_mass;
}

}  // namespace trackbed::track
