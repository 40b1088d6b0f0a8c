// Checks of the propagation of a wave from the deck: its time, and whether elements resolve it.
//
// Elements of height h delay a wave of length L by (2 pi h / L)^2 / 24 of its travel time (central
// differences in space with lumped masses; time steps compensate little of it). High frequencies
// arrive late, and the peak, to which all of them contribute, is lower. Measured with Ricker's
// wavelet in 10, 20 and 40 m of one layer, explicit and by Newmark, along x and z: 5 % of the peak
// are lost if the frequency below which 95 % of the energy is, arrives late by an eighth of its
// period. So a deep ground needs smaller elements: 7 per wave length at a depth of 4 lengths, 10 at
// 8 lengths (Kuhlemeyer, Lysmer 1973, doi:10.1061/JSFEAQ.0001885, recommend 8 to 10 in general).
#include "trackbed/fem/wave_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fem/boundary/wave_band.hpp"
#include "fem/time/base_motion.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::fem {

namespace {

constexpr double latest = 1.0 / 8;  // of a period
constexpr double in_band = 0.95;    // of the energy, below the frequency considered
constexpr double noticed = 0.01;    // of the energy: less, in a direction or cut off, is ignored
// m/s: strong earthquakes move the ground with 1 to 3 m/s next to their fault.
constexpr double fastest_usual = 5;
constexpr const char* longer = "increase stage.duration (track on a ground: passage.duration)";

// m/s of an upward wave with motion along x (0) or z (2), at the softest position of a layer.
double speed(const GroundParameters& p, const Layer& layer, int axis, Dimension dimension) {
  double young = layer.solid.young;
  if (!layer.young_file.empty()) {
    const auto rows = input::read_table(layer.young_file, {"x_m", "young_Pa"}, "x_m");
    if (!rows[1].empty()) young = *std::min_element(rows[1].begin(), rows[1].end());
  }
  const double nu = layer.solid.poisson;
  const bool thin = dimension == Dimension::plane && p.plane == PlaneState::stress;
  const double shear = young / (2 * (1 + nu));
  const double along = thin ? young / (1 - nu * nu) : 2 * shear * (1 - nu) / (1 - 2 * nu);
  return std::sqrt((axis == 0 ? shear : along) / layer.solid.density);
}

// s, travel time of a wave from the base to the top; 0 for a mesh file.
double time_up(const GroundParameters& p, int axis, Dimension dimension) {
  double time = 0;
  if (p.mesh.empty())
    for (const Layer& layer : p.layers) time += layer.thickness / speed(p, layer, axis, dimension);
  return time;
}

// Warning if a wave has not arrived, and travelled up to the top and down again, at the end.
std::string cut_off(const GroundParameters& p, const BaseMotion& wave, Dimension dimension,
                    double time) {
  double all = 0, come = 0, last = 0, way = 0;
  for (const int axis : {0, 2}) {
    const WaveBand band(wave, axis);
    all += band.energy(), come += band.energy_until(time);
  }
  for (const int axis : {0, 2}) {
    const WaveBand band(wave, axis);
    if (band.energy() <= noticed * all) continue;
    last = std::max(last, band.time_of(1 - noticed));
    way = std::max(way, 2 * time_up(p, axis, dimension));
  }
  if (come < (1 - noticed) * all)
    return fmt::format(
        "the ground moves for at most {:g} s; by then only {:.2g} % of the wave's energy has "
        "entered at the base, and the rest is cut off; {}",
        time, 100 * come / all, longer);
  if (last + way <= time) return {};
  return fmt::format(
      "the ground moves for at most {:g} s; the wave has entered at the base after {:.3g} s and "
      "takes {:.3g} s more to the top and back to the base, so that it is cut off; {}",
      time, last, way, longer);
}

}  // namespace

std::vector<std::string> look_at_times(const GroundParameters& parameters, Dimension dimension,
                                       double time) {
  if (!parameters.present || parameters.base_motion.empty()) return {};
  const BaseMotion wave(parameters.base_motion);
  if (!wave.moves(0) && !wave.moves(2)) return {"has no motion: all its velocities are 0"};
  if (wave.end() <= 0)
    return {
        fmt::format("the wave ends at {:g} s, before the ground starts to move at 0 s, and has no "
                    "effect; let its rows begin at 0 s",
                    wave.end())};
  if (wave.begin() >= time)
    return {
        fmt::format("the wave begins at {:g} s, but the ground moves for at most {:g} s: the wave "
                    "has no effect; {}",
                    wave.begin(), time, longer)};
  std::vector<std::string> odd;
  if (const double speed = wave.fastest(); speed > fastest_usual)
    odd.push_back(
        fmt::format("the largest speed, {:g} m/s, is outside the usual values (at most {:g} m/s); "
                    "is its unit right?",
                    speed, fastest_usual));
  const std::string cut = cut_off(parameters, wave, dimension, time);
  if (!cut.empty()) odd.push_back(cut);
  const Vec3 now = wave.at(0);
  if (!now.isZero(0))
    odd.push_back(
        fmt::format("the ground starts from rest at 0 s, but the wave already has vx_m_s = {:g} "
                    "m/s, vz_m_s = {:g} m/s, which acts as a jump; let its rows begin at 0 s",
                    now.x(), now.z()));
  return odd;
}

// The permitted delay is distributed over layers: the same number of elements per wave length in
// each.
std::vector<UnresolvedLayer> look_at_elements(const GroundParameters& p, Dimension dimension) {
  std::vector<UnresolvedLayer> found;
  if (!p.present || p.base_motion.empty() || p.of_tetrahedra()) return found;
  const BaseMotion wave(p.base_motion);
  const std::array<WaveBand, 2> bands{WaveBand(wave, 0), WaveBand(wave, 2)};
  double depth = 0;
  for (const Layer& layer : p.layers) depth += layer.thickness;
  const double even = depth / static_cast<double>(p.elements_z);  // m
  for (const std::size_t b : {0UL, 1UL}) {
    if (bands[b].energy() <= noticed * (bands[0].energy() + bands[1].energy())) continue;
    const double frequency = bands[b].frequency_of(in_band);
    constexpr double once = std::numbers::pi * std::numbers::pi / 6;
    std::vector<double> lengths, heights;  // m, of the wave and of elements
    double late = 0, deep = 0;             // periods; lengths
    for (const Layer& layer : p.layers) {
      lengths.push_back(speed(p, layer, b == 0 ? 0 : 2, dimension) / frequency);
      heights.push_back(
          p.layers_have_elements() ? layer.thickness / static_cast<double>(layer.elements) : even);
      deep += layer.thickness / lengths.back();
      late +=
          once * layer.thickness / lengths.back() * std::pow(heights.back() / lengths.back(), 2);
    }
    if (late <= latest) continue;
    // Permitted height of elements over the wave length.
    const double fraction = std::sqrt(latest / (once * deep));
    for (std::size_t l = 0; l < lengths.size(); ++l)
      if (heights[l] > fraction * lengths[l])
        found.push_back(
            {l,
             fmt::format("elements {:.3g} m high in layer \"{}\" do not resolve the wave of "
                         "base_motion ({}): 95 % of its energy is below {:.3g} Hz, where the wave "
                         "length in this layer is {:.3g} m; use elements at most {:.2g} m high",
                         heights[l], p.layers[l].name, b == 0 ? "vx_m_s" : "vz_m_s", frequency,
                         lengths[l], fraction * lengths[l])});
  }
  return found;
}

}  // namespace trackbed::fem
