// Stones that a deck places one by one, with plates and boxes, use the run of a bed without its
// other parts: no bed, no ground, no sleepers. Stages, steps, output, checkpoints and resume are
// therefore those of a bed. Rejected: a separate run, most of which would be the same code.
//
// The rules here tie tables together. Initial overlaps depend on the shapes and are checked when
// the stones are made (placed_check.hpp).
#include "model/rules/placed_rules.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "model/rules/rules.hpp"
#include "model/rules/skin_rule.hpp"

namespace trackbed::model {

namespace {

using bed::vector_of;

// Key and material of each placed part.
using Parts = std::vector<std::pair<std::string, std::string>>;

Parts parts_of(const char* list, const auto& tables) {
  Parts parts;
  for (std::size_t i = 0; i < tables.size(); ++i)
    parts.emplace_back(fmt::format("{}[{}].material", list, i), tables[i].material);
  return parts;
}

// Each material exists, and there is a law for those that may be in contact.
void declare_materials_of_placed(const Model& model, input::Section& s) {
  const Parts stones = parts_of("stone", model.placed.stones);
  Parts all = stones;
  for (const Parts& more :
       {parts_of("plate", model.placed.plates), parts_of("box", model.placed.boxes)})
    all.insert(all.end(), more.begin(), more.end());
  std::set<std::string> touch_themselves;  // materials of which this has been looked at
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& [key, name] = all[i];
    model.physics.rule_of_name(s, key, name);
    if (model.material(name) < 0) continue;
    for (std::size_t j = 0; j < std::min(i, stones.size()); ++j) {
      const std::string& other = stones[j].second;
      if (other == name && !touch_themselves.insert(name).second) continue;
      s.rule(key, model.material(other) < 0 || model.physics.has_law(name, other),
             fmt::format("may be in contact with stones of \"{}\", but no [[contact]] gives a law "
                         "for this pair",
                         other),
             {.reads = {"contact", "material", "stone", key}});
    }
  }
}

// Parameters of a law of the other kind. Not checked for beds, whose decks often change only `law`.
void declare_idle_of_laws(const Model& model, input::Section& s) {
  const dem::ContactLaw usual;
  for (std::size_t i = 0; i < model.physics.laws.size(); ++i) {
    const dem::ContactLaw& law = model.physics.laws[i];
    const bool hertz = law.kind == dem::LawKind::hertz;
    const auto idle = [&](const char* name, bool acts, bool given) {
      const std::string key = fmt::format("contact[{}].{}", i, name);
      s.rule(
          key, acts || !given,
          fmt::format("has no effect with law = \"{}\"; leave it out", hertz ? "hertz" : "linear"),
          {.reads = {fmt::format("contact[{}].law", i), key}});
    };
    idle("k_n", !hertz, law.k_n != usual.k_n);
    idle("k_s", !hertz, law.k_s != usual.k_s);
    idle("zeta_n", !hertz, law.zeta_n != usual.zeta_n);
    idle("zeta_s", !hertz, law.zeta_s != usual.zeta_s);
    idle("restitution", hertz, law.restitution != usual.restitution);
    const auto rolls = [&](const char* name, bool given) {
      const std::string key = fmt::format("contact[{}].{}", i, name);
      s.rule(key, law.rolling_friction > 0 || !given,
             "has no effect with rolling_friction = 0; leave it out",
             {.reads = {fmt::format("contact[{}].rolling_friction", i), key}});
    };
    rolls("rolling_stiffness", law.rolling_stiffness != usual.rolling_stiffness);
    rolls("zeta_r", law.zeta_r != usual.zeta_r);
  }
}

// In a plane model all positions and motions are in y = 0.
void declare_plane(const Model& model, input::Section& s) {
  s.rule("thickness", model.dimension == Dimension::plane || model.thickness == Model{}.thickness,
         "has no effect with dimension = \"space\"; leave it out",
         {.reads = {"thickness", "dimension"}});
  if (model.dimension != Dimension::plane) return;
  const auto zero = [&](const std::string& key, double value) {
    s.rule(key, value == 0, "must have the y component 0 in a plane model",
           {.reads = {key, "dimension"}});
  };
  const auto about_y = [&](const std::string& key, const std::vector<double>& axis, double angle) {
    const Vec3 a = vector_of(axis);
    s.rule(key + ".axis", angle == 0 || (a.x() == 0 && a.z() == 0),
           "must be along y in a plane model", {.reads = {key, "dimension"}});
  };
  const PlacedParameters& placed = model.placed;
  for (std::size_t i = 0; i < placed.stones.size(); ++i) {
    const bed::StoneParameters& stone = placed.stones[i];
    const std::string key = fmt::format("stone[{}]", i);
    const bool flat = stone.shape == bed::ShapeKind::ball ||
                      (stone.shape == bed::ShapeKind::clump && !stone.spheres.empty());
    s.rule(
        key + ".shape", flat,
        "gives three-dimensional stones: a plane model allows ball, and clump with given spheres",
        {.reads = {key, "dimension"}});
    zero(key + ".position", vector_of(stone.position).y());
    zero(key + ".velocity", vector_of(stone.velocity).y());
    const Vec3 spin = vector_of(stone.spin);
    s.rule(key + ".spin", spin.x() == 0 && spin.z() == 0, "must be about y in a plane model",
           {.reads = {key, "dimension"}});
    about_y(key, stone.axis, stone.angle);
  }
  for (std::size_t i = 0; i < placed.plates.size(); ++i) {
    const std::string key = fmt::format("plate[{}]", i);
    zero(key + ".normal", vector_of(placed.plates[i].normal).y());
    zero(key + ".velocity", vector_of(placed.plates[i].velocity).y());
  }
  for (std::size_t i = 0; i < placed.boxes.size(); ++i) {
    const std::string key = fmt::format("box[{}]", i);
    zero(key + ".velocity", vector_of(placed.boxes[i].velocity).y());
    about_y(key, placed.boxes[i].axis, placed.boxes[i].angle);
  }
}

void declare_stages_of_placed(const Model& model, input::Section& s) {
  declare_names_of_stages(model, s);
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const std::string key = fmt::format("stage[{}].", i);
    const Stage& stage = model.stages[i];
    s.rule(key + "kind", stage.kind == StageKind::run || stage.kind == StageKind::settle,
           "must be \"run\" or \"settle\": models of placed stones have no bed and no sleepers",
           {.reads = {key + "kind"}});
    s.rule(key + "stiffness", stage.stiffness == 1, "must be 1: it is for beds that are poured",
           {.reads = {key + "stiffness"}});
    s.rule(key + "ground_moves", !stage.ground_moves, "must be false: there is no ground",
           {.reads = {key + "ground_moves"}});
  }
  declare_uses_of_stages(model, s);
}

