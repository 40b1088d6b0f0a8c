// Sleepers are boxes, and rails are boxes with the area and second moment of the rail section, as
// for a beam.
#include "trackbed/model/solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trackbed/input/deck.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

namespace {

// Every rank assembles and solves all of them.
constexpr double most_unknowns = 300e3;

std::int64_t parts(double extent, double element) {
  return std::max<std::int64_t>(1, std::llround(extent / element));
}

fem::Body sleeper_of(const Model& model, std::size_t i) {
  const track::SleeperParameters& s = model.sleepers;
  const SolidParameters& solid = model.solid;
  const double x = s.first + static_cast<double>(i) * s.spacing;
  return {.name = fmt::format("sleeper.{}", i),
          .low = {x - s.width / 2, s.y - s.length / 2, 0},
          .high = {x + s.width / 2, s.y + s.length / 2, s.height},
          .elements = {parts(s.width, solid.element), parts(s.length, solid.element),
                       parts(s.height, solid.element)},
          .solid = {.young = solid.young,
                    .poisson = solid.poisson,
                    .density = s.density,
                    .rayleigh_stiffness = solid.rayleigh_stiffness},
          .touched = true};
}

// Whole elements in a spacing; if their number is even, there is a node above each sleeper.
fem::Body rail_of(const Model& model, std::size_t r) {
  const track::SleeperParameters& s = model.sleepers;
  const track::RailParameters& rail = model.track.line.rail;
  const RailBlock block = rail_block(model);
  const double y = s.y + model.solid.seats[r];
  const double mass = track::beam_of(rail).mass;
  return {.name = fmt::format("rail.{}", r),
          .low = {s.first - s.spacing / 2, y - block.width / 2, s.height},
          .high = {s.last() + s.spacing / 2, y + block.width / 2, s.height + block.height},
          .elements = {s.count * parts(s.spacing, model.solid.element), 1,
                       parts(block.height, model.solid.element)},
          .solid = {.young = rail.young,
                    .poisson = rail.poisson,
                    .density = mass / (block.width * block.height),
                    .rayleigh_stiffness = model.solid.rayleigh_stiffness}};
}

// Rail ends have the boundary condition of symmetry: the track continues as its mirror image.
void add_rails(const Model& model, fem::BodiesParameters& to) {
  const auto sleepers = static_cast<std::size_t>(model.sleepers.count);
  const std::size_t seats = model.solid.seats.size();
  const track::PadParameters& pad = model.track.line.pad;
  const Vec3 directions(model.solid.pad_shear, model.solid.pad_shear, 1);
  for (std::size_t r = 0; r < seats; ++r) {
    to.bodies.push_back(rail_of(model, r));
    for (const bool low : {true, false})
      to.held.push_back(
          {.body = sleepers + r, .axis = 0, .low = low, .components = {true, true, false}});
  }
  for (std::size_t i = 0; i < sleepers; ++i)
    for (std::size_t r = 0; r < seats; ++r)
      to.pads.push_back({.below = i,
                         .above = sleepers + r,
                         .patch = seat_patch(model, i, r),
                         .stiffness = pad.stiffness * directions,
                         .damping = pad.damping * directions});
}

double unknowns_of(const fem::BodiesParameters& bodies) {
  double sum = 0;
  for (const fem::Body& body : bodies.bodies)
    sum += 3.0 * static_cast<double>(body.elements[0] + 1) *
           static_cast<double>(body.elements[1] + 1) * static_cast<double>(body.elements[2] + 1);
  return sum;
}

void declare_kinds(const Model& model, input::Section& s) {
  const input::About about{.reads = {"sleepers", "dimension", "stage"}};
  s.rule("sleepers.model", model.dimension == Dimension::space, "solid needs dimension = \"space\"",
         about);
  s.rule("sleepers.model", !model.has_stage(StageKind::tamp),
         "must be \"rigid\" for stages of kind tamp, which lift the sleepers", about);
  s.rule("sleepers.bevel", model.sleepers.bevel == 0, "must be 0 for solid sleepers",
         {.reads = {"sleepers"}});
  const track::SleeperParameters none;
  s.rule("sleepers.free", model.sleepers.free == none.free,
         "has no effect on solid sleepers, which move freely; only rails and solid.half restrain "
         "them",
         {.severity = input::Severity::warning, .reads = {"sleepers"}});
}

void declare_seats(const Model& model, input::Section& s) {
  const track::SleeperParameters& sleeper = model.sleepers;
  const input::About about{.reads = {"sleepers", "solid"}};
  const std::vector<double>& size = model.solid.seat_size;
  const bool pair = size.size() == 2 && size[0] > 0 && size[1] > 0;
  s.rule("solid.seat_size", pair, "must be two lengths above 0, along x and y", about);
  s.rule("solid.seats", !model.solid.seats.empty(), "must contain at least one seat", about);
  if (!pair) return;
  s.rule("solid.seat_size", size[0] <= sleeper.width,
         fmt::format("is wider along x than the sleeper ({:g} m)", sleeper.width), about);
  for (const double y : model.solid.seats)
    s.rule(
        "solid.seats", std::abs(y) + size[1] / 2 <= sleeper.length / 2,
        fmt::format(
            "puts a seat at y = {:g} m, which reaches beyond the end of the sleeper ({:g} m long)",
            y, sleeper.length),
        about);
  std::vector<double> seats = model.solid.seats;
  std::sort(seats.begin(), seats.end());
  for (std::size_t r = 1; r < seats.size(); ++r)
    s.rule("solid.seats", seats[r] - seats[r - 1] >= size[1],
           fmt::format("puts seats of {:g} m width at y = {:g} and {:g} m: the seats overlap",
                       size[1], seats[r - 1], seats[r]),
           about);
}

// The pads of a train are part of the common step of rail and solids, which is linear.
void declare_rails(const Model& model, input::Section& s) {
  s.rule("pad.bilinear_at",
         model.solid.rails || !model.has_train() || model.track.line.pad.bilinear_at == 0,
         "must be 0 on solid sleepers, whose pads are linear",
         {.reads = {"pad", "sleepers.model", "stage"}});
  if (!model.solid.rails) return;
  s.rule("solid.rails", !model.has_train(),
         "must be false below a train (train = true), whose rail is a beam; solid rails carry the "
         "axles of [load]",
         {.reads = {"solid.rails", "stage"}});
  s.rule(
      "load.kind",
      !model.has_stage(StageKind::passage) || model.load.kind == track::SeatLoadKind::winkler,
      "must be \"winkler\" with solid rails: only with this kind do wheels run on the rails; the "
      "other kinds load the seats",
      {.reads = {"load.kind", "solid.rails", "stage"}});
  s.rule("pad.bilinear_at", model.track.line.pad.bilinear_at == 0,
         "must be 0 with solid.rails = true: pads of solid rails are linear",
         {.reads = {"pad", "solid.rails"}});
}

}  // namespace

