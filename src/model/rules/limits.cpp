// Time steps. Three things limit them: the stiffest contact of the lightest stone (sub-step), the
// ground's elements (its own steps within a window) and the staggered coupling (window). The first
// two limits come from the modules dem and fem; the third is computed here. Nothing depends on
// ranks or on the machine, so a run has the same windows everywhere.
//
// These are estimates from the deck alone, which run while problems are still being collected and
// so must accept any value. An estimate may refuse only what is grossly wrong; the exact limit of
// the model decides (steps.cpp).
#include "model/rules/limits.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "trackbed/core/error.hpp"
#include "trackbed/core/whole_steps.hpp"
#include "trackbed/dem/stiffness.hpp"

namespace trackbed::model {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// Sensible also for decks with problems: these functions run while problems are being collected.
double positive(double value, double instead) { return value > 0 ? value : instead; }

// Sieve sizes of a deck are in mm and rise.
double sieve_low(const bed::LayerParameters& layer) {
  return layer.sieve.empty() ? 0.02 : positive(layer.sieve.front(), 20) * 1e-3;
}

// Of all layers: which of them touches a body does not follow from the deck.
double sieve_low(const Model& model) {
  double low = sieve_low(static_cast<const bed::LayerParameters&>(model.bed));
  for (const bed::NamedLayer& layer : model.bed.layers) low = std::min(low, sieve_low(layer));
  return low;
}

double largest_sieve(const Model& model) {
  double high = sieve_high(static_cast<const bed::LayerParameters&>(model.bed));
  for (const bed::NamedLayer& layer : model.bed.layers) high = std::max(high, sieve_high(layer));
  return high;
}

// Number of stones of one size side by side on a face of these extents, m. Rounded up, at least
// one: more contacts mean a stiffer support and a shorter window, which is conservative.
double contacts_on(const Model& model, double along, double across) {
  const auto row = [&](double extent) {
    return std::max(1.0, std::ceil(extent / sieve_low(model)));
  };
  return row(along) * (model.dimension == Dimension::plane ? 1 : row(across));
}

// N/m, of stones of this size, m: the stiffness of Hertzian contacts increases with the radius.
double stiffest_contact(const Model& model, double size) {
  return positive(dem::stiffest_contact(model.physics, size / 2, model.dem.largest_overlap), 1e6);
}

// m, smallest size of an element along an axis.
double narrowest(const std::vector<double>& edges) {
  double width = infinite;
  for (std::size_t i = 1; i < edges.size(); ++i) width = std::min(width, edges[i] - edges[i - 1]);
  return width;
}

// s, estimate of the window of the coupling.
double rough_window(const Model& model) {
  const TimeParameters& time = model.time;
  if (time.window > 0) return time.window;
  const double step = time.step > 0 ? time.step : time.rough_step;
  return std::min(time.rough_window, static_cast<double>(time.substeps) * step);
}

// An inner node of the top has an eighth of the mass of each of the four elements below it (a
// quarter of two in a plane model): half an element's mass. The estimate uses the smallest element
// and the lightest layer, without blocks.
CouplingLimit limit_of_top(const Model& model) {
  const auto& ground = model.ground;
  double density = infinite;
  for (const auto& layer : ground.layers)
    if (layer.solid.density > 0) density = std::min(density, layer.solid.density);
  if (!std::isfinite(density) || ground.x.size() != 2 || ground.y.size() != 2)
    return {.window = infinite};
  const double dy =
      model.dimension == Dimension::plane ? model.thickness : narrowest(ground.edges(1));
  const double mass = density * narrowest(ground.edges(0)) * dy * narrowest(ground.edges(2)) / 2;
  if (!(mass > 0)) return {.window = infinite};
  constexpr double contacts = 1;  // an element is about as long as a stone
  return coupling_limit(model, "surface node of the ground", mass, contacts);
}

}  // namespace

double sieve_high(const bed::LayerParameters& layer) {
  return layer.sieve.empty() ? 0.06 : positive(layer.sieve.back(), 60) * 1e-3;
}

// 2600 kg/m^3, that of rock, for decks without this material.
double density_of_stones(const Model& model, const bed::LayerParameters& layer) {
  const int number = model.material(layer.material);
  return positive(
      number < 0 ? 0 : model.physics.materials[static_cast<std::size_t>(number)].density, 2600);
}

//   window = 0.5 sqrt(m/(n k)) = 0.5/w,   w = sqrt(n k/m) rad/s
// so that the delay of the load is at most half a radian of the fastest oscillation. (On delays in
// staggered schemes: Felippa, Park, Farhat 2001, doi:10.1016/S0045-7825(00)00391-1.)
CouplingLimit coupling_limit(const Model& model, const std::string& body, double mass,
                             double contacts) {
  const double k = stiffest_contact(model, largest_sieve(model));
  return {.window = 0.5 * std::sqrt(mass / (contacts * k)),
          .body = fmt::format("{}: mass {:.3g} kg", body, mass),
          .contacts = contacts,
          .stiffness = k};
}

