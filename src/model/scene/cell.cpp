// The checkpoint of one deck as a periodic cell from which other beds are made. The boundary
// conditions of the stones must agree: dimension, sides, thickness, and a ground that has not
// moved. Bodies other than stones are not repeated; a checkpoint with a platen or sleepers is
// therefore refused, since the stones below them would rebound. Contact laws, loads and steps may
// differ, as for `start`.
//
// Materials and surfaces are matched by name. A floor and a ground that has not moved are the same
// plane, so that a cell made on a floor keeps its friction history on a ground.
#include "model/scene/cell.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "trackbed/core/error.hpp"
#include "trackbed/dem/stiffness.hpp"
#include "trackbed/dem/templates.hpp"
#include "trackbed/input/values.hpp"
#include "trackbed/io/checkpoint.hpp"

namespace trackbed::model {

namespace {

// Relative. Lengths in a deck have 16 digits: 10 cells of 1.2 m equal a bed of 12 m up to rounding.
constexpr double whole_cells = 1e-12;

// The file is opened again when the cells are laid: only its name is kept between check and fill.
// Collective.
io::File open_cell(const par::Comm& comm, const Model& model) {
  const std::string file = io::choose_checkpoint(comm, model.bed.cell, io::IfDamaged::refuse).file;
  return io::open_checkpoint(comm, file);
}

// The numbers of a list such as "[0.0, 6.0]", as written by `effective`.
std::vector<double> numbers_of(const input::Values& deck, const std::string& key) {
  std::vector<double> numbers;
  const auto found = deck.find(key);
  if (found == deck.end()) return numbers;
  const char* at = found->second.c_str() + 1;
  for (char* end = nullptr;; at = end + 1) {
    const double number = std::strtod(at, &end);
    if (end == at) return numbers;
    numbers.push_back(number);
    if (*end != ',') return numbers;
  }
}

bool periodic_in(const input::Values& deck, const std::string& axis) {
  const auto found = deck.find("periodic");
  return found != deck.end() && found->second.find('"' + axis + '"') != std::string::npos;
}

// Names of the cell's materials by number.
std::vector<std::string> materials_of(const input::Values& deck) {
  std::vector<std::string> names;
  for (;;) {
    const auto found = deck.find(fmt::format("material[{}].name", names.size()));
    if (found == deck.end()) return names;
    names.push_back(found->second.substr(1, found->second.size() - 2));  // without quotes
  }
}

// Position of the cell and the number of its copies; -1 in `materials`: not in this deck.
dem::Tiling tiling_of(const input::Values& cell, const Model& model) {
  const std::vector<double> x = numbers_of(cell, "bed.x");
  dem::Tiling tiling;
  tiling.begin = x.at(0), tiling.length = x.at(1) - x.at(0);
  const double length = model.bed.x[1] - model.bed.x[0];
  tiling.copies = std::max<std::int64_t>(1, std::llround(length / tiling.length));
  for (const std::string& name : materials_of(cell))
    tiling.materials.push_back(model.material(name));
  tiling.names = model.ground.present ? std::map<std::string, std::string>{{"floor", "ground"}}
                                      : std::map<std::string, std::string>{{"ground", "floor"}};
  return tiling;
}

// Finds all reasons why a cell does not fit a deck, so that they are reported together. Collective,
// since all ranks read the file.
class CellCheck {
 public:
  CellCheck(const io::File& file, const Model& model, const input::Deck& deck)
      : file_(file),
        cell_(input::values_of(file.text_attribute("/", "deck"))),
        model_(model),
        deck_(deck) {}

  std::vector<std::string> problems() {
    look_at_state();
    if (cell_.at("dimension") != quoted(model_.dimension == Dimension::plane ? "plane" : "space"))
      add("bed.cell",
          fmt::format("was made with dimension = {}; cell and bed must have the same dimension",
                      cell_.at("dimension")));
    else
      look_at_sides();
    look_at_length();
    look_at_materials();
    look_at_stages();
    // The mass of the lightest stone is known only if all materials are.
    if (problems_.empty()) look_at_step();
    return problems_;
  }

 private:
  static std::string quoted(const std::string& word) { return '"' + word + '"'; }
  void add(const std::string& key, const std::string& sentence) {
    problems_.push_back(
        key == "bed.cell" ? fmt::format("{} \"{}\" {}", deck_.where(key), model_.bed.cell, sentence)
                          : fmt::format("{} {}", deck_.where(key), sentence));
  }

