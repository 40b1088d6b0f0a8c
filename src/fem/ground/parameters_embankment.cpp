// The part of [ground] that defines an embankment of layers.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "fem/mesh/embankment.hpp"

namespace trackbed::fem {

using input::About;
using input::Section;
using input::Severity;

namespace {

// Every rank builds all of them redundantly, five tetrahedra each, with some 5 kB during set-up.
constexpr double most_cells = 2e6;

const About of_shape{
    .reads = {"section", "layer", "embankment_layers", "x", "y", "elements_x", "elements_y"}};

// Parameters of a model of layers that tetrahedra do not support.
void refuse_others(const GroundParameters& p, Section& s) {
  const GroundParameters common;
  const auto without = [&](const char* key, bool holds, const char* why) {
    s.rule(key, holds, why, {.reads = {"section", key}});
  };
  constexpr std::array keys = {"side_x_low", "side_x_high", "side_y_low", "side_y_high"};
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Sides side = p.side(static_cast<int>(i / 2), i % 2 == 1);
    without(side == p.sides ? "sides" : keys[i],
            side != Sides::free_field && side != Sides::periodic,
            "cannot be free_field or periodic with ground.section, whose tetrahedra do not support "
            "these conditions; use free, roller, viscous or fixed");
  }
  const bool half = p.y.size() == 2 && p.y[0] == 0;
  without(
      "side_y_low", !half || p.side(1, false) == Sides::roller,
      "must be \"roller\" where y begins at 0: the axis of the embankment is a plane of symmetry");
  without("plane", p.plane == common.plane,
          "has no effect with ground.section: an embankment is for three-dimensional models");
}

// Which layers are raised, and that each has rows of its own. The other checks need this.
bool declare_layers(const GroundParameters& p, Section& s) {
  const auto layers = static_cast<std::int64_t>(p.layers.size());
  const bool some = p.embankment_layers >= 1 && p.embankment_layers < layers;
  s.rule(
      "embankment_layers", some,
      fmt::format("must be at least 1 and below the number of layers, {}: the uppermost layers are "
                  "the embankment of ground.section, and at least one layer is the natural ground",
                  layers),
      of_shape);
  const bool rows = std::all_of(p.layers.begin(), p.layers.end(),
                                [](const Layer& layer) { return layer.elements > 0; });
  s.rule("layer", rows,
         "must all have `elements` with ground.section: element boundaries must coincide with "
         "layer boundaries, because the foot of the slope lies on a layer boundary",
         of_shape);
  const double cells = static_cast<double>(p.elements_x) * static_cast<double>(p.elements_y) *
                       static_cast<double>(p.elements_over_depth());
  s.rule("elements_x", cells <= most_cells,
         fmt::format("gives, with elements_y and elements_z, {:.3g} cells of five tetrahedra each; "
                     "at most {:g} are supported with ground.section",
                     cells, most_cells),
         of_shape);
  return some && rows && cells <= most_cells;
}

bool declare_order(const GroundParameters& p, Section& s) {
  bool rises = true;
  for (std::size_t i = 1; i < p.sections.size(); ++i) {
    const bool next = p.sections[i].x > p.sections[i - 1].x;
    s.rule(fmt::format("section[{}].x", i), next,
           fmt::format("must be beyond that of the previous section ({:g} m)", p.sections[i - 1].x),
           of_shape);
    rises = rises && next;
  }
  return rises;
}

// The lowest embankment layer is as thick as the height leaves it below the layers above it. What
// it gains beyond its own thickness is missing in the lowest natural layer.
void declare_section_height(const GroundParameters& p, std::size_t number, Section& s) {
  const CrossSection section = p.section_at(p.sections[number].x);
  const std::vector<double> thick = thicknesses(p, section);
  const auto lowest = static_cast<std::size_t>(p.embankment_layers) - 1;  // of the embankment
  double above = 0;                                                       // m, thickness
  for (std::size_t l = 0; l < lowest; ++l) above += p.layers[l].thickness;
  const double sum = above + p.layers[lowest].thickness;
  const std::string key = fmt::format("section[{}].height", number);
  s.rule(key, thick[lowest] > same_place,
         fmt::format("a height of {:g} m is {:g} m less than the sum of the embankment layers "
                     "({:g} m); the lowest of them, \"{}\", is reduced by this difference and "
                     "would be {:g} m thick; increase the height to more than {:g} m or make the "
                     "layers above it thinner",
                     section.height, sum - section.height, sum, p.layers[lowest].name,
                     thick[lowest], above),
         of_shape);
  const Layer& natural = p.layers.back();
  s.rule(
      key, thick.back() > same_place,
      fmt::format("a height of {:g} m exceeds the sum of the embankment layers ({:g} m) by {:g} m; "
                  "the lowest natural layer, \"{}\", is reduced by this difference and would be "
                  "{:g} m thick; reduce the height to less than {:g} m or make \"{}\" thicker",
                  section.height, sum, section.height - sum, natural.name, thick.back(),
                  sum + natural.thickness, natural.name),
      of_shape);
}

// m, from the axis, of the feet at both ends and at the sections between, with straight lines
// between them.
std::vector<double> feet(const GroundParameters& p) {
  std::vector<double> found = {p.section_at(p.x[0]).foot(), p.section_at(p.x[1]).foot()};
  for (const CrossSection& one : p.sections)
    if (one.x > p.x[0] && one.x < p.x[1]) found.push_back(p.section_at(one.x).foot());
  return found;
}

// Position of a side of the ground relative to all feet: beyond, or at them.
enum class Beside { ground, nothing, mixed, too_near };
Beside beside(const std::vector<double>& feet, double side) {
  bool ground = true, nothing = true;
  for (const double foot : feet) {
    const double left = side - foot;
    if (left < -same_place) return Beside::too_near;
    ground = ground && left > same_place;
    nothing = nothing && left <= same_place;
  }
  return ground ? Beside::ground : nothing ? Beside::nothing : Beside::mixed;
}

// m: begin and end along the track of the vertical outside of the embankment, as its faces are at
// element borders; if there is none the second is not beyond the first.
std::array<double, 2> upright(const GroundParameters& p) {
  std::array<double, 2> found{0, 0};
  const std::vector<double> edges = p.edges(0);
  const auto slopes = [&](double x) {
    const CrossSection one = p.section_at(x);
    return one.foot() - one.crest > same_place;
  };
  for (std::size_t i = 1; i < edges.size(); ++i) {
    if (slopes(edges[i - 1]) || slopes(edges[i])) continue;
    if (found[1] <= found[0]) found[0] = edges[i - 1];
    found[1] = edges[i];
  }
  return found;
}

// Where the ground ends at the foot of a vertical embankment, its outside is a side of the ground
// and has its boundary condition: useful for a column or a slab, but any slope, however steep,
// would be free. `ends`: whether it ends so at low and high y; `sides` is reported once.
void declare_upright(const GroundParameters& p, const std::array<bool, 2>& ends, Section& s) {
  const auto [from, to] = upright(p);
  bool named = false;
  for (const bool high : {false, true}) {
    if (!ends[high ? 1 : 0] || p.side(1, high) == Sides::free || to <= from) continue;
    const bool common = (high ? p.side_y_high : p.side_y_low) == Sides::as_sides;
    const char* key = common ? "sides" : high ? "side_y_high" : "side_y_low";
    s.rule(key, common && named,
           fmt::format("also applies to the vertical side faces of the embankment (x = {:g} to "
                       "{:g} m), because the ground ends there; to leave these faces free, use a "
                       "small slope (1e-4) or set \"free\" for these sides (side_y_low, "
                       "side_y_high)",
                       from, to),
           {.severity = Severity::warning,
            .reads = {"section", "layer", "x", "y", "elements_x", key}});
    named = named || common;
  }
}

void declare_widths(const GroundParameters& p, Section& s) {
  std::int64_t columns = 1;
  std::array<bool, 2> ends{};
  for (const bool high : {false, true}) {
    const double side = high ? p.y[1] : -p.y[0];
    if (side == 0 && p.y[0] == 0) continue;  // half an embankment
    const std::vector<double> all = feet(p);
    const Beside found = beside(all, side);
    const double foot = *std::max_element(all.begin(), all.end());
    s.rule("y", found != Beside::too_near,
           fmt::format("ends within the embankment: its foot is {:g} m from the axis; make the "
                       "ground wider, or the crest narrower (y may begin at 0: half an embankment)",
                       foot),
           of_shape);
    s.rule("y", found != Beside::mixed,
           "ends at the foot of some sections and beyond the foot of others; leave ground beside "
           "all sections or beside none",
           of_shape);
    columns += found == Beside::ground ? 1 : 0;
    ends[high ? 1 : 0] = found == Beside::nothing;
  }
  s.rule("elements_y", p.elements_y >= columns,
         fmt::format("must be at least {}: one below the crest, and one beside each foot", columns),
         of_shape);
  declare_upright(p, ends, s);
}

// Change of crest, height and foot (m/m) from a section to the next; zero beyond the last section,
// and for `number` -1 before the first.
Vec3 change_behind(const GroundParameters& p, std::int64_t number) {
  const auto at = [&](std::int64_t n) {
    const CrossSection one = p.section_at(p.sections[static_cast<std::size_t>(n)].x);
    return Vec3(one.crest, one.height, one.foot());
  };
  const auto of = [&](std::int64_t n) { return p.sections[static_cast<std::size_t>(n)].x; };
  const bool between = number >= 0 && number + 1 < static_cast<std::int64_t>(p.sections.size());
  if (!between) return Vec3::Zero();
  return (at(number + 1) - at(number)) / (of(number + 1) - of(number));
}

// Cells follow the kinks of the shape at sections only if a row ends there. The first and the last
// section also are kinks: beyond them the shape is constant.
void declare_places(const GroundParameters& p, std::size_t number, Section& s) {
  constexpr double straight = 1e-9;
  const double x = p.sections[number].x;
  const auto here = static_cast<std::int64_t>(number);
  const Vec3 kink = change_behind(p, here) - change_behind(p, here - 1);
  if (kink.cwiseAbs().maxCoeff() <= straight) return;
  const std::vector<double> edges = p.edges(0);
  const bool on_edge = std::any_of(edges.begin(), edges.end(),
                                   [&](double edge) { return std::abs(edge - x) < same_place; });
  s.rule(fmt::format("section[{}].x", number), on_edge || x < edges.front() || x > edges.back(),
         "is not at an element boundary along x: the change of shape at this section is smoothed "
         "over one element; change elements_x",
         {.severity = Severity::warning, .reads = of_shape.reads});
}

}  // namespace