// m, bounding radius of a stone about its centre of mass; a rough value if its file has not been
// read.
double reach_of(const bed::StoneParameters& p) {
  constexpr double long_stone = 3, unknown = 0.2;
  if (p.shape == bed::ShapeKind::ball) return p.radius;
  if (p.shape == bed::ShapeKind::block) return vector_of(p.sides).norm();
  if (p.size > 0) return long_stone * p.size;
  double reach = 0;
  for (std::size_t k = 0; k + 3 < p.spheres.size(); k += 4)
    reach = std::max(reach, 2 * Vec3(p.spheres[k], p.spheres[k + 1], p.spheres[k + 2]).norm() +
                                p.spheres[k + 3]);
  for (std::size_t k = 0; k + 2 < p.corners.size(); k += 3)
    reach = std::max(reach, 2 * Vec3(p.corners[k], p.corners[k + 1], p.corners[k + 2]).norm());
  return reach > 0 ? reach : unknown;
}

void declare_domain(const Model& model, input::Section& s) {
  const DomainParameters& d = model.placed.domain;
  const auto ok = [](const std::vector<double>& v) { return v.empty() || v.size() == 3; };
  s.rule("domain.low", ok(d.low) && d.low.size() == d.high.size(),
         "domain.low and domain.high must both be three numbers, or both be left out",
         {.reads = {"domain"}});
  if (!ok(d.low) || d.low.size() != d.high.size()) return;
  const dem::Domain box = model.domain();
  const bool rises = d.low.empty() || (vector_of(d.high) - vector_of(d.low)).minCoeff() > 0;
  s.rule("domain.high", rises,
         fmt::format("must be above `low` in x, y and z (low = [{:g}] m)", fmt::join(d.low, ", ")),
         {.reads = {"domain"}});
  for (std::size_t i = 0; rises && i < model.placed.stones.size(); ++i) {
    const Vec3 at = vector_of(model.placed.stones[i].position);
    const std::string key = fmt::format("stone[{}].position", i);
    s.rule(key, (at - box.low).minCoeff() >= 0 && (box.high - at).minCoeff() >= 0,
           fmt::format("is outside of the domain ([{:g}, {:g}, {:g}] to [{:g}, {:g}, {:g}] m)",
                       box.low.x(), box.low.y(), box.low.z(), box.high.x(), box.high.y(),
                       box.high.z()),
           {.reads = {key, "domain", "dimension", "stone", "plate", "box", "stage"}});
  }
}

