// The deck section [ground]: every number is declared once, with unit, range and meaning.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

using input::About;
using input::Section;

namespace {

// Of several ranks; a mistaken unit is found before memory is. Not tried with more.
constexpr double most_elements = 1e8;

// Minimum number of corners of an outline; two numbers per corner.
constexpr std::size_t fewest_corners = 3;
// At this value the bulk modulus is 1700 times the shear modulus and rounding affects the pressure.
constexpr double largest_poisson = 0.4999;

// s, stiffness-proportional damping: 3 % of critical at 1 Hz. A larger value is probably a damping
// ratio.
constexpr double longest_usual = 0.01;

// Of the extent of the ground: an outline may end where the ground ends.
constexpr double rounding = 1e-9;

// An interval of x or z, to compare a block with the ground and its elements.
struct Range {
  double low, high;  // m
  bool holds(const Range& other) const {
    const double margin = rounding * (high - low);
    return other.low >= low - margin && other.high <= high + margin;
  }
};

// m, width of the elements between these borders whose centres are in a range; below 0: none.
double width_in(const Range& range, const std::vector<double>& edges) {
  double sum = -1;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const double centre = 0.5 * (edges[i] + edges[i + 1]);
    if (centre < range.low || centre > range.high) continue;
    sum = std::max(sum, 0.0) + edges[i + 1] - edges[i];
  }
  return sum;
}

// Range of every second number from `first`.
Range range_of(const std::vector<double>& outline, std::size_t first) {
  Range range{outline[first], outline[first]};
  for (std::size_t k = first; k < outline.size(); k += 2)
    range = {std::min(range.low, outline[k]), std::max(range.high, outline[k])};
  return range;
}

// Position of a block, judged by the bounding box of its outline. An error if it changes no
// element: the block would be ignored without notice.
void declare_place(const GroundParameters& ground, std::size_t number, Section& s) {
  const Block& block = ground.blocks[number];
  if (!ground.present || !block.present || block.outline.size() < 2 || ground.x.size() != 2) return;
  const std::string key = fmt::format("block[{}].outline", number);
  double depth = 0;
  for (const Layer& layer : ground.layers) depth += layer.thickness;
  const Range x{ground.x[0], ground.x[1]}, z{-depth, 0};
  const Range wide = range_of(block.outline, 0), high = range_of(block.outline, 1);
  const About about{.reads = {"x", "elements_x", "ratio_x", "fine_x", "elements_z", "layer", key}};
  const std::string place =
      fmt::format("the ground (x = {:g} to {:g} m, z = {:g} to 0 m)", x.low, x.high, z.low);
  if (high.high > rounding * depth)
    return s.rule(key, false,
                  fmt::format("has a corner at z = {:g} m, above {}; z is negative below the top",
                              high.high, place),
                  about);
  // Cells of an embankment are not boxes: look_at_mesh counts them.
  const bool level = ground.sections.empty();
  if (level && (width_in(wide, ground.edges(0)) < 0 || width_in(high, ground.edges(2)) < 0))
    return s.rule(key, false,
                  fmt::format("does not contain the centre of any element of {}; move or enlarge "
                              "the block, use smaller elements, or set present = false",
                              place),
                  about);
  s.rule(key, x.holds(wide) && z.holds(high),
         fmt::format("is cut off where it extends beyond {}", place),
         {.severity = input::Severity::warning, .reads = about.reads});
}

// Position across the track, in space.
void declare_width(const GroundParameters& ground, std::size_t number, Section& s) {
  const Block& block = ground.blocks[number];
  if (!ground.present || !block.present || block.y.size() != 2 || ground.y.size() != 2) return;
  const std::string key = fmt::format("block[{}].y", number);
  const Range y{ground.y[0], ground.y[1]}, wide{block.y[0], block.y[1]};
  const About about{.reads = {"y", "elements_y", "ratio_y", "fine_y", key}};
  const std::string place = fmt::format("the ground (y = {:g} to {:g} m)", y.low, y.high);
  if (ground.sections.empty() && width_in(wide, ground.edges(1)) < 0)
    return s.rule(
        key, false,
        fmt::format("does not contain the centre of any element of {}; move or widen the block",
                    place),
        about);
  s.rule(key, y.holds(wide), fmt::format("is cut off where it extends beyond {}", place),
         {.severity = input::Severity::warning, .reads = about.reads});
}