  // The cell must be the end of a stage, with stones only. Within a stage damping and friction may
  // be those of the stage, and the bed may not be in equilibrium.
  void look_at_state() {
    if (file_.integer_attribute("/", "stage_finished") == 0)
      add("bed.cell", fmt::format("was written within stage \"{}\"; take a checkpoint that was "
                                  "written at the end of a stage (stage_*.h5)",
                                  file_.text_attribute("/", "stage")));
    if (file_.extent("particles/id").at(0) == 0) add("bed.cell", "contains no stones");
    if (file_.has("platen"))
      add("bed.cell",
          "was written with the platen on the stones; take a checkpoint that was written after a "
          "stage of kind release");
    if (file_.has("sleepers"))
      add("bed.cell",
          "contains sleepers, which cannot be repeated; take a checkpoint that was written before "
          "the sleepers were placed");
    if (file_.has("ground"))
      add("bed.cell",
          "was written with a ground that has moved; take a checkpoint that was written before the "
          "first stage with ground_moves");
  }

  // The sides across the track must be equal numbers: overlaps of stones and walls are microns.
  void look_at_sides() {
    if (model_.dimension == Dimension::plane) {
      if (cell_.at("thickness") != fmt::format("{}", model_.thickness) &&
          std::stod(cell_.at("thickness")) != model_.thickness)
        add("thickness", fmt::format("= {:g} m: the cell was made with {} m; both must be equal",
                                     model_.thickness, cell_.at("thickness")));
      return;
    }
    if (periodic_in(cell_, "y") != model_.periodic_in("y"))
      add("periodic",
          fmt::format("{} \"y\", but the cell was made {} it; both must contain \"y\" or neither",
                      model_.periodic_in("y") ? "contains" : "is without",
                      periodic_in(cell_, "y") ? "with" : "without"));
    const std::vector<double> y = numbers_of(cell_, "bed.y");
    if (y != model_.bed.y)
      add("bed.y", fmt::format("= [{:g}, {:g}] m: the cell reaches from {:g} to {:g} m; both must "
                               "be equal",
                               model_.bed.y[0], model_.bed.y[1], y.at(0), y.at(1)));
  }

  // Whole cells only: a cell that is cut has an end without a matching neighbour.
  void look_at_length() {
    if (!periodic_in(cell_, "x"))
      return add("bed.cell", "was not made with periodic = [\"x\"]: its ends do not match");
    const dem::Tiling tiling = tiling_of(cell_, model_);
    const double length = model_.bed.x[1] - model_.bed.x[0], times = length / tiling.length;
    if (std::abs(times - static_cast<double>(tiling.copies)) <= whole_cells * times) return;
    const double fewer = std::max(1.0, std::floor(times)), more = std::max(2.0, fewer + 1);
    add("bed.x",
        fmt::format("is {:g} m long, which is {:.4g} cells of {:g} m; it must be a whole number of "
                    "cells: the nearest lengths are {:g} and {:g} m",
                    length, times, tiling.length, fewer * tiling.length, more * tiling.length));
  }

  // A second fill would place stones that overlap others.
  void look_at_stages() {
    const auto fills = std::count_if(model_.stages.begin(), model_.stages.end(),
                                     [](const Stage& s) { return s.kind == StageKind::fill; });
    if (fills > 1)
      add("bed.cell",
          fmt::format("needs exactly one stage of kind fill, which places the copies of the "
                      "cell; the deck has {} such stages",
                      fills));
  }

  // Only materials of stones are checked; the cell's deck may have others.
  void look_at_materials() {
    const std::vector<std::string> names = materials_of(cell_);
    std::set<std::string> used;
    for (const std::int64_t m : file_.read_all<std::int64_t>("particles/material"))
      used.insert(names.at(static_cast<std::size_t>(m)));
    for (const std::string& name : used) {
      if (model_.material(name) < 0) {
        add("bed.cell",
            fmt::format("has stones of \"{}\", but no [[material]] has that name", name));
        continue;
      }
      std::set<std::string> touched = used;
      touched.insert(model_.ground_material);
      if (model_.uses_walls()) touched.insert(model_.wall_material);
      if (model_.uses_sleepers()) touched.insert(model_.sleepers.material);
      for (const std::string& other : touched)
        if (model_.material(other) >= 0 && !model_.physics.has_law(name, other))
          add("bed.cell", fmt::format("has stones of \"{}\" that touch \"{}\", but no [[contact]] "
                                      "gives a law for this pair",
                                      name, other));
    }
  }

