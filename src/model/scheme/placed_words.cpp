// There are few kinds of error messages in a run of placed stones, so their text is matched here,
// and the module dem needs no names of stones.
#include "model/scheme/placed_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <regex>

#include "model/scene/world.hpp"

namespace trackbed::model {

namespace {

std::string stone_named(const World& world, Id id) {
  const auto& stones = world.model.placed.stones;
  const auto number = static_cast<std::size_t>(id);
  if (number >= stones.size()) return fmt::format("part {} of a broken stone", id);
  return fmt::format("stone \"{}\"", stones[number].name);
}

// m, smallest radius of the pieces of an own stone; infinite for others.
double rounding_of(const dem::Particles& particles, Id id) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < particles.size(); ++i)
    if (particles[i].id == id)
      particles.corners(i, [&](const Vec3&, double r) { least = std::min(least, r); });
  return least;
}

// The two stones of the deepest contact of this rank; empty if there is none.
std::string deepest_pair(const World& world) {
  double deepest = 0;
  std::string names;
  world.particles.contacts([&](const dem::ContactView& c) {
    if (c.second < 0) return;
    const double radius =
        std::min(rounding_of(world.particles, c.first), rounding_of(world.particles, c.second));
    if (!(c.overlap > deepest * radius)) return;
    deepest = c.overlap / radius;
    names = fmt::format("{} and {}", stone_named(world, c.first), stone_named(world, c.second));
  });
  return names;
}

// A step in which a centre would pass a surface is an error (dem/particles/leap.cpp): a stone in
// contact whose centre is behind the surface came from behind. The inside of a closed box is behind
// all its faces.
bool came_from_behind(const World& world, const Vec3& centre, const std::string& name) {
  for (const Surface& surface : world.placement->surfaces()) {
    if (surface.name != name) continue;
    return bed::is_behind(centre, surface);
  }
  return false;
}

}  // namespace

std::string by_names(const std::string& problem, const World& world) {
  static const std::regex one("particle (\\d+)"), two("^two stones"),
      surface("overlaps the surface \"([^\"]*)\"");
  std::smatch found, where;
  if (std::regex_search(problem, found, two)) {
    const std::string names = deepest_pair(world);
    return names.empty() ? problem
                         : names + problem.substr(static_cast<std::size_t>(found.length()));
  }
  if (!std::regex_search(problem, found, one)) return problem;
  const Id id = std::stoll(found[1]);
  std::string words = found.prefix().str() + stone_named(world, id) + found.suffix().str();
  if (!std::regex_search(problem, where, surface)) return words;
  for (std::size_t i = 0; i < world.particles.size(); ++i)
    if (world.particles[i].id == id &&
        came_from_behind(world, world.particles[i].position, where[1]))
      words += "; this stone came from behind the surface, where plates and walls have no contact";
  return words;
}

}  // namespace trackbed::model