// A layer between the centres of two rows of elements would be left out without notice.
void declare_height(const GroundParameters& ground, std::size_t number, Section& s) {
  if (!ground.present || ground.elements_z < 1 || ground.layers[number].thickness <= 0) return;
  const std::string key = fmt::format("layer[{}].thickness", number);
  const About about{.reads = {"elements_z", "layer"}};
  Range range{0, 0};
  for (std::size_t l = 0; l <= number; ++l)
    range = {range.low - ground.layers[l].thickness, range.low};
  const double made = width_in(range, ground.edges(2)), asked = range.high - range.low;
  if (made < 0)
    return s.rule(
        key, false,
        fmt::format(
            "is too small: the layer does not contain the centre of any element ({:.3g} m high) "
            "and would be left out; give each layer its `elements`, or increase elements_z",
            (ground.edges(2).back() - ground.edges(2).front()) /
                static_cast<double>(ground.elements_z)),
        about);
  // Of its height; larger deviations are reported. Deviations of 5 %, as of 1 m in rows of 0.15 m,
  // are seldom avoidable; the rest is for rounding.
  constexpr double odd = 0.051;
  s.rule(
      key, std::abs(made - asked) <= odd * asked,
      fmt::format("becomes {:.3g} m, the total height of the rows of elements whose centres are in "
                  "the layer; give each layer its `elements`, or increase elements_z",
                  made),
      {.severity = input::Severity::warning, .reads = about.reads});
}

// Twice the area of the triangle of three corners of an outline, m^2; above 0: it turns left.
double turn(const std::vector<double>& outline, std::size_t a, std::size_t b, std::size_t c) {
  const auto x = [&](std::size_t k) { return outline[2 * k]; };
  const auto z = [&](std::size_t k) { return outline[2 * k + 1]; };
  return (x(b) - x(a)) * (z(c) - z(a)) - (z(b) - z(a)) * (x(c) - x(a));
}

// Whether two edges of an outline intersect. Edges that only touch are permitted, since any point
// is still either inside or outside. O(corners^2), of a handful of corners.
bool crosses_itself(const std::vector<double>& outline) {
  const std::size_t corners = outline.size() / 2;
  const auto parts = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    return turn(outline, a, b, c) * turn(outline, a, b, d) < 0;  // c and d on opposite sides of a-b
  };
  for (std::size_t a = 0; a < corners; ++a)
    for (std::size_t c = a + 2; c < corners; ++c) {
      const std::size_t b = a + 1, d = (c + 1) % corners;
      if (parts(a, b, c, d) && parts(c, d, a, b)) return true;
    }
  return false;
}

// Consistency of layers and numbers of elements.
void declare_elements(const GroundParameters& p, Section& s) {
  const bool all = std::all_of(p.layers.begin(), p.layers.end(),
                               [](const Layer& layer) { return layer.elements > 0; });
  s.rule("layer", all || !p.layers_have_elements(), "must all have `elements`, or none of them",
         {.reads = {"layer"}});
  s.rule("elements_z", !p.layers_have_elements() || p.elements_z == GroundParameters().elements_z,
         "has no effect: layers have their own `elements`",
         {.severity = input::Severity::warning, .reads = {"elements_z", "layer"}});
  const double elements = static_cast<double>(p.elements_x) * static_cast<double>(p.elements_y) *
                          static_cast<double>(p.elements_over_depth());
  s.rule("elements_x", !p.present || elements <= most_elements,
         fmt::format("gives {:.3g} elements together with elements_y and elements_z; at most {:g} "
                     "are supported",
                     elements, most_elements),
         {.reads = {"elements_x", "elements_y", "elements_z", "layer"}});
}

// Numerical damping of frequencies that the windows do not resolve, without loss of order. HHT is
// unconditionally stable down to -1/3 (Hilber, Hughes, Taylor 1977), Bossak also below.
void declare_alphas(GroundParameters& p, Section& s) {
  s.number("alpha", p.alpha, {.at_least = -1, .at_most = 0},
           "Parameter alpha of the numerical damping (bossak; hht: from -1/3); 0: none; more "
           "negative values give more damping.");
  s.rule("alpha", p.integrator != Integrator::hht || p.alpha >= -1.0 / 3,
         "must be at least -1/3 for hht, or the integrator is not unconditionally stable",
         {.reads = {"integrator", "alpha"}});
  s.number("rho_inf", p.rho_inf, {.at_least = 0, .at_most = 1},
           "Spectral radius at infinite frequency (generalized_alpha); 1: no numerical damping.");
}