void declare_motion(const Model& model, input::Section& s) {
  const auto& stones = model.placed.stones;
  s.rule("stone", !stones.empty(), "at least one [[stone]] is needed", {.reads = {"stone"}});
  const bool moves = std::any_of(stones.begin(), stones.end(), [](const auto& stone) {
    return stone.motion == bed::MotionKind::free;
  });
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  for (const bed::StoneParameters& stone : stones) {
    smallest = std::min(smallest, 2 * reach_of(stone));
    largest = std::max(largest, 2 * reach_of(stone));
  }
  if (!stones.empty()) declare_skin(model, smallest, largest, s);
  const bool corners = std::any_of(stones.begin(), stones.end(), [](const auto& stone) {
    return stone.shape != bed::ShapeKind::ball && stone.shape != bed::ShapeKind::clump;
  });
  declare_steadiness(model, corners, s);
  // A contact of the lightest stone with the stiffest spring lasts half a period, pi sqrt(m/k).
  const double contact = std::min(std::numbers::pi / model.dem.safety, 1e6);  // sub-steps
  s.rule("time.substeps",
         model.time.window > 0 || model.time.step > 0 || model.time.substeps == 1 ||
             model.time.substeps <= contact / 4,
         fmt::format(
             "a window of {} sub-steps is too long: a contact of the lightest stone lasts about "
             "{:.1f} sub-steps; impulses, peak forces and supplied work are sampled once per "
             "window, and a contact needs at least four samples; give at most {:d}",
             model.time.substeps, contact, std::max(1, static_cast<int>(contact / 4))),
         {.severity = input::Severity::warning, .reads = {"time.substeps", "dem.safety"}});
  s.rule("time.step", stones.empty() || moves || model.time.step > 0,
         "must be given: no stone is free, so that the program cannot derive a step from stability",
         {.reads = {"stone", "time"}});
}

}  // namespace

void DomainParameters::declare(input::Section& s) {
  s.numbers("low", low, {.unit = "m"},
            "Lower corner (x, y, z) of the domain of stone centres; none: chosen from positions, "
            "speeds and the duration of all stages.");
  s.numbers("high", high, {.unit = "m"},
            "Upper corner (x, y, z) of the domain; a stone that leaves the domain ends the run.");
}

void PlacedParameters::declare(input::Section& s) {
  // Positions of plates follow from the deck and the time.
  const auto fixed = s.fixed_by(input::state::any);
  s.table("domain", domain, "Domain of the stones (model = \"stones\").");
  s.tables("stone", stones, "A stone placed by the deck (model = \"stones\").");
  s.tables("plate", plates, "A rectangular contact surface (model = \"stones\").");
  s.tables("box", boxes, "A closed box as contact surface (model = \"stones\").");
}

