// Initial overlaps are those of the contacts of the first force computation; overlaps too deep for
// a contact are found from the shapes (bed/placed_depth.cpp), stones that reach a surface from
// behind from their trajectories.
#include "model/check/placed_begin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "model/scene/world.hpp"

namespace trackbed::model {

namespace {

// Fraction of the smaller radius (of stones with corners: of their rounding). Overlaps in static
// equilibrium are smaller; larger ones need dem.largest_overlap.
constexpr double noticed = 0.01;

// The deepest contact of a pair; second < 0: -1 - surface.
struct DeepContact {
  Id first, second;
  double overlap, radius;  // m
};

// m, smallest radius of the pieces of a stone, with which overlaps are compared.
double rounding_of(const dem::Particles& particles, std::size_t i) {
  double least = std::numeric_limits<double>::infinity();
  particles.corners(i, [&](const Vec3&, double radius) { least = std::min(least, radius); });
  return least;
}

// Each pair once, in the order of ids, the same on all ranks.
std::map<std::pair<Id, Id>, DeepContact> deep_contacts(const par::Comm& comm,
                                                       const dem::Particles& particles,
                                                       std::size_t stones) {
  std::vector<double> radius(stones, 0);
  for (std::size_t i = 0; i < particles.size(); ++i)
    radius[static_cast<std::size_t>(particles[i].id)] = rounding_of(particles, i);
  comm.sum(std::span<double>(radius));
  std::vector<DeepContact> mine;
  particles.contacts([&](const dem::ContactView& c) {
    double least = radius[static_cast<std::size_t>(c.first)];
    if (c.second >= 0) least = std::min(least, radius[static_cast<std::size_t>(c.second)]);
    if (!(c.overlap <= noticed * least)) mine.push_back({c.first, c.second, c.overlap, least});
  });
  std::map<std::pair<Id, Id>, DeepContact> deepest;
  for (const DeepContact& d : comm.all_gather(std::span<const DeepContact>(mine))) {
    const auto [known, is_new] = deepest.try_emplace({d.first, d.second}, d);
    if (!is_new && d.overlap > known->second.overlap) known->second = d;
  }
  return deepest;
}

// Adds overlaps that are too deep for a contact. The same on all ranks.
void add_hidden(const World& world, const std::vector<bed::PlacedShape>& shapes,
                std::map<std::pair<Id, Id>, DeepContact>& deepest) {
  const std::vector<Surface>& surfaces = world.placement->surfaces();
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const auto pieces = bed::pieces_in_space(shapes[i], world.model.placed.stones[i]);
    double least = std::numeric_limits<double>::infinity();
    for (const geom::Piece& piece : pieces) least = std::min(least, piece.radius);
    for (std::size_t k = 0; k < surfaces.size(); ++k) {
      const Id stone = static_cast<Id>(i), surface = -1 - static_cast<Id>(k);
      const double depth = bed::penetration_depth(pieces, surfaces[k]);
      if (!(depth > noticed * least)) continue;
      DeepContact& deep =
          deepest.try_emplace({stone, surface}, DeepContact{stone, surface, 0, least})
              .first->second;
      deep.overlap = std::max(deep.overlap, depth);
    }
  }
}

std::string initial_overlap(const DeepContact& deep, const World& world, const input::Deck& deck) {
  const auto& stones = world.model.placed.stones;
  const auto other = [&] {
    if (deep.second >= 0)
      return fmt::format("stone \"{}\"", stones[static_cast<std::size_t>(deep.second)].name);
    const auto k = static_cast<std::size_t>(-1 - deep.second);
    return fmt::format("surface \"{}\"", world.placement->surfaces()[k].name);
  }();
  return fmt::format(
      "{}: stone \"{}\" initially overlaps {} by {:.4g} m, {:.3g} times the smaller radius (for "
      "stones with corners: the smaller rounding radius)",
      deck.where(fmt::format("stone[{}].position", deep.first)),
      stones[static_cast<std::size_t>(deep.first)].name, other, deep.overlap,
      deep.overlap / deep.radius);
}

// Stones that reach a plate or wall first from the side without contact. Their trajectories are
// computed without spin and without contacts with other stones.
std::vector<std::string> from_behind(const World& world,
                                     const std::vector<bed::PlacedShape>& shapes,
                                     const input::Deck& deck) {
  const Model& model = world.model;
  const double until = model.duration();
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < model.placed.stones.size(); ++i) {
    const bed::StoneParameters& stone = model.placed.stones[i];
    const bool falls = stone.motion == bed::MotionKind::free;
    const auto reached = world.placement->first_impact(
        bed::pieces_in_space(shapes[i], stone),
        {bed::vector_of(stone.velocity), falls ? model.dem.gravity : 0}, until);
    if (!reached || !reached->from_behind) continue;
    sentences.push_back(fmt::format(
        "{}: stone \"{}\" reaches surface \"{}\" from behind after about {:.3g} s, which ends the "
        "run: plates and walls have contact on one side only; reverse the normal, change the "
        "side of a box, or place the stone in front of the surface",
        deck.where(fmt::format("stone[{}].position", i)), stone.name,
        world.placement->surfaces()[reached->surface].name, reached->time));
  }
  return sentences;
}

