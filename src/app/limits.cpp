// Time steps. Three things limit them: the stiffest contact of the lightest stone (sub-step), the
// ground's elements (its own steps within a window) and the staggered coupling (window). The first
// two are asked of the rooms; the third is ours. Nothing here depends on ranks or on the machine,
// so a run has the same windows everywhere.
//
// Two kinds of function: estimates from the deck alone, which run while problems are still being
// collected and so must stand any value, and exact ones, which ask the model. An estimate may only
// refuse what is grossly wrong; the exact limit decides.
#include "app/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "app/cell.hpp"
#include "app/ground_alone.hpp"
#include "app/world.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/dem/stiffness.hpp"

namespace trackbed::app {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double rounding = 1e-9;  // relative, so that a given step equal to the limit passes

// Sensible also for decks with problems: these functions run while problems are being collected.
double positive(double value, double instead) { return value > 0 ? value : instead; }

// Sieve sizes of a deck are in mm and rise.
double sieve_low(const bed::LayerParameters& layer) {
  return layer.sieve.empty() ? 0.02 : positive(layer.sieve.front(), 20) * 1e-3;
}

double sieve_high(const bed::LayerParameters& layer) {
  return layer.sieve.empty() ? 0.06 : positive(layer.sieve.back(), 60) * 1e-3;
}

// Of all layers: which of them a body touches is not known from the deck.
double sieve_low(const Model& model) {
  double low = sieve_low(static_cast<const bed::LayerParameters&>(model.bed));
  for (const bed::NamedLayer& layer : model.bed.layers) low = std::min(low, sieve_low(layer));
  return low;
}

double sieve_high(const Model& model) {
  double high = sieve_high(static_cast<const bed::LayerParameters&>(model.bed));
  for (const bed::NamedLayer& layer : model.bed.layers) high = std::max(high, sieve_high(layer));
  return high;
}

// 2600 kg/m^3, as of rock, for decks whose material is not there.
double density_of_stones(const Model& model, const bed::LayerParameters& layer) {
  const int number = model.material(layer.material);
  return positive(
      number < 0 ? 0 : model.physics.materials[static_cast<std::size_t>(number)].density, 2600);
}

// Stones of one size that lie side by side on a face of these extents, m.
// Rounded up, at least one: more contacts mean a stiffer support and a shorter window, the safe
// side.
double contacts_on(const Model& model, double along, double across) {
  const auto row = [&](double extent) {
    return std::max(1.0, std::ceil(extent / sieve_low(model)));
  };
  return row(along) * (model.dimension == Dimension::plane ? 1 : row(across));
}

// Of stones whose size gives the radius: hertz contacts stiffen with it.
double stiffest_contact(const Model& model, double size) {
  return positive(dem::stiffest_contact(model.physics, size / 2, model.dem.largest_overlap), 1e6);
}

//   window = 0.5 sqrt(m/(n k)) = 0.5/w,   w = sqrt(n k/m) rad/s
// so that the load is late by half a radian of the fastest oscillation at most. (On delays in
// staggered schemes: Felippa, Park, Farhat 2001, doi:10.1016/S0045-7825(00)00391-1.)
CouplingLimit limit_of(const Model& model, const std::string& body, double mass, double contacts) {
  const double k = stiffest_contact(model, sieve_high(model));
  return {.window = 0.5 * std::sqrt(mass / (contacts * k)),
          .body = fmt::format("{} of {:.3g} kg", body, mass),
          .contacts = contacts,
          .stiffness = k};
}

// m, the shortest distance of two borders of zones.
double narrowest(const std::vector<double>& edges) {
  double width = infinite;
  for (std::size_t i = 1; i < edges.size(); ++i) width = std::min(width, edges[i] - edges[i - 1]);
  return width;
}

// A node in the middle of the top has an eighth of each of the four zones below it (a quarter of
// two in a plane): half a zone's mass. The smallest zone and the lightest layer count: an estimate,
// blocks left out.
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
  constexpr double contacts = 1;  // a zone is about as long as a stone
  return limit_of(model, "node of the ground's top", mass, contacts);
}

}  // namespace

namespace {

// The volume of a stone from its sieve size d: a disk or ball of diameter d, longer by 1/elongation
// in the directions that a sieve does not feel.
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

// Of a solid sleeper one element answers at once, the rest as fast as sound goes through it: a node
// of its lower face under the stones of an element.
CouplingLimit limit_of_solid(const Model& model) {
  const auto& s = model.sleepers;
  const double element = model.solid.element;
  const double mass = solid_node_mass(model);
  if (!(mass > 0) || !(element > 0)) return {.window = infinite};
  return limit_of(model, "node of a solid sleeper", mass,
                  contacts_on(model, std::min(element, s.width), std::min(element, s.length)));
}

}  // namespace

