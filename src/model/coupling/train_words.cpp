#include "model/coupling/train_words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "trackbed/track/vehicle_layout.hpp"

namespace trackbed::model {

namespace {

// Frequencies show whether masses and springs were given per side, per axle or in total.
std::string words_of(const track::VehicleParameters& vehicle, bool rolls) {
  std::string text = fmt::format("  vehicle {}:", vehicle.name);
  if (track::layout_of(vehicle.kind).constant)
    return text + fmt::format(" {} axles of constant force", vehicle.axles.size());
  const std::vector<double> frequencies = track::natural_frequencies(vehicle, rolls);
  if (!frequencies.empty())
    text += fmt::format(" natural frequencies {:.4g} Hz with fixed wheelsets;",
                        fmt::join(frequencies, ", "));
  return text + fmt::format(" wheelset {:g} kg", vehicle.wheelset_mass);
}

}  // namespace

std::vector<std::string> lines_of_vehicles(const track::Train& train, bool rolls) {
  std::vector<std::string> lines, named;
  for (const track::VehicleParameters& vehicle : train.vehicles()) {
    if (std::find(named.begin(), named.end(), vehicle.name) != named.end()) continue;
    named.push_back(vehicle.name);
    lines.push_back(words_of(vehicle, rolls));
  }
  return lines;
}

}  // namespace trackbed::model