// m, the largest gap in a minimum spanning tree of all spheres; below 0 they are connected.
double gap_of(const std::vector<geom::Piece>& balls) {
  std::vector<double> gap(balls.size(), std::numeric_limits<double>::infinity());
  std::vector<bool> joined(balls.size(), false);
  double widest = -std::numeric_limits<double>::infinity();
  std::size_t last = 0;
  joined[last] = true;
  for (std::size_t count = 1; count < balls.size(); ++count) {  // Prim
    std::size_t next = 0;
    for (std::size_t k = 0; k < balls.size(); ++k) {
      if (joined[k]) continue;
      const double apart = (balls[k].core.vertices[0] - balls[last].core.vertices[0]).norm();
      gap[k] = std::min(gap[k], apart - balls[k].radius - balls[last].radius);
      if (joined[next] || gap[k] < gap[next]) next = k;
    }
    widest = std::max(widest, gap[next]);
    joined[next] = true, last = next;
  }
  return widest;
}

// Warns of clumps whose spheres are not connected.
std::vector<std::string> loose_clumps(const World& world,
                                      const std::vector<bed::PlacedShape>& shapes,
                                      const input::Deck& deck) {
  constexpr double touching = 1e-6;  // of the radius: decks are written with some digits
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const bed::StoneParameters& stone = world.model.placed.stones[i];
    if (stone.shape != bed::ShapeKind::clump || stone.spheres.empty()) continue;
    const auto balls = bed::pieces_in_space(shapes[i], stone);
    const double gap = gap_of(balls);
    if (gap > touching * balls[0].radius)
      sentences.push_back(fmt::format(
          "{}: spheres of stone \"{}\" are separated by a gap of {:.3g} m but move as one rigid "
          "body; let them overlap, or place several stones",
          deck.where(fmt::format("stone[{}].spheres", i)), stone.name, gap));
  }
  return sentences;
}

}  // namespace

PlacesOfStones look_at_places(const World& world, const std::vector<bed::PlacedShape>& shapes,
                              const input::Deck& deck) {
  const Model& model = world.model;
  auto deepest = deep_contacts(world.comm, world.particles, model.placed.stones.size());
  add_hidden(world, shapes, deepest);
  PlacesOfStones found;
  for (const auto& [pair, deep] : deepest) {
    const std::string where = initial_overlap(deep, world, deck);
    if (!(deep.overlap <= model.dem.largest_overlap * deep.radius))
      found.problems.push_back(
          fmt::format("{}; the limit is dem.largest_overlap = {:g}: place the stone further away",
                      where, model.dem.largest_overlap));
    else
      found.warnings.push_back(
          fmt::format("{}; the limit is dem.largest_overlap = {:g}: if they should not overlap, "
                      "place the stone further away",
                      where, model.dem.largest_overlap));
  }
  for (const auto& more : {from_behind(world, shapes, deck), loose_clumps(world, shapes, deck)})
    found.warnings.insert(found.warnings.end(), more.begin(), more.end());
  return found;
}

}  // namespace trackbed::model