// The ground counts only when it moves: a ground held still has no motion to be late with.
CouplingLimit coupling_limit(const Model& model, bool ground_moves) {
  CouplingLimit limit{.window = infinite};
  if (model.ground.present && ground_moves) limit = limit_of_top(model);
  // Placed by a stage, or there already in the checkpoint it starts from.
  if (!model.uses_sleepers()) return limit;
  const auto& s = model.sleepers;
  const double length = model.dimension == Dimension::plane ? model.thickness : s.length;
  const double mass = s.density * s.width * s.height * length;
  if (!(mass > 0)) return limit;
  const CouplingLimit sleeper =
      s.model == track::SleeperBody::solid
          ? limit_of_solid(model)
          : limit_of(model, "sleeper", mass, contacts_on(model, s.width, length));
  return sleeper.window < limit.window ? sleeper : limit;
}

// kg, of a rigid sleeper that the pad of one rail moves. In roll two pads g apart act on the
// inertia I as on 2 I/g^2 each, which is the lesser for sleepers shorter than sqrt(3) g.
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

// Explicit sleepers on springs are stable up to 2/w, w = sqrt(k/m), on dashpots up to m/c; both
// rates, 1/s, add up. k and c: of the pads of all rails that a sleeper carries. Solid ones take one
// implicit step with pads and rail, which is stable for any window.
CouplingLimit coupling_limit(const Model& model, const Stage& stage) {
  const CouplingLimit limit = coupling_limit(model, stage.ground_moves);
  if (!stage.train) return limit;
  if (model.sleepers.model == track::SleeperBody::solid)
    return limit.window <= model.track.passage.step
               ? limit
               : CouplingLimit{.window = model.track.passage.step, .instead = "passage.step"};
  const auto& pad = model.track.line.pad;
  const double mass = mass_on_pad(model);
  const double stiffness = pad.knee > 0 ? std::max(pad.stiffness, pad.beyond) : pad.stiffness;
  const double pads = 0.5 / (std::sqrt(stiffness / mass) + pad.damping / mass);
  const double step = model.track.passage.step;
  if (limit.window <= std::min(pads, step)) return limit;
  CouplingLimit rail{.window = std::min(pads, step)};
  rail.instead = pads < step ? fmt::format(
                                   "sleeper of {:.3g} kg per rail on its pad of {:.3g} N/m "
                                   "and {:.3g} N s/m",
                                   mass, stiffness, pad.damping)
                             : "passage.step";
  return rail;
}

// For the log: a user must be able to check the limit by hand.
std::string CouplingLimit::words() const {
  if (!instead.empty()) return instead;
  return fmt::format("{} on {:.0f} contact{} of {:.3g} N/m", body, contacts,
                     contacts > 1 ? "s" : "", stiffness);
}

namespace {

// What lets hertz contacts take a longer step: more of the stable one, or softer contacts, since
// their stiffness F/delta grows with the root of the overlap it is taken at, in space,
//   step ~ safety overlap^(-1/4).
// Nothing where a linear contact may be the stiffest.
std::string remedies(const Model& model, double limit) {
  const auto& laws = model.physics.laws;
  const bool hertz = !laws.empty() && std::all_of(laws.begin(), laws.end(), [](const auto& law) {
    return law.kind == dem::LawKind::hertz;
  });
  const double longer = model.time.step / limit, safety = model.dem.safety * longer;
  if (!hertz || !std::isfinite(longer)) return {};
  std::vector<std::string> words;
  // Printed with two digits. Smaller overlaps than that would end any run at its first contact.
  constexpr double of_use = 1e-4;
  const double overlap = 0.99 * model.dem.largest_overlap / std::pow(longer, 4);
  if (model.dimension == Dimension::space && overlap >= of_use)
    words.push_back(
        fmt::format("dem.largest_overlap = {:.2g} (beyond which the run would stop)", overlap));
  if (safety <= 1) words.push_back(fmt::format("dem.safety = {:.3g}", 1.005 * safety));
  if (words.empty()) return {};
  return fmt::format("; {} would allow it", fmt::join(words, " or "));
}

}  // namespace

// A step that is asked for and is too long is refused, never shortened in silence.
void require_stable(const Model& model, const input::Deck& deck, double limit,
                    const std::string& words) {
  if (model.time.step > limit * (1 + rounding))
    throw InputError({fmt::format("{} = {:g} s is above the stable sub-step of {:.4g} s ({}){}",
                                  deck.where("time.step"), model.time.step, limit, words,
                                  remedies(model, limit))});
}

