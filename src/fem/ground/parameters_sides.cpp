// The part of [ground] that defines the boundary conditions of lateral sides, and the wave from
// below for which some of them are made.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "fem/time/base_motion.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/fem/wave_report.hpp"

namespace trackbed::fem {

using input::About;
using input::Section;
using input::Severity;

namespace {

struct NamedSide {
  const char* key;
  Sides holds;
};

std::array<NamedSide, 4> single_sides(const GroundParameters& p) {
  return {{{"side_x_low", p.side_x_low},
           {"side_x_high", p.side_x_high},
           {"side_y_low", p.side_y_low},
           {"side_y_high", p.side_y_high}}};
}

// Both sides of the axis to which this one is normal; for `sides`, of the first axis that is not
// periodic.
std::string both_periodic(const GroundParameters& p, const std::string& key) {
  const bool across = key.starts_with("side_y") || (key == "sides" && p.periodic(0));
  const char* axis = across ? "y" : "x";
  return fmt::format("side_{0}_low = side_{0}_high = \"periodic\"", axis);
}

// A boundary condition that transmits the wave, if the ground supports it. Free fields are elastic.
std::string better(const GroundParameters& p, const std::string& key) {
  if (p.of_tetrahedra())
    return "; use roller where the wave moves the ground parallel to this side, otherwise place "
           "the side further away";
  const char* elastic = p.yields() ? "" : "free_field or ";
  return fmt::format("; use {}{}", elastic, both_periodic(p, key));
}

// Requirements of a boundary condition, and parameters that it leaves without effect.
void declare_kind(const GroundParameters& p, const NamedSide& side, const std::string& before,
                  Section& s) {
  const std::string key = before + side.key;
  const About odd{
      .severity = Severity::warning,
      .reads = {before + "base", before + "base_motion", before + "layer", before + "block", key}};
  s.rule(key, side.holds != Sides::free_field || !p.base_motion.empty(),
         "acts as a viscous side: without base_motion the ground beside the model is at rest; give "
         "base_motion or use viscous",
         odd);
  const bool holds_back = side.holds == Sides::viscous || side.holds == Sides::fixed;
  s.rule(key, p.base_motion.empty() || !holds_back,
         "impedes the wave of base_motion" + better(p, side.key), odd);
  s.rule(
      key, !p.yields() || side.holds != Sides::free_field,
      fmt::format("has elastic columns beside the model, which do not match yielding layers; use "
                  "{}",
                  p.base_motion.empty() || p.of_tetrahedra() ? "viscous or roller"
                                                             : both_periodic(p, side.key)),
      {.reads = {key, before + "base_motion", before + "layer", before + "block"}});
}

// Columns beside the lateral sides are those of the first row of elements.
void declare_blocks(const GroundParameters& p, Section& s) {
  bool columns = false;
  for (const int axis : {0, 1})
    columns = columns || p.side(axis, false) == Sides::free_field ||
              p.side(axis, true) == Sides::free_field;
  for (std::size_t b = 0; b < p.blocks.size(); ++b) {
    const std::string key = fmt::format("block[{}].y", b);
    s.rule(key, !columns || p.blocks[b].y.empty(),
           "cannot be given with free-field sides: their columns do not vary across the track",
           {.reads = {key, "sides", "side_x_low", "side_x_high", "side_y_low", "side_y_high"}});
  }
}

// Whether the first and the last element along an axis have the same size.
bool alike_at_both_ends(const GroundParameters& p, int axis) {
  constexpr double rounding = 1e-6;
  const std::vector<double>& range = axis == 0 ? p.x : p.y;
  const double ratio = axis == 0 ? p.ratio_x : p.ratio_y;
  if (ratio == 1 || range.size() != 2 || range[1] <= range[0]) return true;
  const std::vector<double> edges = p.edges(axis);
  const double first = edges[1] - edges[0], last = edges.back() - edges[edges.size() - 2];
  return std::abs(last - first) <= rounding * first;
}

// Both ends of an axis are joined: they need the same condition, and elements of the same size.
void declare_periodic(const GroundParameters& p, int axis, Section& s) {
  const auto sides = single_sides(p);
  const NamedSide &low = sides[2 * static_cast<std::size_t>(axis)],
                  &high = sides[2 * static_cast<std::size_t>(axis) + 1];
  const About both{.reads = {low.key, high.key}};
  const auto one_alone = [&](const NamedSide& one, const NamedSide& other) {
    s.rule(one.key, one.holds != Sides::periodic || other.holds == Sides::periodic,
           fmt::format("needs {} = \"periodic\": both ends of the ground are joined", other.key),
           both);
  };
  one_alone(low, high), one_alone(high, low);
  const char* name = axis == 0 ? "x" : "y";
  s.rule(low.key, !p.periodic(axis) || alike_at_both_ends(p, axis),
         fmt::format("joins elements of different size; use ratio_{0} = 1 or fine_{0} at the "
                     "middle of the ground",
                     name),
         {.reads = {low.key, high.key, name, fmt::format("elements_{}", name),
                    fmt::format("ratio_{}", name), fmt::format("fine_{}", name)}});
}

// Effect of a side normal to `axis` on a wave, beyond declare_kind; or nothing. Motion along x
// contradicts a side that holds x. A free side carries no stress: that of a wave along x acts on
// sides across the track, that of one along z on all.
WaveAtSide wave_at(const GroundParameters& p, const NamedSide& side, int axis,
                   const BaseMotion& wave) {
  const bool holds = side.holds == Sides::fixed || side.holds == Sides::roller;
  if (holds && axis == 0 && wave.moves(0))
    return {side.key, side.holds == Sides::fixed ? "fixed" : "roller",
            "holds the ends of the ground, which base_motion moves along the track (vx_m_s is not "
            "0)" +
                (p.of_tetrahedra() ? "; use viscous or free, and place the side far from the track"
                                   : better(p, side.key)),
            true};
  if (side.holds == Sides::free && (axis == 0 || wave.moves(2)))
    return {side.key, "free",
            "has no ground beside it that moves with base_motion" + better(p, side.key)};
  return {};
}

}  // namespace

std::vector<WaveAtSide> look_at_wave(const GroundParameters& parameters, Dimension dimension) {
  std::vector<WaveAtSide> found;
  if (!parameters.present || parameters.base_motion.empty()) return found;
  const BaseMotion wave(parameters.base_motion);
  const auto sides = single_sides(parameters);
  const std::size_t count = dimension == Dimension::space ? 4 : 2;
  for (std::size_t k = 0; k < count; ++k) {
    const int axis = k < 2 ? 0 : 1;
    const bool own = sides[k].holds != Sides::as_sides;
    const WaveAtSide at = wave_at(
        parameters, {own ? sides[k].key : "sides", parameters.side(axis, k % 2 != 0)}, axis, wave);
    const bool reported = std::any_of(found.begin(), found.end(),
                                      [&](const WaveAtSide& one) { return one.key == at.key; });
    if (!at.key.empty() && !reported) found.push_back(at);
  }
  return found;
}

void declare_common_side(const GroundParameters& parameters, Section& s) {
  declare_kind(parameters, {"sides", parameters.sides}, "ground.", s);
}

Sides GroundParameters::side(int axis, bool high) const {
  const Sides own = axis == 0 ? (high ? side_x_high : side_x_low) : high ? side_y_high : side_y_low;
  return own == Sides::as_sides ? sides : own;
}

// Without a wave from below the ground beside the model is at rest, and a viscous side is
// sufficient.
void GroundParameters::declare_sides(Section& s) {
  const auto fixed = s.fixed_by(input::state::moved_ground);
  s.choice("sides", sides, {"free", "roller", "viscous", "free_field"},
           "Boundary condition of all sides; roller: held along the normal, as in a plane of "
           "symmetry; viscous: dashpots that absorb waves; free_field: dashpots that act on the "
           "velocity relative to free-field columns, which base_motion excites. Periodic sides are "
           "given in pairs, as side_x_low and side_x_high.");
  const auto one = [&](const char* key, Sides& side, const char* where) {
    s.choice(key, side,
             {"free", "roller", "viscous", "free_field", "fixed", "as_sides", "periodic"},
             fmt::format("Boundary condition of the side at the {}; as_sides: that of `sides`; "
                         "fixed: held in all directions; periodic: joined to the opposite side.",
                         where));
  };
  one("side_x_low", side_x_low, "lowest x");
  one("side_x_high", side_x_high, "highest x");
  one("side_y_low", side_y_low, "lowest y");
  one("side_y_high", side_y_high, "highest y");
  s.file(
      "base_motion", base_motion,
      "CSV of a wave that enters through a viscous base, with columns time_s (from the start of "
      "the ground's motion), vx_m_s, vz_m_s (velocity of the upward wave, that is, half of the "
      "velocity recorded at an outcrop); empty: none. Rows before 0 s have no effect on the "
      "ground. The wave must be at rest in the first and in the last row; a row at either end with "
      "at most 1e-9 of the largest speed counts as at rest.");
  s.rule("base_motion", base_motion.empty() || base == Base::viscous,
         "needs base = \"viscous\": a wave enters through its dashpots",
         {.reads = {"base", "sides", "base_motion"}});
  s.rule("base_stiffness", base_stiffness <= 0 || base_motion.empty(),
         "must be 0 or left out with base_motion: springs would oppose the motion of the base",
         {.reads = {"base_stiffness", "base_motion"}});
  for (const NamedSide& side : single_sides(*this)) declare_kind(*this, side, "", s);
  for (const int axis : {0, 1}) declare_periodic(*this, axis, s);
  declare_blocks(*this, s);
}

}  // namespace trackbed::fem