void declare_no_placed(const PlacedParameters& placed, input::Section& s) {
  const auto none = [&](const char* key, bool empty) {
    s.rule(key, empty, "is only for model = \"stones\": in other models stages make the stones",
           {.reads = {key, "model"}});
  };
  none("stone", placed.stones.empty());
  none("plate", placed.plates.empty());
  none("box", placed.boxes.empty());
  none("domain", placed.domain.low.empty() && placed.domain.high.empty());
}

// Space, materials and placed parts; stages, steps and output as of a bed.
void Model::declare_placed(input::Section& s) {
  ground.present = false;
  declare_space(s);
  physics.declare(s);
  s.table("dem", dem, "Integration and contact search of stones.");
  placed.declare(s);
  s.table("breakage", breakage, breakage_meaning);
  s.tables("bond", bonds, bond_meaning);
  s.table("output", output, "What is written, and when the run stops early.");
  s.tables("stage", stages, "The stages of the run, one after the other.");
  // The exact limit is known as soon as the stones are made.
  time.rough_step = time.rough_window = input::unbounded;
  s.table("time", time, "Time steps.");
  declare_names_of_placed(*this, s);
  declare_motion(*this, s);
  declare_materials_of_placed(*this, s);
  declare_idle_of_laws(*this, s);
  declare_plane(*this, s);
  declare_stages_of_placed(*this, s);
  declare_breakage(*this, s);
  declare_bonds(*this, s);
  declare_domain(*this, s);
}

// The margin is the travel of the fastest stone at twice its speed plus twice the fall in the whole
// time: collisions of unequal stones can double a speed. If there are surfaces, it is limited to
// some extents of all that is placed.
dem::Domain domain_of_placed(const Model& model) {
  constexpr double far = 20;  // extents of what is placed
  const PlacedParameters& placed = model.placed;
  const bool plane = model.dimension == Dimension::plane;
  dem::Domain domain;
  domain.dimension = model.dimension;
  domain.thickness = plane ? model.thickness : 1;
  if (placed.domain.low.size() == 3 && placed.domain.high.size() == 3) {
    domain.low = vector_of(placed.domain.low), domain.high = vector_of(placed.domain.high);
  } else {
    Eigen::AlignedBox3d box;
    const double time = model.duration();
    double speed = 0;
    for (const bed::StoneParameters& stone : placed.stones) {
      const Vec3 at = vector_of(stone.position), reach = Vec3::Constant(reach_of(stone));
      box.extend(Eigen::AlignedBox3d(at - reach, at + reach));
      // A contact can transfer the surface speed of a spinning stone.
      speed = std::max(
          speed, vector_of(stone.velocity).norm() + vector_of(stone.spin).norm() * reach_of(stone));
    }
    const bed::PlacedSurfaces surfaces(placed.plates, placed.boxes, model.physics, model.dimension,
                                       domain.thickness);
    for (std::size_t k = 0; k < surfaces.surfaces().size(); ++k) {
      for (const Vec3& node : surfaces.surfaces()[k].position) box.extend(node);
      speed = std::max(speed, surfaces.velocity(k).norm());
    }
    if (box.isEmpty()) box.extend(Vec3(Vec3::Zero()));
    const double extent = box.sizes().maxCoeff();
    double travel = 2 * speed * time + model.dem.gravity * time * time;
    if (!surfaces.surfaces().empty()) travel = std::min(travel, far * extent);
    domain.low = box.min() - Vec3::Constant(travel + extent);
    domain.high = box.max() + Vec3::Constant(travel + extent);
  }
  if (plane) domain.low.y() = -model.thickness / 2, domain.high.y() = model.thickness / 2;
  return domain;
}

}  // namespace trackbed::model