// Parameters of integrators that are not used have no effect.
void declare_idle_numbers(const GroundParameters& p, Section& s) {
  const GroundParameters usual;
  const auto idle = [&](const char* key, double given, double left, bool acts, const char* of) {
    s.rule(key, acts || given == left, fmt::format("has no effect: it is for integrator = {}", of),
           {.severity = input::Severity::warning, .reads = {"integrator", key}});
  };
  const bool newmark = p.integrator == Integrator::newmark;
  idle("safety", p.safety, usual.safety, p.integrator == Integrator::explicit_, "\"explicit\"");
  idle("newmark_beta", p.newmark_beta, usual.newmark_beta, newmark, "\"newmark\"");
  idle("newmark_gamma", p.newmark_gamma, usual.newmark_gamma, newmark, "\"newmark\"");
  idle("alpha", p.alpha, usual.alpha,
       p.integrator == Integrator::hht || p.integrator == Integrator::bossak,
       "\"hht\" and \"bossak\"");
  idle("rho_inf", p.rho_inf, usual.rho_inf, p.integrator == Integrator::generalized_alpha,
       "\"generalized_alpha\"");
}

// A damping ratio in place of the coefficient would be almost none.
void declare_small_damping(double rayleigh_mass, Section& s) {
  constexpr double least = 0.1;  // 1/s: 0.1 % of critical at 8 Hz
  s.rule("rayleigh_mass", rayleigh_mass <= 0 || rayleigh_mass >= least,
         fmt::format("is small: the damping ratio is rayleigh_mass/(4 pi f), {:.2g} at f = 10 Hz; "
                     "is it meant as a ratio?",
                     rayleigh_mass / (40 * std::numbers::pi)),
         {.severity = input::Severity::warning, .reads = {"rayleigh_mass"}});
}

bool rises(const std::vector<double>& range) { return range.size() != 2 || range[1] > range[0]; }

}  // namespace

void Elastic::declare(Section& s) {
  auto fixed = s.fixed_by(input::state::moved_ground);
  // From very soft clay to more than steel: values beyond are most often in another unit.
  s.number("young", young, {.unit = "Pa", .above = 0, .usually_from = 5e5, .usually_to = 3e11},
           "Young's modulus.");
  s.number("poisson", poisson, {.at_least = 0, .at_most = largest_poisson}, "Poisson's ratio.");
  s.number("density", density,
           {.unit = "kg/m^3", .above = 0, .usually_from = 500, .usually_to = 2e4}, "Mass density.");
  fixed.end();
  s.number("rayleigh_mass", rayleigh_mass, {.unit = "1/s", .at_least = -1},
           "Coefficient of mass-proportional Rayleigh damping; below 0: that of the ground.");
  s.number("rayleigh_stiffness", rayleigh_stiffness,
           {.unit = "s", .at_least = -1, .at_most = 1e3, .usually_to = longest_usual},
           "Coefficient of stiffness-proportional Rayleigh damping; below 0: that of the ground.");
  declare_small_damping(rayleigh_mass, s);
}