void SolidParameters::declare(input::Section& s) {
  // Strains depend on the stiffness. Damping and the constant of the scheme may change.
  auto fixed = s.fixed_by(input::state::solid_sleepers);
  s.number("young", young, {.unit = "Pa", .above = 0, .usually_from = 1e9, .usually_to = 1e12},
           "Young's modulus of the sleepers.");
  s.number("poisson", poisson, {.at_least = 0, .at_most = 0.49},
           "Poisson's ratio of the sleepers.");
  s.number("element", element, {.unit = "m", .at_least = 0.01, .usually_to = 0.3},
           "Approximate edge length of the elements of sleepers and rails.");
  fixed.end();
  s.number("rayleigh_stiffness", rayleigh_stiffness,
           {.unit = "s", .at_least = 0, .usually_to = 1e-3},
           "Coefficient of stiffness-proportional Rayleigh damping of sleepers and rails.");
  s.number("alpha", alpha, {.at_least = -1.0 / 3, .at_most = 0},
           "Parameter of Bossak's scheme; values below 0 damp frequencies that a window does not "
           "resolve.");
  const auto fixed_shape = s.fixed_by(input::state::solid_sleepers);
  s.flag(
      "half", half,
      "Whether only half of each sleeper is modelled: its face at the smallest y is the plane of "
      "symmetry in the track centre and is held along y.");
  s.numbers("seats", seats, {.unit = "m"},
            "y of the rail seats relative to the centre of a sleeper; two rails need seats at half "
            "of track.gauge to either side.");
  s.numbers("seat_size", seat_size, {.unit = "m"}, "Size of a rail seat along x and y.");
  s.flag("rails", rails,
         "Whether rails are solids ([rail]) on pads ([pad]). The axles of [load] (kind winkler) "
         "then run on these rails, each with the load 2 peak / (decay spacing); otherwise loads "
         "act on the seats.");
  s.number("pad_shear", pad_shear, {.above = 0, .at_most = 1},
           "Stiffness and damping of a pad along x and y, as a fraction of those along z.");
}