void CrossSection::declare(Section& s) {
  s.number("x", x, {.unit = "m"},
           "Position of the section along the track; sections are listed with increasing x.");
  s.number("crest", crest, {.unit = "m", .above = 0, .usually_from = 0.5, .usually_to = 50},
           "Half-width of the crest, from y = 0 to either side.");
  s.number("height", height, {.unit = "m", .at_least = 0, .usually_to = 50},
           "Height of the crest above the natural ground; 0: sum of the embankment layers. If the "
           "height differs from this sum, the thickness of the lowest embankment layer changes by "
           "the difference, and that of the lowest natural layer by the opposite amount.");
  s.number("slope", slope, {.at_least = 0, .usually_to = 10},
           "Slope of the sides, horizontal to vertical; 0: vertical faces. If y ends at vertical "
           "faces, side_y_low and side_y_high (or `sides`) also apply to them.");
}

void GroundParameters::check_embankment(Section& s) const {
  if (sections.empty()) {
    s.rule("embankment_layers", embankment_layers == 0, "has no effect without ground.section",
           of_shape);
    return;
  }
  refuse_others(*this, s);
  const bool whole = x.size() == 2 && y.size() == 2 && x[1] > x[0] && y[1] > y[0];
  if (!mesh.empty() || !whole || !declare_layers(*this, s) || !declare_order(*this, s)) return;
  for (std::size_t i = 0; i < sections.size(); ++i) declare_section_height(*this, i, s);
  for (std::size_t i = 0; i < sections.size(); ++i) declare_places(*this, i, s);
  declare_widths(*this, s);
}

}  // namespace trackbed::fem