// Parameters of a triaxial test. A dilation angle above the friction angle would create energy; a
// cut-off beyond the apex would have no effect.
void Strength::declare(Section& s) {
  const auto fixed = s.fixed_by(input::state::moved_ground);
  s.choice("yield", yield, {"none", "mohr_coulomb"},
           "Yield criterion; none: elastic at any stress; mohr_coulomb: with tension cut-off, "
           "without hardening.");
  s.number("cohesion", cohesion,
           {.unit = "Pa", .at_least = 0, .usually_from = 100, .usually_to = 1e7},
           "Cohesion (mohr_coulomb).");
  s.number("friction_angle", friction_angle,
           {.unit = "degrees", .at_least = 0, .at_most = 60, .usually_from = 5},
           "Angle of internal friction (mohr_coulomb).");
  s.number("dilation_angle", dilation_angle,
           {.unit = "degrees", .at_least = 0, .at_most = 60, .usually_from = 1},
           "Dilation angle (mohr_coulomb), at most friction_angle.");
  s.number("tensile_strength", tensile_strength,
           {.unit = "Pa", .at_least = 0, .usually_from = 100, .usually_to = 1e7},
           "Tensile strength, i.e. tension cut-off (mohr_coulomb).");
  if (yield == Yield::none) {
    const Strength common;
    s.rule("yield",
           cohesion == common.cohesion && friction_angle == common.friction_angle &&
               dilation_angle == common.dilation_angle &&
               tensile_strength == common.tensile_strength,
           "must be \"mohr_coulomb\" for cohesion, angles and tensile_strength to have an effect",
           {.severity = input::Severity::warning});
    return;
  }
  const About about{.reads = {"cohesion", "friction_angle", "dilation_angle", "tensile_strength"}};
  s.rule("friction_angle", cohesion > 0 || friction_angle > 0,
         "must be above 0 if cohesion is 0: otherwise the solid has no shear strength", about);
  s.rule("dilation_angle", dilation_angle <= friction_angle,
         fmt::format("must be at most friction_angle ({:g} degrees), or yielding may create energy",
                     friction_angle),
         about);
  const double slope = std::tan(friction_angle * std::numbers::pi / 180);
  s.rule("tensile_strength", slope * tensile_strength <= cohesion * (1 + rounding),
         fmt::format("must be at most cohesion / tan(friction_angle) = {:.6g} Pa, the tension at "
                     "the apex of the yield surface",
                     slope > 0 ? cohesion / slope : 0.0),
         about);
  s.rule("cohesion", cohesion > 0,
         "should be above 0: where the top is not loaded, the ground would have no strength and "
         "would yield under the first wave; moist sand has an apparent cohesion of some kPa",
         {.severity = input::Severity::warning, .reads = about.reads});
}

void Layer::declare(Section& s) {
  s.text("name", name, "Name of the layer in messages and overrides.");
  auto fixed = s.fixed_by(input::state::any);
  s.number("thickness", thickness,
           {.unit = "m", .at_least = 1e-4, .usually_from = 0.01, .usually_to = 200},
           "Thickness of the layer; if `elements` is not given, the layer boundaries need not "
           "coincide with element boundaries.");
  s.integer("elements", elements, {.at_least = 0, .at_most = 1e5},
            "Number of elements over the thickness, for all layers or none; 0: elements_z divides "
            "the depth evenly, and the layer consists of the elements whose centres lie in it.");
  fixed.end();
  solid.declare(s);
  const auto fixed_strength = s.fixed_by(input::state::moved_ground);
  s.file("young_file", young_file,
         "CSV of Young's modulus along the track with columns x_m, young_Pa, linear between rows "
         "and constant beyond; the file overrides `young`; empty: none.");
  strength.declare(s);
}

void Block::declare(Section& s) {
  s.text("name", name, "Name of the block in messages and overrides.");
  s.choice("role", role, {"auto", "structure", "measure"},
           "What the block is in comparisons of transitions; auto: a structure if it is stiff and "
           "deep (docs/postproc.md), a measure otherwise. The run does not depend on it.");
  auto fixed = s.fixed_by(input::state::moved_ground);
  s.flag("present", present,
         "Whether the block exists; false: the block is ignored, and the layers keep their "
         "material there.");
  s.numbers("outline", outline, {.unit = "m"},
            "Corners of the block as x, z, x, z ... with z = 0 on the top face and z < 0 below.");
  s.rule("outline", outline.size() % 2 == 0 && outline.size() >= 2 * fewest_corners,
         "must list x and z of at least 3 corners");
  s.rule("outline", !crosses_itself(outline),
         "crosses itself; list the corners in order around the outline");
  s.numbers("y", y, {.unit = "m"},
            "Ends of the block across the track (space); none: the whole width of the ground.");
  s.rule("y", y.empty() || (y.size() == 2 && y[0] < y[1]), "must be two increasing numbers");
  fixed.end();
  solid.declare(s);
  strength.declare(s);
}

double Block::height() const {
  double low = 0, high = 0;
  for (std::size_t k = 1; k < outline.size(); k += 2) {
    low = k == 1 ? outline[k] : std::min(low, outline[k]);
    high = k == 1 ? outline[k] : std::max(high, outline[k]);
  }
  return high - low;
}