namespace {

// Rooms know no decks: a sentence that begins with a parameter's name gets its place.
std::string placed(const std::string& words, const input::Deck& deck) {
  const std::size_t colon = words.find(": ");
  const bool names = words.starts_with("bed.") && colon != std::string::npos;
  return names ? deck.where(words.substr(0, colon)) + words.substr(colon) : words;
}

// A sentence about the file of shapes gets the place that names it.
bed::Stones stones_of(const par::Comm& comm, const Model& model, const std::string& layer,
                      const input::Deck& deck) {
  const bed::BedParameters bed = model.bed.of_layer(layer);
  try {
    return bed::stones_of(comm, bed, model.domain());
  } catch (const InputError& error) {  // equal on all ranks
    const std::string words = error.what(), start = bed.library + ": ";
    if (bed.library.empty() || !words.starts_with(start)) throw InputError({placed(words, deck)});
    const std::string key =
        layer.empty() ? "bed.library" : fmt::format("bed.layer.{}.library", layer);
    throw InputError(
        {fmt::format("{} = \"{}\" {}", deck.where(key), bed.library, words.substr(start.size()))});
  }
}

// Layers that stages fill, each once; of the uppermost one also the cribs are made.
std::set<std::string> layers_made(const Model& model) {
  std::set<std::string> layers;
  for (const Stage& stage : model.stages) {
    const bool fills =
        stage.kind == StageKind::fill && model.start.empty() && model.bed.cell.empty();
    if (fills || stage.kind == StageKind::cribs) layers.insert(stage.layer);
  }
  return layers;
}

// The neighbour search needs three cells along a periodic side; how large the skin between them
// will be is known only with the stones, so that a little less than this may be refused later.
void require_length(const Model& model, const std::string& layer, double largest_bound,
                    const input::Deck& deck) {
  const dem::Domain domain = model.domain();
  const double least = 3 * (2 * largest_bound + model.dem.skin);
  std::vector<std::string> problems;
  for (const int axis : {0, 1}) {
    const double length = domain.high[axis] - domain.low[axis];
    if (!domain.periodic[static_cast<std::size_t>(axis)] || length >= least) continue;
    problems.push_back(fmt::format(
        "{}: the bed is {:.4g} m long where it is periodic and must be at least {:.4g} m: 3 times "
        "the ball around its largest stone{}",
        deck.where(axis == 0 ? "bed.x" : "bed.y"), length, least,
        layer.empty() ? "" : fmt::format(" of layer {}", layer)));
  }
  if (!problems.empty()) throw InputError(problems);
}

// Loose stones need several times the room of the pressed bed; a layer falls from above those that
// lie there. Nothing of cribs: their height is known only from the sleepers.
void require_room(const Model& model, const StonesOfLayers& layers, const input::Deck& deck) {
  double below = 0;
  for (const Stage& stage : model.stages) {
    if (stage.kind != StageKind::fill || !model.start.empty() || !model.bed.cell.empty()) continue;
    const double top = below + layers.at(stage.layer).top;
    const double high = model.domain().high.z();
    if (stage.growth == 0 && top > high)  // others begin small
      throw InputError({fmt::format(
          "{}: the loose stones would reach {:.3g} m, beyond the {:.3g} m that the program keeps "
          "for them (1 m and ten times the height): the bed is too narrow for its stones, or they "
          "are far from round",
          deck.where(stage.layer.empty() ? "bed.height"
                                         : fmt::format("bed.layer.{}.height", stage.layer)),
          top, high)});
    below += model.bed.of_layer(stage.layer).height;
  }
}

}  // namespace

// Stones that are there already (a start from a checkpoint) are not known from the deck; their
// limit is met in `choose_steps`.
StonesOfLayers require_stones(const par::Comm& comm, const Model& model, const input::Deck& deck) {
  const bool fills = model.start.empty() && model.has_stage(StageKind::fill);
  if (fills && !model.bed.cell.empty()) require_cell(comm, model, deck);
  StonesOfLayers layers;
  for (const std::string& layer : layers_made(model))
    layers[layer] = stones_of(comm, model, layer, deck);
  require_room(model, layers, deck);
  for (const auto& [layer, stones] : layers) {
    require_length(model, layer, stones.largest_bound, deck);
    if (!model.start.empty() || stones.count < 1) continue;
    const StonesStep step = step_of(model, {{layer, stones}});
    require_stable(model, deck, step.longest, step.limit);
  }
  return layers;
}

