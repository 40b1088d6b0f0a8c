// Parameters of the bed and of the platen, each declared once.
//
// Bounds follow from the geometry; rules define valid combinations.
#include <fmt/format.h>

#include <algorithm>

#include "trackbed/bed/bed.hpp"

namespace trackbed::bed {

namespace {

// mm: if the largest sieve is smaller, the sieves were probably given in m.
constexpr double smallest_ballast = 1;

bool increases(const std::vector<double>& values) {
  return std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) == values.end();
}

bool is_range(const std::vector<double>& values) {
  return values.size() == 2 && values[0] < values[1];
}

// The middle between the limits, with 0 on the finest sieve and 100 on the coarsest.
std::vector<double> middle_of(const GradingLimits& limits) {
  std::vector<double> passing;
  for (std::size_t k = 0; k < limits.sieve.size(); ++k)
    passing.push_back((limits.low[k] + limits.high[k]) / 2);
  passing.front() = 0, passing.back() = 100;
  return passing;
}

// A named grading sets what the deck does not set; sieves of other sizes have no limits.
void declare_standard(LayerParameters& bed, input::Section& s) {
  s.choice("grading", bed.grading,
           {"custom", "en13450_a", "china_special", "china_first", "as2758_60"},
           "Standard grading; it defines `sieve`, and also `passing` (the middle of its limits) "
           "unless the deck gives `passing`; custom: `sieve` and `passing` of the deck.");
  const GradingLimits& limits = limits_of(bed.grading);
  if (limits.sieve.empty()) return;
  bed.sieve = limits.sieve, bed.passing = middle_of(limits);
}

void declare_limits(const LayerParameters& bed, input::Section& s) {
  const GradingLimits& limits = limits_of(bed.grading);
  if (limits.sieve.empty()) return;
  s.rule("sieve", bed.sieve == limits.sieve,
         "differs from the sieves of the grading; leave it out, or use grading = \"custom\"",
         {.reads = {"grading", "sieve"}});
  if (bed.sieve != limits.sieve || bed.passing.size() != limits.sieve.size()) return;
  for (std::size_t k = 0; k < limits.sieve.size(); ++k)
    s.rule("passing", limits.low[k] <= bed.passing[k] && bed.passing[k] <= limits.high[k],
           fmt::format("is {:g} % at {:g} mm, where the grading allows {:g} to {:g} %",
                       bed.passing[k], limits.sieve[k], limits.low[k], limits.high[k]),
           {.severity = input::Severity::warning, .reads = {"grading", "sieve", "passing"}});
}

// As on a sieve report: openings in mm, passing in per cent by mass.
void declare_grading(LayerParameters& bed, input::Section& s) {
  s.numbers("sieve", bed.sieve, {.unit = "mm", .above = 0, .usually_to = 300},
            "Sieve openings, increasing: square holes; in a plane model slots.");
  s.numbers("passing", bed.passing, {.unit = "%", .at_least = 0, .at_most = 100},
            "Percentage of the mass that passes each sieve, from 0 to 100.");
  s.rule("sieve", bed.sieve.size() >= 2 && increases(bed.sieve),
         "must be at least two openings, each above the previous one");
  s.rule("sieve", bed.sieve.empty() || bed.sieve.back() >= smallest_ballast,
         fmt::format("looks like metres; give the openings in mm: {:g}, not {:g}",
                     bed.sieve.empty() ? 0 : 1e3 * bed.sieve.back(),
                     bed.sieve.empty() ? 0 : bed.sieve.back()));
  s.rule("passing",
         bed.passing.size() == bed.sieve.size() && !bed.passing.empty() &&
             std::is_sorted(bed.passing.begin(), bed.passing.end()) && bed.passing.front() == 0 &&
             bed.passing.back() == 100,
         "must have one value for each sieve, never decrease, begin with 0 and end with 100");
}

// Parameters of all kinds of stones; each states in brackets which kind uses it.
void declare_shape(LayerParameters& bed, input::Section& s) {
  s.number("pebble_radius", bed.pebble_radius,
           {.unit = "m", .above = 0, .usually_from = 5e-4, .usually_to = 0.1},
           "Radius of the disks of a plane stone (pebbles).");
  s.number("pebble_spacing", bed.pebble_spacing, {.unit = "radii", .at_least = 0.05, .at_most = 3},
           "Largest distance between neighbouring disks along the border of a stone (pebbles).");
  s.integer("shapes", bed.shapes, {.at_least = 1, .at_most = 10000},
            "Number of different shapes. Pebbles: each shape has one size, and all represent equal "
            "fractions of the mass; three-dimensional stones: each shape occurs in all sizes.");
  s.number("elongation", bed.elongation, {.above = 0, .at_most = 1},
           "Elongation: smallest width divided by largest extent of an outline (pebbles).");
  s.number(
      "angularity", bed.angularity, {.at_least = 0, .at_most = 1},
      "Angularity (pebbles); 0: corners evenly on an ellipse; above 0: on a superellipse of the "
      "exponent 2 + 2 angularity, at angles and radii whose scatter is proportional to it.");
  s.numbers("clump", bed.clump, {.unit = "m"},
            "x, y, z, radius of each sphere of the stone (clump), at any scale, since the "
            "program scales the stone to the sieves; none: generated polyhedra are filled with "
            "spheres (space).");
  s.file("library", bed.library,
         "File of shapes made by `trackbed shapes ... --library FILE` (library). A resumed run "
         "needs this file as long as stones are still to be generated.");
  s.rule("library", bed.stone != StoneKind::library || !bed.library.empty(),
         "must name a library of shapes; `trackbed shapes scan.stl --library FILE` creates one",
         {.reads = {"stone", "library"}});
  const bool pebbles = bed.stone == StoneKind::pebbles;
  // Offset inwards by a radius on both sides, the smallest outline keeps a third of its width.
  s.rule("pebble_radius",
         !pebbles || bed.sieve.empty() || 3 * bed.pebble_radius <= 1e-3 * bed.sieve.front(),
         fmt::format("must be at most {:.4g} m (a third of the smallest sieve)",
                     bed.sieve.empty() ? 0 : 1e-3 * bed.sieve.front() / 3));
  s.rule("pebble_radius",
         !pebbles || bed.sieve.empty() || 1e4 * bed.pebble_radius >= 1e-3 * bed.sieve.back(),
         fmt::format("must be at least {:.4g} m (1e-4 of the largest sieve): smaller disks only "
                     "increase their number",
                     bed.sieve.empty() ? 0 : 1e-7 * bed.sieve.back()));
  bool radii = true;
  for (std::size_t k = 3; k < bed.clump.size(); k += 4) radii = radii && bed.clump[k] > 0;
  s.rule("clump", bed.clump.size() % 4 == 0, "must list x, y, z and radius of each sphere");
  s.rule("clump", radii, "contains a radius that is not above 0");
}

}  // namespace