std::vector<double> Block::sides_across(int axis) const {
  std::vector<double> sides;
  const std::size_t numbers = outline.size();
  for (std::size_t k = axis == 0 ? 0 : 1; k < numbers; k += 2)
    if (outline[k] == outline[(k + 2) % numbers]) sides.push_back(outline[k]);
  return sides;
}

bool GroundParameters::yields() const {
  const auto may_yield = [](const auto& of) { return of.strength.yield != Yield::none; };
  return present && (std::any_of(layers.begin(), layers.end(), may_yield) ||
                     std::any_of(solids.begin(), solids.end(), may_yield) ||
                     std::any_of(blocks.begin(), blocks.end(), [&](const Block& block) {
                       return block.present && may_yield(block);
                     }));
}

// Small elements below the track, large ones far from it.
void GroundParameters::declare_grading(Section& s) {
  const input::Limits ratio{.at_least = 1, .at_most = 2};
  s.number("ratio_x", ratio_x, ratio,
           "Length of each element divided by that of its neighbour on the side of fine_x; 1: "
           "equal lengths. Unequal lengths along the track make explicit steps several times more "
           "expensive.");
  s.number("fine_x", fine_x, {.unit = "m"},
           "Position of the shortest elements along the track (ratio_x).");
  s.number("ratio_y", ratio_y, ratio,
           "Width of each element divided by that of its neighbour on the side of fine_y; 1: equal "
           "widths.");
  s.number("fine_y", fine_y, {.unit = "m"},
           "Position of the narrowest elements across the track (ratio_y).");
  const auto inside = [&](const char* name, double ratio_of, double fine,
                          const std::vector<double>& range, const About& about) {
    const std::string place = range.size() != 2 ? ""
                                                : fmt::format(" (ground.{}: {:g} to {:g} m)",
                                                              name + 5, range[0], range[1]);
    s.rule(name, ratio_of == 1 || range.size() != 2 || (fine >= range[0] && fine <= range[1]),
           "must be within the ground" + place, about);
    s.rule(name, ratio_of != 1 || fine == 0, "has no effect: all elements are equal (ratio 1)",
           {.severity = input::Severity::warning, .reads = about.reads});
  };
  inside("fine_x", ratio_x, fine_x, x, {.reads = {"x", "ratio_x", "fine_x"}});
  inside("fine_y", ratio_y, fine_y, y, {.reads = {"y", "ratio_y", "fine_y"}});
}

void GroundParameters::declare_shape(Section& s) {
  auto fixed = s.fixed_by(input::state::any);  // the load of the bed is stored by node of the top
  s.numbers("x", x, {.unit = "m"}, "Ends of the ground along the track.", 2);
  s.rule("x", rises(x), "must be two increasing numbers");
  s.numbers("y", y, {.unit = "m"},
            "Ends of the ground across the track; a plane model uses its thickness instead.", 2);
  s.rule("y", rises(y), "must be two increasing numbers");
  s.integer("elements_x", elements_x, {.at_least = 1, .at_most = 1e5},
            "Number of elements along the track.");
  s.integer("elements_y", elements_y, {.at_least = 1, .at_most = 1e5},
            "Number of elements across the track; a plane model has one.");
  s.integer("elements_z", elements_z, {.at_least = 1, .at_most = 1e5},
            "Number of elements over the depth, unless layers have their own.");
  declare_grading(s);
  fixed.end();
  s.tables("layer", layers,
           "Horizontal layers from the top down; the sum of their thicknesses is the depth.");
  declare_elements(*this, s);
  s.tables("block", blocks,
           "Blocks that replace parts of the layers; later blocks override earlier ones.");
  const auto fixed_sections = s.fixed_by(input::state::any);
  s.tables("section", sections,
           "Cross-sections of an embankment at positions along the track, linear between them and "
           "constant beyond; without sections all layers span the width ground.y.");
  s.integer("embankment_layers", embankment_layers, {.at_least = 0, .at_most = 1000},
            "Number of layers, from the top down, that form the embankment (section); the layers "
            "below them are the natural ground, which also extends beside the embankment.");
  for (std::size_t l = 0; l < layers.size(); ++l) declare_height(*this, l, s);
  for (std::size_t b = 0; b < blocks.size(); ++b) declare_place(*this, b, s);
  for (std::size_t b = 0; b < blocks.size(); ++b) declare_width(*this, b, s);
}

