// Errors are what cannot be computed, or would be computed as something else than was meant.
#include "app/footing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/rules.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::app {

namespace {

constexpr double rounding = 1e-9;  // m, of borders that are meant to meet

bool is_plane(const Model& model) { return model.dimension == Dimension::plane; }
bool two_rails(const Model& model) { return model.track.line.track.dimension == Dimension::space; }

// The exchange needs both sides at the same instants, and a ground that has no weight. Implicit
// grounds by other integrators than the track's can gain energy with it
// (docs/decisions/track_on_ground.md).
void declare_kind(const Model& model, input::Section& s) {
  const input::About about{.reads = {"ground", "model"}};
  s.rule("ground.present", model.ground.present, "must be true: without it the model is \"track\"",
         about);
  const fem::GroundParameters& ground = model.ground;
  const bool newmark = ground.integrator == fem::Integrator::newmark;
  s.rule("ground.integrator", newmark || ground.integrator == fem::Integrator::explicit_,
         "must be explicit or newmark below a track, which takes average acceleration: others can "
         "gain energy with it",
         about);
  s.rule("ground.newmark_beta",
         !newmark || (ground.newmark_beta == 0.25 && ground.newmark_gamma == 0.5),
         "and newmark_gamma must be 0.25 and 0.5 below a track, which takes average acceleration: "
         "others can gain energy with it",
         about);
  s.rule("ground.layer", !model.ground.yields(),
         "must not yield below a track without stones, whose weight is not in the model", about);
}

// Sleepers on the ground are sleepers of the track, in its plain part.
void declare_track(const Model& model, input::Section& s) {
  const track::TrackParameters& track = model.track.line.track;
  const FootingParameters& footing = model.footing;
  const input::About about{.reads = {"track", "footing", "model"}};
  s.rule("track.support", track.support == track::Support::sleepers,
         "must be sleepers: the ground is below their ballast", about);
  const bool hangs = std::any_of(track.zones.begin(), track.zones.end(),
                                 [](const track::TrackZone& zone) { return zone.gap > 0; });
  s.rule("track.sleeper.model", !hangs || track.sleeper.model == track::SleeperModel::rigid,
         "must be rigid on a ground where sleepers hang (gap of a zone)", about);
  s.rule("pad.uplift", !model.track.line.pad.uplift,
         "must be false on a ground: pads lift off on a track alone (model = \"track\")",
         {.reads = {"pad", "model"}});
  const double first = static_cast<double>(footing.before) * track.spacing;
  const double last = first + static_cast<double>(footing.count - 1) * track.spacing;
  s.rule("footing.before", first >= track.run_in - rounding,
         fmt::format("puts the first sleeper on the ground {:g} m behind the begin of the track, "
                     "within its run-in of {:g} m",
                     first, track.run_in),
         about);
  s.rule("footing.count", last <= track.length - track.run_in + rounding,
         fmt::format("puts the last sleeper on the ground {:g} m behind the begin of the track; it "
                     "ends at {:g} m, and its run-in takes the last {:g} m",
                     last, track.length, track.run_in),
         about);
  s.rule("train.start", model.track.train.vehicles.empty() || model.track.train.start <= 0,
         "must be at most 0 on a ground: the train comes from the rigid rail before the track",
         {.reads = {"train", "model"}});
}

// What is below two rails is a whole sleeper, on a ground that may give way more at one end.
void declare_two_rails(const Model& model, input::Section& s) {
  if (!two_rails(model)) return;
  const FootingParameters& footing = model.footing;
  const double length = model.track.line.track.sleeper_length;
  s.rule("track.dimension", !is_plane(model),
         "must be plane on a ground in a plane: below two rails it is one in space (dimension)",
         {.reads = {"track", "dimension", "model"}});
  s.rule("footing.rails", footing.rails == 2,
         "must be 2 below two rails (track.dimension = \"space\"), whose ground carries both",
         {.reads = {"track", "footing"}});
  s.rule("footing.length", is_plane(model) || footing.length >= length - rounding,
         fmt::format("is less than a sleeper's length (track.sleeper_length = {:g} m): below two "
                     "rails whole sleepers press on the ground, through ballast that spreads it",
                     length),
         {.reads = {"track", "footing", "dimension"}});
}

// m: what all footprints cover along x.
std::array<double, 2> extent_of(const Model& model) {
  const FootingParameters& footing = model.footing;
  const double way = static_cast<double>(footing.count - 1) * model.track.line.track.spacing;
  return {footing.first - footing.width / 2, footing.first + way + footing.width / 2};
}

// Ballast spreads loads so far that neighbours may share ground, but mostly a width is mistaken.
void declare_overlap(const Model& model, input::Section& s) {
  const double spacing = model.track.line.track.spacing;
  s.rule(
      "footing.width", model.footing.count < 2 || model.footing.width <= spacing + rounding,
      fmt::format("is more than track.spacing ({:g} m): footprints of neighbours overlap", spacing),
      {.weight = input::Weight::warning, .reads = {"footing", "track"}});
}

// Told of the one that is out: a width beyond what sleepers leave each other, where those at the
// ends have that much room, else where they stand.
void declare_along(const Model& model, const input::About& about, input::Section& s) {
  const FootingParameters& footing = model.footing;
  const std::vector<double>& x = model.ground.x;
  const auto [from, to] = extent_of(model);
  const double spacing = model.track.line.track.spacing;
  const double room = std::min(from - x[0], x[1] - to) + footing.width / 2;
  const bool width = footing.width > spacing && room >= spacing / 2 - rounding;
  s.rule(
      "footing.width", !width || footing.width / 2 <= room + rounding,
      fmt::format("puts footprints from x = {:g} to {:g} m, beyond the ground (ground.x: {:g} to "
                  "{:g} m): the outermost sleepers have {:g} m beside their middle "
                  "(footing.first)",
                  from, to, x[0], x[1], room),
      about);
  s.rule("footing.first", width || from >= x[0] - rounding,
         fmt::format("puts a footprint from {:g} m on, beyond the ground (ground.x: {:g} to {:g} "
                     "m)",
                     from, x[0], x[1]),
         about);
  s.rule("footing.count", width || to <= x[1] + rounding,
         fmt::format("puts a footprint up to {:g} m, beyond the ground (ground.x: {:g} to {:g} m)",
                     to, x[0], x[1]),
         about);
}

// Told of the length where no place would be wide enough, else of the place, of footprints between
// `low` and `high`, m, on what `where` names.
void declare_across(const FootingParameters& footing, double low, double high,
                    const std::string& where, const input::About& about, input::Section& s) {
  const double from = footing.y - footing.length / 2, to = footing.y + footing.length / 2;
  const bool fits = footing.length <= high - low + rounding;
  s.rule(fits ? "footing.y" : "footing.length", from >= low - rounding && to <= high + rounding,
         fmt::format("puts footprints from y = {:g} to {:g} m, beyond {} (footing.{})", from, to,
                     where, fits ? "length" : "y"),
         about);
}

void declare_place(const Model& model, input::Section& s) {
  const FootingParameters& footing = model.footing;
  const fem::GroundParameters& ground = model.ground;
  const input::About about{.reads = {"ground", "footing", "track", "dimension"}};
  if (ground.x.size() != 2 || ground.y.size() != 2) return;  // another rule's sentence
  declare_along(model, about, s);
  s.rule("dimension", !is_plane(model) || !ground.of_tetrahedra(),
         "must be space on a ground of tetrahedra (ground.mesh, ground.section)", about);
  if (is_plane(model)) {
    const FootingParameters none;
    s.rule("footing.length", footing.length == none.length && footing.y == none.y,
           "and y have no effect in a plane model: footprints are as long as it is thick", about);
    return;
  }
  const double low = ground.y[0], high = ground.y[1];
  declare_across(footing, low, high,
                 fmt::format("the ground (ground.y: {:g} to {:g} m)", low, high), about, s);
  if (ground.sections.empty()) return;
  const auto [from, to] = extent_of(model);
  const double half = ground.narrowest_crest(from, to);
  declare_across(footing, -half, half,
                 fmt::format("the crest of ground.section ({:g} m on either side)", half), about,
                 s);
}

}  // namespace

