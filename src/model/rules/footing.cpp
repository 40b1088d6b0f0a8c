// A deck that cannot be computed, or whose meaning would differ from what it states, is an error.
#include "trackbed/model/footing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/rules/rules.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::model {

namespace {

bool is_plane(const Model& model) { return model.dimension == Dimension::plane; }
bool two_rails(const Model& model) { return model.track.line.track.dimension == Dimension::space; }

// The coupling needs both sides at the same instants, and a ground without weight. An implicit
// ground with another integrator than the track's can gain energy in the coupling
// (docs/decisions/track_on_ground.md).
void declare_kind(const Model& model, input::Section& s) {
  const input::About about{.reads = {"ground", "model"}};
  s.rule("ground.present", model.ground.present,
         "must be true for model = \"track_on_ground\"; without a ground give model = \"track\"",
         about);
  const fem::GroundParameters& ground = model.ground;
  const bool newmark = ground.integrator == fem::Integrator::newmark;
  s.rule("ground.integrator", newmark || ground.integrator == fem::Integrator::explicit_,
         "must be \"explicit\" or \"newmark\" with model = \"track_on_ground\": the track is "
         "integrated with average acceleration, and its coupling with other integrators can gain "
         "energy",
         about);
  s.rule("ground.newmark_beta",
         !newmark || (ground.newmark_beta == 0.25 && ground.newmark_gamma == 0.5),
         "must be 0.25, and ground.newmark_gamma 0.5, with model = \"track_on_ground\": the track "
         "is integrated with average acceleration, and its coupling with other integrators can "
         "gain energy",
         about);
  s.rule(
      "ground.layer", !model.ground.yields(),
      "must not yield below a track without stones: the weight of the ballast is not in the model",
      about);
}

// Sleepers on the ground are sleepers of the track between its run-ins.
void declare_track(const Model& model, input::Section& s) {
  const track::TrackParameters& track = model.track.line.track;
  const FootingParameters& footing = model.footing;
  const input::About about{.reads = {"track", "footing", "model"}};
  s.rule("track.support", track.support == track::Support::sleepers,
         "must be \"sleepers\": the ground carries the ballast springs below sleepers", about);
  const bool hangs = std::any_of(track.zones.begin(), track.zones.end(),
                                 [](const track::TrackZone& zone) { return zone.gap > 0; });
  s.rule("track.sleeper.model", !hangs || track.sleeper.model == track::SleeperModel::rigid,
         "must be \"rigid\" on a ground with hanging sleepers (gap of a track.zone)", about);
  s.rule("pad.uplift", !model.track.line.pad.uplift,
         "must be false on a ground: the rail can lift off its pads only on a track alone (model = "
         "\"track\")",
         {.reads = {"pad", "model"}});
  const double first = track.sleeper_x(static_cast<std::size_t>(footing.before));
  const double last = track.sleeper_x(static_cast<std::size_t>(footing.before + footing.count - 1));
  s.rule("footing.before", first >= track.run_in - same_length,
         fmt::format("the first sleeper on the ground is at {:g} m from the start of the track, "
                     "within the run-in of {:g} m; give at least {} sleepers before it, or a "
                     "shorter track.run_in",
                     first, track.run_in, sleepers_up_to(track, track.run_in - same_length)),
         about);
  s.rule("footing.count", last <= track.length - track.run_in + same_length,
         fmt::format("the last sleeper on the ground is at {0:g} m from the start of the track; it "
                     "must be before the run-out, the last {2:g} m of the {1:g} m of track",
                     last, track.length, track.run_in),
         about);
  s.rule("train.start", model.track.train.vehicles.empty() || model.track.train.start <= 0,
         "must be given and be at most 0 m on a ground: the train comes from the rigid rail before "
         "the track",
         {.reads = {"train", "model"}});
}

// Two rails need whole sleepers, on a ground that may deflect more below one end.
void declare_two_rails(const Model& model, input::Section& s) {
  if (!two_rails(model)) return;
  const FootingParameters& footing = model.footing;
  const double length = model.track.line.track.sleeper_length;
  s.rule(
      "track.dimension", !is_plane(model),
      "must be \"plane\" on a plane ground: two rails need a three-dimensional ground (dimension)",
      {.reads = {"track", "dimension", "model"}});
  s.rule("footing.rails", footing.rails == 2,
         "must be 2 if track.dimension = \"space\": the ground then carries both rails",
         {.reads = {"track", "footing"}});
  s.rule(
      "footing.length", is_plane(model) || footing.length >= length - same_length,
      fmt::format("must be at least the length of a sleeper (track.sleeper_length = {:g} m): with "
                  "two rails, whole sleepers load the ground, and the ballast spreads their load",
                  length),
      {.reads = {"track", "footing", "dimension"}});
}

// m, x of sleeper i on the ground and the width of its footprint.
std::array<double, 2> place_of(const Model& model, std::int64_t i) {
  const track::TrackParameters& track = model.track.line.track;
  const auto before = static_cast<std::size_t>(model.footing.before);
  const double along = track.sleeper_x(before + static_cast<std::size_t>(i));
  return {model.footing.first + along - track.sleeper_x(before),
          model.footing.width * track.factor(&track::TrackZone::footprint, along, 0)};
}

// m, extent of all footprints along x without factors of zones.
std::array<double, 2> extent_of(const Model& model) {
  const FootingParameters& footing = model.footing;
  const double last = place_of(model, footing.count - 1)[0];
  return {footing.first - footing.width / 2, last + footing.width / 2};
}

// Footprints that are wider by zones: the first that reaches beyond the ground, and the first that
// overlaps the next one.
void declare_wider(const Model& model, const input::About& about, input::Section& s) {
  const std::vector<double>& ground = model.ground.x;
  const double width = model.footing.width;
  for (std::int64_t i = 0; i < model.footing.count; ++i) {
    const auto [x, here] = place_of(model, i);
    const bool inside =
        x - here / 2 >= ground[0] - same_length && x + here / 2 <= ground[1] + same_length;
    if (here != width && !inside)
      return s.rule("track.zone", false,
                    fmt::format("`footprint` puts that of the sleeper at x = {:g} m of the ground "
                                "from {:g} to {:g} m, beyond the ground ({:g} to {:g} m)",
                                x, x - here / 2, x + here / 2, ground[0], ground[1]),
                    about);
  }
  for (std::int64_t i = 0; i + 1 < model.footing.count; ++i) {
    const auto [x, here] = place_of(model, i);
    const auto [further, next] = place_of(model, i + 1);
    if ((here != width || next != width) && (here + next) / 2 > further - x + same_length)
      return s.rule("track.zone", false,
                    fmt::format("`footprint` lets the footprints of neighbouring sleepers overlap, "
                                "first at x = {:g} m of the ground",
                                x),
                    {.severity = input::Severity::warning, .reads = about.reads});
  }
}

// m, between neighbouring sleepers on the ground, infinite for one; `unchanged`: only between those
// whose footprints have the width of [footing].
double least_distance(const Model& model, bool unchanged) {
  double least = std::numeric_limits<double>::infinity();
  for (std::int64_t i = 1; i < model.footing.count; ++i) {
    const auto [x, width] = place_of(model, i);
    const auto [before, other] = place_of(model, i - 1);
    if (!unchanged || (width == model.footing.width && other == width))
      least = std::min(least, x - before);
  }
  return least;
}

// Footprints may overlap, since ballast spreads loads, but most often the width is wrong.
void declare_overlap(const Model& model, input::Section& s) {
  const double least = least_distance(model, true);
  s.rule("footing.width", model.footing.width <= least + same_length,
         fmt::format(
             "is more than the spacing of sleepers ({:g} m): footprints of neighbouring sleepers "
             "overlap",
             least),
         {.severity = input::Severity::warning, .reads = {"footing", "track"}});
}

// Reports the parameter that is wrong: the width if it exceeds the spacing and the outermost
// sleepers have space enough beside them, otherwise the position.
void declare_along(const Model& model, const input::About& about, input::Section& s) {
  const FootingParameters& footing = model.footing;
  const std::vector<double>& x = model.ground.x;
  const auto [from, to] = extent_of(model);
  const double spacing = least_distance(model, false);
  const double space = std::min(from - x[0], x[1] - to) + footing.width / 2;
  const bool width = footing.width > spacing && space >= spacing / 2 - same_length;
  s.rule("footing.width", !width || footing.width / 2 <= space + same_length,
         fmt::format(
             "puts footprints from x = {:g} to {:g} m, beyond the ground (ground.x: {:g} to {:g} "
             "m); half the width must be at most {:g} m, the distance from the centre of the first "
             "or last sleeper to the end of the ground (see also footing.first)",
             from, to, x[0], x[1], space),
         about);
  s.rule(
      "footing.first", width || from >= x[0] - same_length,
      fmt::format(
          "the first footprint begins at x = {:g} m, beyond the ground (ground.x: {:g} to {:g} m)",
          from, x[0], x[1]),
      about);
  s.rule("footing.count", width || to <= x[1] + same_length,
         fmt::format(
             "the last footprint ends at x = {:g} m, beyond the ground (ground.x: {:g} to {:g} m)",
             to, x[0], x[1]),
         about);
}

// Reports the length if it exceeds the whole width, otherwise the position, of footprints that must
// lie between `low` and `high`, m, on the part named by `where`.
void declare_across(const FootingParameters& footing, double low, double high,
                    const std::string& where, const input::About& about, input::Section& s) {
  const double from = footing.y - footing.length / 2, to = footing.y + footing.length / 2;
  const bool fits = footing.length <= high - low + same_length;
  s.rule(fits ? "footing.y" : "footing.length",
         from >= low - same_length && to <= high + same_length,
         fmt::format("puts footprints from y = {:g} to {:g} m, beyond {}; see also footing.{}",
                     from, to, where, fits ? "length" : "y"),
         about);
}

void declare_place(const Model& model, input::Section& s) {
  const FootingParameters& footing = model.footing;
  const fem::GroundParameters& ground = model.ground;
  const input::About about{.reads = {"ground", "footing", "track", "dimension"}};
  if (ground.x.size() != 2 || ground.y.size() != 2) return;  // reported by another rule
  declare_along(model, about, s);
  declare_wider(model, about, s);
  s.rule("dimension", !is_plane(model) || !ground.of_tetrahedra(),
         "must be \"space\": a ground of tetrahedra is three-dimensional (ground.mesh, "
         "ground.section)",
         about);
  if (is_plane(model)) {
    const FootingParameters none;
    s.rule("footing.length", footing.length == none.length && footing.y == none.y,
           "footing.length and footing.y have no effect in a plane model, whose thickness is the "
           "length of the footprints; leave them out",
           about);
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
            "Number of sleepers on springs alone before the first one on the ground.");
  s.integer("count", count, {.at_least = 1, .at_most = 10000}, "Number of sleepers on the ground.");
  s.number("first", first, {.unit = "m"},
           "x of the first sleeper on the ground, in the coordinates of the ground.");
  s.number("width", width, {.unit = "m", .at_least = 1e-3, .usually_to = 3},
           "Width, along the track, of the footprint of a sleeper on the ground.");
  s.number("length", length, {.unit = "m", .at_least = 1e-3, .usually_to = 5},
           "Length of the footprint across the track (space; a plane model uses its thickness); "
           "with two rails it must be at least the sleeper length.");
  s.number("y", y, {.unit = "m"}, "y of the middle of the footprint (space).");
  s.number(
      "rails", rails, {.above = 0, .at_most = 2},
      "Number of rails whose load the ground carries: 1 for half a track; 2 for a whole track, "
      "whether track.dimension is plane or space; below 1 for a slice that carries this fraction "
      "of "
      "the load of one rail.");
}

// On a ground the sleepers are as large as the areas that they load, without the factors of zones.
// Without a ground, sleepers that do not bend have the default width and height of those that do.
observe::TrackShape shape_of_track(const Model& model) {
  const track::TrackParameters& track = model.track.line.track;
  observe::TrackShape shape{.width = track.sleeper.width,
                            .height = track.sleeper.height,
                            .length = track.sleeper_length,
                            .wheel_radius = model.track.wheel_rail.bodies.wheel_radius};
  if (model.kind != ModelKind::track_on_ground) return shape;
  const couple::Rectangle area = footprints_of(model).front();
  shape.origin =
      model.footing.first - track.sleeper_x(static_cast<std::size_t>(model.footing.before));
  shape.y = area.middle_y(), shape.width = model.footing.width;
  shape.length = area.y[1] - area.y[0];
  return shape;
}

// The surface of a plane model is as wide as its thickness. A linear pressure across the footprint
// has the force of a spring at the distance `arm` if its relative gradient is 12 arm/length^2. If
// the length is that of the sleeper, both springs together give the pressure of ballast below a
// rigid sleeper that rolls (least squares); if it is longer, the same force and moment.
std::vector<couple::Rectangle> footprints_of(const Model& model) {
  const FootingParameters& footing = model.footing;
  const double across = is_plane(model) ? model.thickness : footing.length;
  const double middle = is_plane(model) ? 0 : footing.y;
  std::vector<couple::Rectangle> footprints;
  for (std::int64_t i = 0; i < footing.count; ++i) {
    const auto [x, wide] = place_of(model, i);
    const double half = wide / 2;
    couple::Rectangle print{.x = {x - half, x + half},
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
  if (model.kind != ModelKind::track_on_ground)
    return s.rule("footing", !input::differs_from_default(model.footing),
                  "has no effect: it is for model = \"track_on_ground\"; sleepers of a bed rest on "
                  "its stones",
                  {.reads = {"footing", "model"}});
  declare_kind(model, s);
  declare_idle_sides(model.ground, model.dimension, s);
  declare_track(model, s);
  declare_two_rails(model, s);
  declare_place(model, s);
  declare_overlap(model, s);
}

}  // namespace trackbed::model