void GroundParameters::declare_steps(Section& s) {
  s.number("rayleigh_mass", rayleigh_mass, {.unit = "1/s", .at_least = 0, .usually_to = 100},
           "Coefficient of mass-proportional Rayleigh damping.");
  declare_small_damping(rayleigh_mass, s);
  s.number("rayleigh_stiffness", rayleigh_stiffness,
           {.unit = "s", .at_least = 0, .at_most = 1e3, .usually_to = longest_usual},
           "Coefficient of stiffness-proportional Rayleigh damping; it lowers the stable explicit "
           "step.");
  auto fixed = s.fixed_by(input::state::moved_implicitly);
  s.choice("integrator", integrator, {"explicit", "newmark", "hht", "bossak", "generalized_alpha"},
           "Time integrator; explicit: central differences, with as many steps in a window as "
           "stability requires; the others take one implicit step per window.");
  fixed.end();
  s.number("safety", safety, {.above = 0, .at_most = 1},
           "Safety factor on the critical step (explicit).");
  s.number("newmark_beta", newmark_beta, {.above = 0, .at_most = 1},
           "Newmark's beta (newmark), at least newmark_gamma / 2.");
  s.number("newmark_gamma", newmark_gamma, {.at_least = 0.5, .at_most = 1},
           "Newmark's gamma (newmark); values above 0.5 give numerical damping.");
  s.rule(
      "newmark_beta", 2 * newmark_beta >= newmark_gamma,
      fmt::format("must be at least {:g}, half of newmark_gamma: otherwise the integrator is not "
                  "unconditionally stable",
                  newmark_gamma / 2));
  declare_alphas(*this, s);
  declare_idle_numbers(*this, s);
  s.number("tolerance", tolerance, {.at_least = 1e-14, .at_most = 1e-2},
           "Relative residual at which linear solves stop (implicit steps, static equilibrium); "
           "Newton iterations of yielding layers stop at 100 times this value.");
  s.integer("static_iterations", static_iterations, {.at_least = 1},
            "Number of iterations within which the out-of-balance force of the static solve must "
            "halve (yielding layers); otherwise the solve is abandoned as not converging. Near "
            "collapse the force decreases slowly (1000 iterations or more in all); increase this "
            "value if such a solve is abandoned.");
}

void GroundParameters::declare_base(Section& s) {
  auto fixed = s.fixed_by(input::state::moved_ground);
  s.choice("base", base, {"fixed", "viscous"},
           "Boundary condition of the base; fixed: held; viscous: Lysmer-Kuhlemeyer dashpots that "
           "absorb waves.");
  fixed.end();
  const auto fixed_springs = s.fixed_by(input::state::moved_viscous_base);
  s.number(
      "base_stiffness", base_stiffness, {.unit = "Pa/m", .at_least = -1},
      "Stiffness of springs in parallel with the dashpots of a viscous base, representing the "
      "ground below; below 0: shear modulus at the base divided by the depth of the ground; "
      "0: no springs, so that the ground sinks as long as it is loaded. With base_motion there "
      "are no springs.");
  s.rule("base_stiffness", base_stiffness <= 0 || base_stiffness >= 1e4,
         "is very soft for the ground below a track (below 1e4 Pa/m); is it in Pa/m?",
         {.severity = input::Severity::warning, .reads = {"base_stiffness"}});
}

// Incompatibilities with a mesh file or sections are checked last.
void GroundParameters::declare(Section& s) {
  {
    const auto fixed = s.fixed_by(input::state::any);
    s.flag("present", present,
           "Whether there is a ground; otherwise the stones are on a rigid floor at z = 0.");
  }
  declare_shape(s);
  {
    const auto fixed = s.fixed_by(input::state::moved_plane_ground);
    s.choice("plane", plane, {"stress", "strain"},
             "Plane stress or plane strain in a plane model.");
  }
  declare_base(s);
  declare_sides(s);
  declare_steps(s);
  declare_mesh(s);
  check_embankment(s);
  s.rule("layer", !present || !layers.empty() || !mesh.empty(),
         "must be given at least once: the ground is empty");
}

}  // namespace trackbed::fem