// A sieve does not feel the length of a stone that passes it lengthwise. EN 13450 counts stones of
// a length above three times their thickness; those of the default proportions measure 1.5 sieves,
// at most 1.9.
std::vector<std::string> warnings_of(const Model& model, const StonesOfLayers& layers) {
  constexpr double surprising = 2.5;
  std::vector<std::string> all;
  for (const auto& [name, stones] : layers) {
    const double sieve = sieve_high(model.bed.of_layer(name));
    if (!(stones.longest > surprising * sieve)) continue;
    all.push_back(fmt::format(
        "{}: the longest stone measures {:.3g} mm, {:.2g} times the largest sieve of {:.3g} mm, "
        "since its shape is elongated or flat (`trackbed shapes` shows S, I and L)",
        name.empty() ? "bed" : fmt::format("bed.layer.{}", name), 1e3 * stones.longest,
        stones.longest / sieve, 1e3 * sieve));
  }
  return all;
}

StonesStep step_of(const Model& model, const StonesOfLayers& layers) {
  const double thickness = model.dimension == Dimension::plane ? model.thickness : 1;
  double lightest = infinite, largest = 0;
  for (const auto& [layer, stones] : layers) {
    const double density = density_of_stones(model, model.bed.of_layer(layer));
    lightest = std::min(lightest, density * stones.smallest_volume * thickness);
    largest = std::max(largest, stones.largest_bound);
  }
  StonesStep step;
  step.longest = dem::stable_step(model.physics, model.dem, lightest, largest, &step.limit);
  return step;
}

StonesStep step_of(const World& world) {
  StonesStep step;
  step.longest = world.particles.stable_step(&step.limit);
  if (!std::isfinite(step.longest)) step.limit = "none is free, and time.step is given";
  return step;
}

namespace {

// What a mesh from a file weighs at its top is not in the deck: asked of the ground itself.
CouplingLimit coupling_limit(const World& world, const Stage& stage) {
  const CouplingLimit limit = coupling_limit(world.model, stage);
  if (!stage.ground_moves || !world.ground || !world.model.ground.of_tetrahedra()) return limit;
  double lightest = infinite;
  for (const std::int32_t node : world.ground->own_top())
    lightest = std::min(lightest, world.ground->top_mass(node));
  constexpr double contacts = 1;  // as of layers
  const CouplingLimit top =
      limit_of(world.model, "node of the ground's top", world.comm.min(lightest), contacts);
  return top.window < limit.window ? top : limit;
}

}  // namespace

// The chain: sub-step from the stones (or given), window from the sub-steps wanted, cut by the
// coupling (or given), then as many sub-steps as fill the window. The last rounding shortens the
// sub-step and never lengthens it.
Steps choose_steps(const World& world, const StonesStep& stones, const Stage& stage,
                   const input::Deck& deck) {
  const Model& model = world.model;
  if (!model.has_stones()) return steps_alone(world);
  std::string ground_words;
  require_stable(model, deck, stones.longest, stones.limit);
  const double step = model.time.step > 0 ? model.time.step : stones.longest;
  const CouplingLimit coupling = coupling_limit(world, stage);
  Steps steps;
  steps.window = step * static_cast<double>(model.time.substeps);
  steps.limit = "stones: " + stones.limit;
  if (stage.ground_moves && world.ground) {
    // No limit of the window: the ground divides it into as many steps as it needs.
    const double ground = world.ground->stable_step(&ground_words);
    if (ground < steps.window)
      steps.limit += fmt::format("; ground in steps of at most {:.4g} s: {}", ground, ground_words);
  }
  if (coupling.window < steps.window) {
    steps.window = coupling.window;
    steps.limit = "coupling: " + coupling.words();
  }
  if (model.time.window > 0) {
    if (model.time.window > coupling.window * (1 + rounding))
      throw InputError({fmt::format("{} = {:g} s is above the stable window of {:.4g} s ({})",
                                    deck.where("time.window"), model.time.window, coupling.window,
                                    coupling.words())});
    steps.window = model.time.window, steps.limit = "given";
  }
  if (!std::isfinite(steps.window))
    throw InputError({fmt::format("{}: stage \"{}\" has nothing that moves, so no time step",
                                  deck.where("stage"), stage.name)});
  // A window is one call of the stones, which looks at no signal and writes nothing.
  constexpr double most = 1e6;
  const double substeps = std::max(1.0, std::ceil(steps.window / step * (1 - rounding)));
  if (!(substeps <= most))
    throw InputError(
        {fmt::format("{} = {:g} s would take {:.3g} sub-steps of {:.3g} s in each "
                     "window of {:.3g} s, more than {:.0e}; give a shorter window",
                     deck.where(model.time.window > 0 ? "time.window" : "time.step"),
                     model.time.window > 0 ? model.time.window : model.time.step, substeps, step,
                     steps.window, most)});
  steps.substeps = static_cast<int>(substeps);
  return steps;
}

}  // namespace trackbed::app