void FootingParameters::declare(input::Section& s) {
  s.integer("before", before, {.at_least = 0, .at_most = 10000},
            "Sleepers of the track, on springs alone, before the first one on the ground.");
  s.integer("count", count, {.at_least = 1, .at_most = 10000}, "Sleepers on the ground.");
  s.number("first", first, {.unit = "m"}, "x, in the ground, of the first of them.");
  s.number("width", width, {.unit = "m", .at_least = 1e-3, .usually_to = 3},
           "Along the track, of what the ballast of a sleeper presses on.");
  s.number("length", length, {.unit = "m", .at_least = 1e-3, .usually_to = 5},
           "The same across the track (space; in a plane model its thickness); below two rails at "
           "least a sleeper's length.");
  s.number("y", y, {.unit = "m"}, "Middle of that (space).");
  s.number("rails", rails, {.above = 0, .at_most = 2},
           "Rails whose load the ground carries: 1 for half a track, 2 for a whole one and below "
           "two rails.");
}

// A plane model is as thick as its surface is wide. A pressure that is linear across the footprint
// has the force of a spring and acts below it, at `arm`, if it rises by 12 arm/length^2. Of a
// length that is the sleeper's, both springs together press as ballast does below a rigid sleeper
// that rolls (least squares); of a longer one with the same force and moment.
std::vector<couple::Rectangle> footprints_of(const Model& model) {
  const FootingParameters& footing = model.footing;
  const double across = is_plane(model) ? model.thickness : footing.length;
  const double middle = is_plane(model) ? 0 : footing.y;
  std::vector<couple::Rectangle> footprints;
  for (std::int64_t i = 0; i < footing.count; ++i) {
    const double x = footing.first + static_cast<double>(i) * model.track.line.track.spacing;
    couple::Rectangle print{.x = {x - footing.width / 2, x + footing.width / 2},
                            .y = {middle - across / 2, middle + across / 2}};
    print.tilt = 12 * model.track.line.track.bearing_arm() / (across * across);
    footprints.push_back(print);
    if (!two_rails(model)) continue;
    print.tilt = -print.tilt;
    footprints.push_back(print);
  }
  return footprints;
}

void declare_footing(const Model& model, input::Section& s) {
  if (model.kind != ModelKind::track_on_ground) {
    const auto text = [](FootingParameters footing) {
      return input::effective([&footing](input::Section& inner) { footing.declare(inner); });
    };
    return s.rule("footing", text(model.footing) == text({}),
                  "has no effect: sleepers of a bed lie on its stones (model = "
                  "\"track_on_ground\" has none)",
                  {.reads = {"footing", "model"}});
  }
  declare_kind(model, s);
  declare_idle_sides(model.ground, model.dimension, s);
  declare_track(model, s);
  declare_two_rails(model, s);
  declare_place(model, s);
  declare_overlap(model, s);
}

}  // namespace trackbed::app