void LayerParameters::declare(input::Section& s) {
  s.choice("stone", stone, {"disk", "pebbles", "clump", "polyhedra", "compound", "library"},
           "Kind of stone; disk: round; pebbles: a ring of disks along an irregular plane outline; "
           "clump: rigidly joined spheres; polyhedra: rounded irregular polyhedra (space); "
           "compound: such polyhedra cut into convex pieces (space); library: the shapes of a file "
           "with equal frequencies (space).");
  s.text("material", material, "Contact material of the stones.");
  s.number("height", height,
           {.unit = "m", .above = 0, .at_most = 1e3, .usually_from = 0.02, .usually_to = 5},
           "Required height after compaction; height and porosity determine the number of stones.");
  s.number("porosity", porosity, {.at_least = 0, .at_most = 0.95},
           "Expected porosity (volume fraction of voids) after compaction.");
  s.integer("seed", seed, {.at_least = 0},
            "Seed of the random numbers; another seed gives another bed of the same kind.");
  declare_standard(*this, s);
  declare_grading(*this, s);
  declare_limits(*this, s);
  declare_shape(*this, s);
  s.table("polyhedron", polyhedron,
          "Irregular three-dimensional stones: polyhedra, compound, clump.");
}

void NamedLayer::declare(input::Section& s) {
  s.text("name", name, "Name by which a stage of kind fill refers to the layer.", {}, true);
  LayerParameters::declare(s);
}

