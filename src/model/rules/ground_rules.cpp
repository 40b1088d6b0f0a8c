// Rules between the ground and the rest of the deck, and checks of its files.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "model/rules/ground_alone.hpp"
#include "model/rules/limits.hpp"
#include "model/rules/rules.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/fem/wave_report.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::model {

namespace {

// Warns of moduli in another unit and of rows outside of the ground, which have no effect.
std::vector<std::string> warnings_of_young(const Model& model, const input::Deck& deck) {
  constexpr double softest = 5e5, stiffest = 3e11;  // Pa, as usual for ground.layer[].young
  std::vector<std::string> warnings;
  for (std::size_t l = 0; l < model.ground.layers.size(); ++l) {
    const std::string& path = model.ground.layers[l].young_file;
    if (path.empty()) continue;
    const auto columns = input::read_table(path, {"x_m", "young_Pa"}, "x_m");
    const std::vector<double>&x = columns[0], &young = columns[1];
    const auto warning = [&](const std::string& what) {
      warnings.push_back(fmt::format(
          "{}: {}: {}", deck.where(fmt::format("ground.layer[{}].young_file", l)), path, what));
    };
    const auto odd = std::find_if(young.begin(), young.end(),
                                  [](double e) { return e < softest || e > stiffest; });
    if (odd != young.end())
      warning(fmt::format("{:g} Pa is outside the usual values ({:g} to {:g} Pa)", *odd, softest,
                          stiffest));
    if (!x.empty() && (x.back() <= model.ground.x[0] || x.front() >= model.ground.x[1]))
      warning(
          fmt::format("its rows, x = {:g} to {:g} m, are outside of the ground ({:g} to {:g} m), "
                      "which has the value of the nearest row throughout",
                      x.front(), x.back(), model.ground.x[0], model.ground.x[1]));
  }
  return warnings;
}

// Stones must be on the crest, not on the slopes.
void declare_crest(const Model& model, input::Section& s) {
  constexpr double rounding = 1e-9;  // m
  const std::vector<double>&x = model.bed.x, &y = model.bed.y;
  if (!model.has_stones() || x.size() != 2 || y.size() != 2) return;
  const double half = model.ground.narrowest_crest(x[0], x[1]);
  s.rule("bed.y", std::max(-y[0], y[1]) <= half + rounding,
         fmt::format("reaches beyond the crest of ground.section ({:g} m on either side): stones "
                     "would fall beside the ground",
                     half),
         {.reads = {"bed", "ground"}});
}

// Checks the sides against the incoming wave, whose table is read.
std::vector<std::string> warnings_of_wave(const Model& model, const input::Deck& deck) {
  std::vector<std::string> problems, warnings;
  for (const fem::WaveAtSide& side : fem::look_at_wave(model.ground, model.dimension))
    (side.refused ? problems : warnings)
        .push_back(fmt::format("{} = \"{}\": {}", deck.where("ground." + side.key), side.kind,
                               side.words));
  if (!problems.empty()) throw InputError(problems);
  return warnings;
}

// m^2, area of a triangle within a rectangle in plan view: it is clipped at each side in turn
// (Sutherland, Hodgman 1974, doi:10.1145/360767.360802).
double area_above(const std::array<Vec3, 3>& triangle, const std::array<double, 2>& low,
                  const std::array<double, 2>& high) {
  std::vector<Vec3> left(triangle.begin(), triangle.end());
  for (int side = 0; side < 4 && !left.empty(); ++side) {
    const int axis = side / 2;
    const auto a = static_cast<std::size_t>(axis);
    const auto within = [&](const Vec3& at) {  // m, beyond the side
      return side % 2 == 0 ? at[axis] - low[a] : high[a] - at[axis];
    };
    std::vector<Vec3> whole;
    whole.swap(left);
    for (std::size_t k = 0; k < whole.size(); ++k) {
      const Vec3 &from = whole[k], &to = whole[(k + 1) % whole.size()];
      const double begin = within(from), end = within(to);
      if (begin >= 0) left.push_back(from);
      if ((begin >= 0) != (end >= 0)) left.push_back(from + begin / (begin - end) * (to - from));
    }
  }
  double twice = 0;
  for (std::size_t k = 0; k < left.size(); ++k) {
    const Vec3 &a = left[k], &b = left[(k + 1) % left.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

// Refuses a top with a hole below the bed, or one that is narrower than its bounding box.
void require_closed(const Model& model, const std::vector<std::array<Vec3, 3>>& faces,
                    std::vector<std::string>& problems) {
  constexpr double rounding = 1e-6;  // of the bed
  const std::vector<double>&x = model.bed.x, &y = model.bed.y;
  if (x.size() != 2 || y.size() != 2 || model.bed.container != bed::ContainerKind::box) return;
  const double bed = (x[1] - x[0]) * (y[1] - y[0]);
  double below = 0;
  for (const auto& face : faces) below += area_above(face, {x[0], y[0]}, {x[1], y[1]});
  if (below < (1 - rounding) * bed)
    problems.push_back(
        fmt::format("the top of the ground covers only {:.4g} of the {:.4g} m^2 of the bed: stones "
                    "would fall through (bed.x, bed.y, ground.mesh_top)",
                    below, bed));
}

// s, longest time for which the ground moves; infinity if it does not follow from the deck.
double moving_time(const Model& model) {
  constexpr double unknown = std::numeric_limits<double>::infinity();
  const auto given = [](double duration) { return duration > 0 ? duration : unknown; };
  if (!model.start.empty()) return unknown;  // it may have moved before
  if (!model.has_stages()) return given(model.track.passage.duration);
  double time = 0;
  for (const Stage& stage : model.stages)
    if (stage.ground_moves) time += given(stage.duration);
  return time;
}

// Checks whether the wave arrives while the ground moves.
std::vector<std::string> warnings_of_times(const Model& model, const input::Deck& deck) {
  std::vector<std::string> warnings =
      fem::look_at_times(model.ground, model.dimension, moving_time(model));
  for (std::string& warning : warnings)
    warning = fmt::format("{}: {}: {}", deck.where("ground.base_motion"), model.ground.base_motion,
                          warning);
  return warnings;
}

// Checks whether elements resolve the wave.
std::vector<std::string> warnings_of_elements(const Model& model, const input::Deck& deck) {
  std::vector<std::string> warnings;
  for (const fem::UnresolvedLayer& one : fem::look_at_elements(model.ground, model.dimension)) {
    const std::string key = model.ground.layers_have_elements()
                                ? fmt::format("ground.layer[{}].elements", one.layer)
                                : "ground.elements_z";
    warnings.push_back(fmt::format("{}: {}", deck.where(key), one.words));
  }
  return warnings;
}

// Warns of flat hexahedra, with the same limit as for tetrahedra.
std::vector<std::string> warnings_of_shapes(const Model& model, const input::Deck& deck) {
  constexpr double flat = 60;  // times as long as high, or the other way round
  const fem::GroundParameters& ground = model.ground;
  if (ground.of_tetrahedra() || ground.layers.empty()) return {};  // none below a track alone
  const bool space = model.dimension == Dimension::space;
  double shortest = 0, longest = 0;  // m
  std::string of_shortest, of_longest;
  for (const auto& [axis, key] : {std::pair{0, "x"}, {1, "y"}, {2, "z"}}) {
    if (axis == 1 && !space) continue;
    const std::vector<double> edges = ground.edges(axis);
    for (std::size_t i = 1; i < edges.size(); ++i) {
      const double size = edges[i] - edges[i - 1];
      if (of_shortest.empty() || size < shortest) shortest = size, of_shortest = key;
      if (size > longest) longest = size, of_longest = key;
    }
  }
  if (longest <= flat * shortest || of_shortest == of_longest) return {};
  return {fmt::format(
      "{}: elements are up to {:.3g} m long along {}, but only {:.3g} m along {}: such "
      "flat elements (ratio above {:g}) have inaccurate stresses and need short explicit "
      "steps; "
      "use more elements along {} or fewer along {}",
      deck.where("ground.elements_" + of_longest), longest, of_longest, shortest, of_shortest, flat,
      of_longest, of_shortest)};
}

// Warns of sides of blocks inside elements, each of which has the material at its centre: the side
// is then up to half an element from where the deck has it. Only along one axis.
void warn_of_block_sides(const fem::GroundParameters& ground, int axis, const std::string& where,
                         std::vector<std::string>& warnings) {
  constexpr double close = 0.02;  // of an element's length
  constexpr double flat = 0.05;   // of the height of a block, which rows of elements seldom fit
  const std::vector<double> edges = ground.edges(axis);
  const char* name = axis == 0 ? "x" : "z";
  std::vector<double> named;  // neighbours share sides
  for (const fem::Block& block : ground.blocks) {
    if (!block.present) continue;
    const double height = axis == 2 ? block.height() : 0;
    for (const double side : block.sides_across(axis)) {
      if (std::find(named.begin(), named.end(), side) != named.end()) continue;
      named.push_back(side);
      const auto after = std::lower_bound(edges.begin(), edges.end(), side);
      if (after == edges.begin() || after == edges.end()) continue;
      const double low = *(after - 1), high = *after;
      const double error = std::min(side - low, high - side);
      if (error <= close * (high - low) || error <= flat * height) continue;
      warnings.push_back(fmt::format(
          "{}: block \"{}\" has a side at {} = {:g} m, inside an element ({:.6g} to {:.6g} m), "
          "which has the material at its centre; the side is computed at {:.6g} m. Choose the "
          "number of elements so that one begins there",
          where, block.name, name, side, low, high, 2 * side < low + high ? low : high));
    }
  }
}

std::vector<std::string> warnings_of_block_sides(const Model& model, const input::Deck& deck) {
  const fem::GroundParameters& ground = model.ground;
  std::vector<std::string> warnings;
  if (ground.of_tetrahedra() || ground.layers.empty()) return warnings;
  warn_of_block_sides(ground, 0, deck.where("ground.elements_x"), warnings);
  warn_of_block_sides(
      ground, 2, deck.where(ground.layers_have_elements() ? "ground.layer" : "ground.elements_z"),
      warnings);
  return warnings;
}

// Blocks whose elements all belong to later ones. Their outlines alone do not show it.
std::vector<std::string> warnings_of_covered(const Model& model, const input::Deck& deck) {
  std::vector<std::string> warnings;
  if (model.ground.blocks.size() < 2 || model.ground.of_tetrahedra()) return warnings;
  for (const std::size_t b : fem::covered_blocks(model.ground, model.dimension))
    warnings.push_back(fmt::format(
        "{}: block \"{}\" has no element: later blocks of the deck contain all of its elements and "
        "overrule it; list it after them, or leave it out",
        deck.where(fmt::format("ground.block[{}].outline", b)), model.ground.blocks[b].name));
  return warnings;
}

// All warnings from elements and tables of a ground, also of an embankment or a mesh.
std::vector<std::string> look_at_tables(const Model& model, const input::Deck& deck) {
  std::vector<std::string> warnings;
  for (const PressureParameters& pressure : model.pressures) pressure.table();
  if (model.ground.mesh.empty()) warnings = warnings_of_wave(model, deck);
  for (const auto& more : {warnings_of_young(model, deck), warnings_of_times(model, deck),
                           warnings_of_elements(model, deck), warnings_of_shapes(model, deck),
                           warnings_of_block_sides(model, deck), warnings_of_covered(model, deck)})
    warnings.insert(warnings.end(), more.begin(), more.end());
  return warnings;
}

}  // namespace

void declare_idle_sides(const fem::GroundParameters& ground, Dimension dimension,
                        input::Section& s) {
  const auto across = [&](const char* key, fem::Sides side) {
    s.rule(key, dimension == Dimension::space || side == fem::Sides::as_sides,
           "has no effect in a plane model, which has no sides across the track",
           {.severity = input::Severity::warning, .reads = {"dimension", key}});
  };
  across("ground.side_y_low", ground.side_y_low);
  across("ground.side_y_high", ground.side_y_high);
  for (std::size_t b = 0; b < ground.blocks.size(); ++b) {
    const std::string key = fmt::format("ground.block[{}].y", b);
    s.rule(key, dimension == Dimension::space || ground.blocks[b].y.empty(),
           "must not be given in a plane model", {.reads = {"dimension", key}});
  }
  constexpr fem::Sides none = fem::Sides::as_sides;
  const bool taken =
      ground.side_x_low == none || ground.side_x_high == none ||
      (dimension == Dimension::space && (ground.side_y_low == none || ground.side_y_high == none));
  if (taken) fem::declare_common_side(ground, s);
  s.rule("ground.sides", taken || ground.sides == fem::GroundParameters().sides,
         "has no effect: the kind of each side is given separately",
         {.severity = input::Severity::warning, .reads = {"dimension", "ground"}});
}

namespace {

// Whether the integrator does not damp the shortest waves.
bool keeps_short_waves(const fem::GroundParameters& ground) {
  switch (ground.integrator) {
    case fem::Integrator::explicit_:
      return true;
    case fem::Integrator::newmark:
      return ground.newmark_gamma == 0.5;
    case fem::Integrator::hht:
    case fem::Integrator::bossak:
      return ground.alpha == 0;
    case fem::Integrator::generalized_alpha:
      return ground.rho_inf == 1;
  }
  return true;
}

}  // namespace

// A ground that is held after it moved keeps its deformation, and the load on it may change.
void declare_held_again(const Model& model, input::Section& s) {
  bool moved = false;
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const bool moves = model.stages[i].ground_moves;
    s.rule(fmt::format("stage[{}].ground_moves", i), moves || !moved,
           "holds the ground, which moves in a stage before: it keeps its deformation whatever its "
           "load",
           {.severity = input::Severity::warning, .reads = {"stage"}});
    moved = moved || moves;
  }
}

// The ground begins in equilibrium with an exponential mean of the load of the bed. After cycles
// the mean contains a part of the load that has just been removed: for (1 - cos(2 pi t/T))/2 until
// t = 0 and a time constant of tau, x^2/(1 + x^2)/2 of it, x = 2 pi tau/T. The ground then rises by
// it.
void declare_begin_of_motion(const Model& model, input::Section& s) {
  const auto& stages = model.stages;
  const auto first = std::find_if(stages.begin(), stages.end(),
                                  [](const Stage& stage) { return stage.ground_moves; });
  if (!model.ground.present || first == stages.begin() || first == stages.end()) return;
  const Stage& before = *std::prev(first);
  if (before.kind != StageKind::load) return;
  const double period =
      before.cycles > 0 ? before.duration / static_cast<double>(before.cycles) : 2 * before.ramp;
  const double x = 2 * std::numbers::pi * model.settle_average / std::max(period, 1e-9);
  const double remaining = before.load * x * x / (1 + x * x) / 2;  // N, on each sleeper
  constexpr double noticeable = 0.1, negligible = 0.01, constants = 5;
  s.rule(fmt::format("stage[{}].ground_moves", first - stages.begin()),
         remaining <= std::max(noticeable * before.seat_force, negligible * before.load),
         fmt::format("begins in equilibrium with a mean load of the bed that still contains {:.2g} "
                     "kN on each sleeper of stage \"{}\" (settle_average = {:g} s), and rises when "
                     "it is gone; put a stage of kind run with the same seat_force and at least "
                     "{:g} s between both",
                     remaining / 1e3, before.name, model.settle_average,
                     constants * model.settle_average),
         {.severity = input::Severity::warning, .reads = {"stage", "settle_average", "ground"}});
}

void declare_delay(const Model& model, input::Section& s) {
  const fem::GroundParameters& ground = model.ground;
  const auto moves = [](const Stage& stage) { return stage.ground_moves; };
  if (!keeps_short_waves(ground) || std::none_of(model.stages.begin(), model.stages.end(), moves))
    return;
  const auto require = [&](const std::string& of, double damping, double least) {
    const std::string key = of + ".rayleigh_stiffness";
    constexpr double rounding = 1e-9;
    s.rule(key, damping >= least * (1 - rounding),
           fmt::format("is below {:.1e} s (estimate): forces of the stones act on the ground one "
                       "time window late, which adds energy to its shortest waves; give at least "
                       "this damping",
                       least),
           {.severity = input::Severity::warning,
            .reads = {key, "time", "dem", "contact", "bed", "ground", "sleepers", "stage",
                      "material", "dimension", "thickness"}});
  };
  double of_ground = 0;  // required of all solids without a value of their own
  const auto look_at = [&](const std::string& of, const fem::Elastic& solid, Modulus modulus) {
    const double least = least_damping_of_ground(model, solid, modulus);
    if (solid.rayleigh_stiffness >= 0)
      require(of, solid.rayleigh_stiffness, least);
    else
      of_ground = std::max(of_ground, least);
  };
  if (!ground.layers.empty()) {
    const fem::Layer& top = ground.layers.front();
    look_at("ground.layer[0]", top.solid,
            top.young_file.empty() ? Modulus::known : Modulus::from_file);
  }
  for (std::size_t b = 0; b < ground.blocks.size(); ++b)
    if (ground.blocks[b].present)
      look_at(fmt::format("ground.block[{}]", b), ground.blocks[b].solid, Modulus::known);
  require("ground", ground.rayleigh_stiffness, of_ground);
}

// The periods of stones and ground must be equal. Walls of the bed at a periodic end of the ground
// are allowed: they represent a row of beds.
void declare_ground_sides(const Model& model, input::Section& s) {
  const fem::GroundParameters& ground = model.ground;
  if (!ground.present) return;
  declare_idle_sides(ground, model.dimension, s);
  const auto both = [&](const std::string& axis, int a, const auto& over, const auto& stones) {
    constexpr double rounding = 1e-9;
    if (!ground.periodic(a) || !model.periodic_in(axis) || over.size() != 2 || stones.size() != 2)
      return;
    const double length = over[1] - over[0], bed = stones[1] - stones[0];
    s.rule(
        "ground.side_" + axis + "_low", std::abs(length - bed) <= rounding * length,
        fmt::format("gives the ground a period of {:g} m, but that of the stones is {:g} m; make "
                    "ground.{} as long as bed.{}",
                    length, bed, axis, axis),
        {.reads = {"periodic", "ground", "bed." + axis}});
  };
  both("x", 0, ground.x, model.bed.x);
  if (model.dimension == Dimension::space) both("y", 1, ground.y, model.bed.y);
}

// For layers the mass of a node of the top, which limits the window, follows from the deck; for
// tetrahedra it does not. Declared after the time steps.
void declare_ground_mesh(const Model& model, input::Section& s) {
  const fem::GroundParameters& ground = model.ground;
  if (!ground.present || !ground.of_tetrahedra()) return;
  const std::string what = ground.mesh.empty() ? "ground.section" : "ground.mesh";
  s.rule(what, model.dimension == Dimension::space, "needs dimension = \"space\"",
         {.reads = {"dimension", what}});
  s.rule("time.window", model.time.window > 0,
         fmt::format("must be given with {}, since the masses of the nodes at its top, which limit "
                     "the window, do not follow from the deck; give an estimate, for example 1e-4 "
                     "s: if it is too long, the program refuses it and states the longest window",
                     what),
         {.reads = {"time.window", what}});
  if (ground.mesh.empty()) declare_crest(model, s);
}

namespace {

fem::MeshReport report_of(const Model& model, const input::Deck& deck) {
  try {
    return fem::look_at_mesh(model.ground);
  } catch (const InputError& error) {
    std::vector<std::string> problems;
    for (const std::string& problem : error.problems()) problems.push_back(deck.located(problem));
    throw InputError(problems);
  }
}

}  // namespace

GroundFile require_ground(const Model& model, const input::Deck& deck) {
  constexpr double rounding = 1e-9;  // m
  if (!model.ground.present) return {};
  if (!model.ground.of_tetrahedra()) return {"", look_at_tables(model, deck)};
  const fem::MeshReport mesh = report_of(model, deck);
  std::vector<std::string> problems;
  const auto below = [&](const char* axis, const std::vector<double>& bed, int a) {
    if (bed.size() == 2 &&
        (bed[0] < mesh.top_low[a] - rounding || bed[1] > mesh.top_high[a] + rounding))
      problems.push_back(
          fmt::format("{} = [{:g}, {:g}] reaches beyond the top of the mesh ({:g} to {:g} m): "
                      "stones would fall beside the ground",
                      deck.where(std::string("bed.") + axis), bed[0], bed[1], mesh.top_low[a],
                      mesh.top_high[a]));
  };
  if (model.kind == ModelKind::ground)
    require_below(model, {mesh.top_low.x(), mesh.top_high.x()},
                  {mesh.top_low.y(), mesh.top_high.y()}, deck, problems);
  if (model.has_stones()) {
    below("x", model.bed.x, 0), below("y", model.bed.y, 1);
    if (problems.empty()) require_closed(model, mesh.top_faces, problems);
  }
  if (!problems.empty()) throw InputError(problems);
  const auto from_to = [&](int a) {
    return fmt::format("{:g} to {:g}", mesh.low[a], mesh.high[a]);
  };
  std::vector<std::string> warnings = look_at_tables(model, deck);
  warnings.insert(warnings.end(), mesh.warnings.begin(), mesh.warnings.end());
  return {fmt::format("  mesh: x = {}, y = {}, z = {} m, {:.6g} m^3", from_to(0), from_to(1),
                      from_to(2), mesh.volume),
          warnings};
}

}  // namespace trackbed::model