namespace {

// The volume of a stone from its sieve size d: a disk or sphere of diameter d, longer by
// 1/elongation in the directions that sieving does not measure.
double rough_step_of(const Model& model, const bed::LayerParameters& layer) {
  const double d = sieve_low(layer);
  const double shape = 1 / std::clamp(layer.elongation, 0.1, 1.0);
  const double volume = model.dimension == Dimension::plane
                            ? std::numbers::pi / 4 * d * d * shape * positive(model.thickness, 1)
                            : std::numbers::pi / 6 * d * d * d * shape * shape;
  const double mass = density_of_stones(model, layer) * volume;
  return positive(model.dem.safety, 0.2) * std::sqrt(mass / stiffest_contact(model, d));
}

}  // namespace

double rough_step_limit(const Model& model) {
  double limit = rough_step_of(model, model.bed);
  for (const bed::NamedLayer& layer : model.bed.layers)
    limit = std::min(limit, rough_step_of(model, layer));
  return limit;
}

namespace {

// In a solid sleeper a contact force first accelerates one element, and the rest at the speed of
// waves in it: the limit is that of a node of its lower face under the stones of an element.
CouplingLimit limit_of_solid(const Model& model) {
  const auto& s = model.sleepers;
  const double element = model.solid.element;
  const double mass = solid_node_mass(model);
  if (!(mass > 0) || !(element > 0)) return {.window = infinite};
  return coupling_limit(
      model, "node of a solid sleeper", mass,
      contacts_on(model, std::min(element, s.width), std::min(element, s.length)));
}

}  // namespace

// The ground counts only when it moves: the position of a fixed ground is never late.
CouplingLimit coupling_limit(const Model& model, bool ground_moves) {
  CouplingLimit limit{.window = infinite};
  if (model.ground.present && ground_moves) limit = limit_of_top(model);
  // Sleepers are placed by a stage, or are in the checkpoint from which the run starts.
  if (!model.uses_sleepers()) return limit;
  const auto& s = model.sleepers;
  const double length = model.dimension == Dimension::plane ? model.thickness : s.length;
  const double mass = s.density * s.width * s.height * length;
  if (!(mass > 0)) return limit;
  const CouplingLimit sleeper =
      s.model == track::SleeperBody::solid
          ? limit_of_solid(model)
          : coupling_limit(model, "sleeper", mass, contacts_on(model, s.width, length));
  return sleeper.window < limit.window ? sleeper : limit;
}

// kg, effective mass of a rigid sleeper on the pad of one rail. In roll two pads at the distance g
// act on the inertia I as on a mass 2 I/g^2 each, which is smaller for sleepers shorter than
// sqrt(3) g.
double mass_on_pad(const Model& model) {
  const auto& s = model.sleepers;
  const double length = model.dimension == Dimension::plane ? model.thickness : s.length;
  const double mass = s.density * s.width * s.height * length;
  const double bounce = positive(mass / model.seat.rails, 1);
  if (!(s.gauge > 0) || std::find(s.free.begin(), s.free.end(), "rx") == s.free.end())
    return bounce;
  const double inertia = mass * (length * length + s.height * s.height) / 12;
  return std::min(bounce, positive(2 * inertia / (s.gauge * s.gauge), 1));
}

namespace {

// rad/s, of elements of a solid, estimated as that of rods along all axes, 2 c/h each.
double highest_frequency(const Model& model, const fem::Elastic& solid) {
  const auto& ground = model.ground;
  const bool plane = model.dimension == Dimension::plane;
  double squares = 0;  // 1/m^2
  for (const int axis : {0, 1, 2})
    if (axis != 1 || !plane) squares += std::pow(narrowest(ground.edges(axis)), -2);
  const double nu = solid.poisson, density = solid.density;
  const double modulus = plane && ground.plane == fem::PlaneState::stress
                             ? solid.young / (1 - nu * nu)
                             : solid.young * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  return 2 * std::sqrt(modulus / density * squares);
}

// The next larger number of two digits: a limit that is printed with two.
double rounded_up(double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return std::ceil(value / unit) * unit;
}

// Largest factor that zones give to the pads of the bed's sleepers.
double stiffest_pad_factor(const Model& model) {
  const track::TrackParameters& track = model.track.line.track;
  double largest = 0;
  for (std::int64_t k = 0; k < model.sleepers.count; ++k)
    for (const std::size_t side : {0, 1}) {
      const double x = track.sleeper_x(static_cast<std::size_t>(model.seat.before + k));
      largest = std::max(largest, track.factor(&track::TrackZone::pad, x, side));
    }
  return largest;
}

}  // namespace