// Rules of the crest alone are here; where the slopes end depends on the height of a stage's
// profile.
void BedParameters::declare(input::Section& s) {
  auto fixed = s.fixed_by(input::state::any);
  s.numbers("x", x, {.unit = "m"}, "Ends of the bed along the track.", 2);
  s.numbers("y", y, {.unit = "m"}, "Sides of the bed (space).", 2);
  s.rule("x", is_range(x), "must be two increasing numbers");
  s.rule("y", is_range(y), "must be two increasing numbers");
  fixed.end();
  s.numbers("crest", crest, {.unit = "m"},
            "Ends of the crest across the track (space). A stage with a `profile` cuts the bed "
            "level within the crest and to `slope` outside it; no crest: level everywhere.");
  s.number("slope", slope, {.unit = "-", .above = 0, .usually_from = 1, .usually_to = 4},
           "Slope of the sides beyond the crest, horizontal to vertical; slopes steeper than 1:1 "
           "(below 1) are rarely stable.");
  s.rule("crest", crest.empty() || is_range(crest), "must be two increasing numbers",
         {.reads = {"crest"}});
  s.rule("crest", !is_range(crest) || !is_range(y) || (crest[0] >= y[0] && crest[1] <= y[1]),
         fmt::format("must be within the sides of the bed (y = {:g} to {:g} m)",
                     y.empty() ? 0 : y.front(), y.empty() ? 0 : y.back()),
         {.reads = {"crest", "y"}});
  s.file(
      "cell", cell,
      "Checkpoint of a cell, that is, of a bed that is periodic in x, at the end of a stage: a "
      "file stage_*.h5, or a result folder, whose latest checkpoint is then used. The stage fill "
      "places copies of the stones of the cell side by side along x instead of generating stones.",
      input::FileRole::origin);
  auto fixed_container = s.fixed_by(input::state::any);
  s.choice("container", container, {"box", "cylinder"},
           "Shape of the walls; box: flat, at sides that are not periodic; cylinder: upright, "
           "inscribed in x and y, of 64 facets (space).");
  s.number("split", split, {.unit = "m", .at_least = 0},
           "Height at which walls are divided into two halves, as of a shear box; 0: undivided.");
  s.number(
      "beside", beside, {.unit = "m", .at_least = 0, .usually_to = 5},
      "Width of floor around the walls, for stages that move or lift them; stones further out are "
      "removed.");
  fixed_container.end();
  LayerParameters::declare(s);
  s.tables("layer", layers,
           "Further layers, usually below the layer that [bed] itself describes (sub-ballast); a "
           "stage of kind fill pours the layer that it names.");
}

// Level between the ends of the crest.
double BedParameters::top_at(double y, double top) const {
  if (crest.empty()) return top;
  return top - std::max({0.0, crest[0] - y, y - crest[1]}) / slope;
}

BedParameters BedParameters::of_layer(const std::string& name) const {
  BedParameters bed = *this;
  for (const NamedLayer& layer : layers)
    if (layer.name == name) {
      static_cast<LayerParameters&>(bed) = layer;
      bed.section = "bed.layer." + name;
    }
  return bed;
}

// The domain of a bed in a cylinder or with floor around it is larger than the bed.
Container BedParameters::container_in(const dem::Domain& domain) const {
  Container c(domain);
  c.kind = container, c.split = split, c.beside = beside;
  c.low.x() = x[0], c.high.x() = x[1];
  if (domain.dimension == Dimension::space) c.low.y() = y[0], c.high.y() = y[1];
  return c;
}

std::vector<double> LayerParameters::grading_table() const {
  const GradingLimits& limits = limits_of(grading);
  std::vector<double> table;
  for (std::size_t k = 0; k < sieve.size(); ++k) {
    const bool custom = limits.sieve.empty();
    table.insert(table.end(), {1e-3 * sieve[k], passing[k], custom ? passing[k] : limits.low[k],
                               custom ? passing[k] : limits.high[k]});
  }
  return table;
}

void PlatenParameters::declare(input::Section& s) {
  s.number("pressure", pressure, {.unit = "Pa", .above = 0, .usually_from = 1e3, .usually_to = 1e7},
           "Target pressure of the platen.");
  s.number("speed", speed, {.unit = "m/s", .above = 0, .usually_to = 10},
           "Largest speed of the platen, with which it approaches the bed.");
  s.number("acceleration", acceleration, {.unit = "m/s^2", .above = 0},
           "Largest acceleration of the platen; braking is not limited.");
  s.number("average", average, {.unit = "s", .above = 0},
           "Time constant T of the averaged pressure, which decides when compaction ends. With "
           "vibration the servo controls this averaged pressure; without vibration it controls the "
           "pressure averaged over T/10.");
  s.number("tolerance", tolerance, {.above = 0, .at_most = 0.5},
           "Relative tolerance of the averaged pressure.");
  s.number("hold", hold, {.unit = "s", .above = 0},
           "Compaction ends when the averaged pressure has been within its tolerance for this "
           "time; if the pressure is too low for the same time, the gain of the servo is doubled.");
  s.number("vibration", vibration, {.unit = "m", .at_least = 0, .usually_to = 0.01},
           "Amplitude of a vertical sine superposed on the motion of the platen in compaction; 0: "
           "none. The servo controls the averaged pressure.");
  s.number("frequency", frequency, {.unit = "Hz", .above = 0, .usually_to = 200},
           "Frequency of the vibration of the platen.");
  s.rule("average", vibration == 0 || average * frequency >= 1,
         fmt::format("must be at least a period of the vibration ({:.3g} s)", 1 / frequency));
}

}  // namespace trackbed::bed