  // As for stones that are to be made: a step that is too long is refused before the run and not
  // only when its first stage begins.
  void look_at_step() {
    const auto shape = file_.read_all<std::int64_t>("particles/shape");
    const auto scale = file_.read_all<double>("particles/scale");
    const auto material = file_.read_all<std::int64_t>("particles/material");
    const std::vector<dem::Template> shapes = dem::load_templates(file_, "particles/template");
    const bool plane = model_.dimension == Dimension::plane;
    const dem::Tiling tiling = tiling_of(cell_, model_);
    double lightest = std::numeric_limits<double>::infinity(), largest = 0;
    for (std::size_t i = 0; i < shape.size(); ++i) {
      const dem::Template& t = shapes.at(static_cast<std::size_t>(shape[i]));
      const auto number = tiling.materials.at(static_cast<std::size_t>(material[i]));
      const double density = model_.physics.materials[static_cast<std::size_t>(number)].density;
      lightest = std::min(lightest, density * t.volume * std::pow(scale[i], plane ? 2 : 3) *
                                        (plane ? model_.thickness : 1));
      largest = std::max(largest, scale[i] * bound_of(t));
    }
    std::string words;
    const double limit = dem::stable_step(model_.physics, model_.dem, lightest, largest, &words);
    // Margin for rounding: a step copied from the log of an earlier run has few digits.
    if (model_.time.step > limit * (1 + 1e-9))
      add("time.step", fmt::format("= {:g} s is above the stable sub-step of {:.4g} s ({})",
                                   model_.time.step, limit, words));
  }

  // m, bounding radius at unit scale.
  static double bound_of(const dem::Template& shape) {
    double bound = 0;
    for (const dem::Piece& piece : shape.pieces)
      for (const Vec3& corner : piece.core.vertices)
        bound = std::max(bound, corner.norm() + piece.radius);
    return bound;
  }

  const io::File& file_;
  const input::Values cell_;
  const Model& model_;
  const input::Deck& deck_;
  std::vector<std::string> problems_;
};

}  // namespace

// Problems of the file itself begin with its name: the position in the deck is put before them.
void require_cell(const par::Comm& comm, const Model& model, const input::Deck& deck) {
  try {
    const io::File file = open_cell(comm, model);
    if (const auto problems = CellCheck(file, model, deck).problems(); !problems.empty())
      throw InputError(problems);
  } catch (const InputError& error) {  // equal on all ranks
    std::vector<std::string> problems = error.problems();
    const std::string place = deck.where("bed.cell");
    for (std::string& problem : problems)
      if (problem.starts_with(model.bed.cell)) problem = fmt::format("{} = {}", place, problem);
    throw InputError(problems);
  }
}

namespace {

// By the spheres at the corners: no stone may initially overlap a wall, which would expel it.
void cut_at_ends(World& world) {
  const dem::Domain& domain = world.particles.domain();
  std::vector<Id> doomed;  // `remove` passes stones one by one with their id: collect ids first
  for (std::size_t i = 0; i < world.particles.size(); ++i) {
    bool beyond = false;
    world.particles.corners(i, [&](const Vec3& centre, double radius) {
      beyond =
          beyond || centre.x() - radius < domain.low.x() || centre.x() + radius > domain.high.x();
    });
    if (beyond) doomed.push_back(world.particles[i].id);
  }
  std::sort(doomed.begin(), doomed.end());
  world.particles.remove([&](const dem::ParticleView& stone) {
    return std::binary_search(doomed.begin(), doomed.end(), stone.id);
  });
}

}  // namespace

// The cell's steps, damping and clock belong to another run and are not kept.
double lay_cells(World& world) {
  const io::File file = open_cell(world.comm, world.model);
  const input::Values cell = input::values_of(file.text_attribute("/", "deck"));
  world.particles.tile(file, "particles", tiling_of(cell, world.model));
  if (!world.model.periodic_in("x")) cut_at_ends(world);
  return world.top_of_stones();
}

}  // namespace trackbed::model