// A force -k u(t - W) on a node of mass m and displacement u of frequency w works like a damper of
// the coefficient -(k/w) sin(w W), damping of the solid like one of m w^2 beta. With the limit
// L = 0.5 sqrt(m/k) of the window the latter prevails if
//   beta > 0.25 W (W/L)^2 sin(a)/a^3,   a = w W.
// Waves with a < 1.5 are damped by the contacts. The factor 0.03 is that at a = 2, 0.07 at a = 1.5,
// where contacts still help: docs/decisions/stages_and_windows.md.
double least_damping_of_ground(const Model& model, const fem::Elastic& solid, Modulus modulus) {
  if (!model.has_stones() || !model.ground.present || model.ground.of_tetrahedra()) return 0;
  const double limit = limit_of_top(model).window, window = rough_window(model);
  if (!std::isfinite(limit) || !std::isfinite(window)) return 0;
  constexpr double damped_by_contacts = 1.5;  // rad
  if (modulus == Modulus::known && highest_frequency(model, solid) * window < damped_by_contacts)
    return 0;
  return rounded_up(0.03 * window * std::pow(std::min(1.0, window / limit), 2));
}

// Explicit sleepers on springs are stable up to 2/w, w = sqrt(k/m), on dashpots up to m/c; both
// rates, 1/s, add up. k and c are those of the pads of all rails that a sleeper carries. Solid
// sleepers take one implicit step with pads and rail, which is stable for any window.
CouplingLimit coupling_limit(const Model& model, const Stage& stage) {
  CouplingLimit limit = coupling_limit(model, stage.ground_moves);
  limit.stiffness *= stage.stiffness, limit.window /= std::sqrt(stage.stiffness);
  if (!stage.train) return limit;
  if (model.sleepers.model == track::SleeperBody::solid)
    return limit.window <= model.track.passage.step
               ? limit
               : CouplingLimit{.window = model.track.passage.step, .instead = "passage.step"};
  const auto& pad = model.track.line.pad;
  const double mass = mass_on_pad(model), stiffest = stiffest_pad_factor(model);
  const double stiffness =
      stiffest *
      (pad.bilinear_at > 0 ? std::max(pad.stiffness, pad.bilinear_stiffness) : pad.stiffness);
  const double damping = stiffest * pad.damping;
  const double pads = 0.5 / (std::sqrt(stiffness / mass) + damping / mass);
  const double step = model.track.passage.step;
  if (limit.window <= std::min(pads, step)) return limit;
  CouplingLimit rail{.window = std::min(pads, step)};
  rail.instead = pads < step ? fmt::format(
                                   "0.5/(sqrt(k/m) + c/m) of a sleeper on its pads{}, m = {:.3g} "
                                   "kg per rail, k = {:.3g} N/m, c = {:.3g} N s/m",
                                   stiffest == 1 ? "" : " (the stiffest ones, by track.zone)", mass,
                                   stiffness, damping)
                             : "passage.step";
  return rail;
}

// For the log, so that the limit can be checked by hand.
std::string CouplingLimit::words() const {
  if (!instead.empty()) return instead;
  return fmt::format(
      "0.5 sqrt(m/(n k)) of a {}, n = {:.0f} contact{} with stones, k = {:.3g} N/m{}", body,
      contacts, contacts > 1 ? "s" : "", stiffness, contacts > 1 ? " each" : "");
}

namespace {

// Parameters that allow Hertzian contacts a longer step: a larger safety factor, or a smaller
// largest overlap, since their stiffness F/delta grows with the root of the overlap; in space
//   step ~ safety overlap^(-1/4).
// Empty if a linear contact may be the stiffest.
std::string remedies(const Model& model, double limit) {
  const auto& laws = model.physics.laws;
  const bool hertz = !laws.empty() && std::all_of(laws.begin(), laws.end(), [](const auto& law) {
    return law.kind == dem::LawKind::hertz;
  });
  const double longer = model.time.step / limit, safety = model.dem.safety * longer;
  if (!hertz || !std::isfinite(longer)) return {};
  std::vector<std::string> words;
  // Printed with two digits. A limit below this would end any run at its first contact.
  constexpr double of_use = 1e-4;
  const double overlap = 0.99 * model.dem.largest_overlap / std::pow(longer, 4);
  if (model.dimension == Dimension::space && overlap >= of_use)
    words.push_back(fmt::format(
        "dem.largest_overlap = {:.2g} (the run then stops at larger overlaps)", overlap));
  if (safety <= 1) words.push_back(fmt::format("dem.safety = {:.3g}", 1.005 * safety));
  if (words.empty()) return {};
  return fmt::format("; this step would be allowed with {}", fmt::join(words, " or "));
}

}  // namespace

// A given step that is too long is refused and never shortened silently.
void require_stable(const Model& model, const input::Deck& deck, double limit,
                    const std::string& words) {
  if (model.time.step > limit * (1 + rounding_of_steps))
    throw InputError({fmt::format("{} = {:g} s is above the stable sub-step of {:.4g} s ({}){}",
                                  deck.where("time.step"), model.time.step, limit, words,
                                  remedies(model, limit))});
}

}  // namespace trackbed::model