// b h = A, b h^3/12 = I.
RailBlock rail_block(const Model& model) {
  const track::RailParameters& rail = model.track.line.rail;
  const track::RailSection& section = track::rail_section(rail.section);
  const double area = rail.area > 0 ? rail.area : section.area;
  const double inertia = rail.inertia > 0 ? rail.inertia : section.inertia;
  const double height = std::sqrt(12 * inertia / area);
  return {.width = area / height, .height = height};
}

fem::Patch seat_patch(const Model& model, std::size_t i, std::size_t s) {
  const track::SleeperParameters& sleeper = model.sleepers;
  const double x = sleeper.first + static_cast<double>(i) * sleeper.spacing;
  const double y = sleeper.y + model.solid.seats[s];
  const double across = model.solid.rails ? rail_block(model).width : model.solid.seat_size[1];
  const double along = model.solid.seat_size[0];
  return {.x = {x - along / 2, x + along / 2}, .y = {y - across / 2, y + across / 2}};
}

fem::BodiesParameters solid_bodies(const Model& model) {
  fem::BodiesParameters all;
  all.alpha = model.solid.alpha;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model.sleepers.count); ++i) {
    all.bodies.push_back(sleeper_of(model, i));
    if (model.solid.half)
      all.held.push_back({.body = i, .axis = 1, .low = true, .components = {false, true, false}});
  }
  if (model.solid.rails) add_rails(model, all);
  return all;
}

// Effective mass of an inner node of the face of a half-space of elements with consistent mass: the
// diagonal of the inverse of a chain of (h/6)[1 4 1] is sqrt(3)/h in the interior and 2 sqrt(3)/h
// at the end.
double solid_node_mass(const Model& model) {
  const fem::Body body = sleeper_of(model, 0);
  double mass = model.sleepers.density;
  for (int a = 0; a < 3; ++a)
    mass *= (body.high[a] - body.low[a]) /
            static_cast<double>(body.elements[static_cast<std::size_t>(a)]) / std::sqrt(3.0);
  return mass / 2;
}

void declare_solids(const Model& model, input::Section& s) {
  if (model.sleepers.model == track::SleeperBody::rigid)
    return s.rule("solid", !input::differs_from_default(model.solid),
                  "has no effect: sleepers.model is rigid",
                  {.severity = input::Severity::warning, .reads = {"solid", "sleepers.model"}});
  declare_kinds(model, s), declare_seats(model, s), declare_rails(model, s);
  if (model.sleepers.count < 1 || model.solid.seats.empty() || model.solid.seat_size.size() != 2)
    return;
  const double unknowns = unknowns_of(solid_bodies(model));
  s.rule("solid.element", unknowns <= most_unknowns,
         fmt::format("gives {:.3g} unknowns, which every rank solves; at most {:g} are possible: "
                     "give larger elements",
                     unknowns, most_unknowns),
         {.reads = {"solid", "sleepers", "rail"}});
}

}  // namespace trackbed::model
