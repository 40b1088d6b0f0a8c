// Removing and filling stones around sleepers.
//
// Crib boxes need not be exact: stones settle into them, and those above the profile are removed at
// the end. The boxes must not overlap sleepers and must cover every gap.
#include "model/stages/cribs.hpp"

#include <algorithm>

namespace trackbed::model {

namespace {

// Bounding box of the nodes. It is larger than a tilted sleeper; stones are kept out of all of it.
bed::Box box_around(const Surface& surface) {
  bed::Box box{surface.position[0], surface.position[0]};
  for (const Vec3& node : surface.position) {
    box.low = box.low.cwiseMin(node);
    box.high = box.high.cwiseMax(node);
  }
  return box;
}

}  // namespace

// Sleepers are in rising order of x. One box per gap, from the end of one sleeper to the start of
// the next, over the whole width; in space two more beside the ends of each sleeper. The first and
// the last box reach to the ends of the bed. Empty boxes (sleepers that touch, or as long as the
// bed is wide) are dropped.
std::vector<bed::Box> cribs(World& world, double top) {
  const dem::Domain& all = world.particles.domain();
  std::vector<bed::Box> boxes;
  double x = all.low.x(), base = world.sleepers->bottom();
  for (const Surface& surface : world.sleepers->surfaces()) {
    const bed::Box sleeper = box_around(surface);
    base = sleeper.low.z();
    const double begin = sleeper.low.x(), end = sleeper.high.x();
    boxes.push_back({Vec3(x, all.low.y(), base), Vec3(begin, all.high.y(), top)});
    if (all.dimension == Dimension::space) {
      boxes.push_back({Vec3(begin, all.low.y(), base), Vec3(end, sleeper.low.y(), top)});
      boxes.push_back({Vec3(begin, sleeper.high.y(), base), Vec3(end, all.high.y(), top)});
    }
    x = end;
  }
  boxes.push_back({Vec3(x, all.low.y(), base), Vec3(all.high.x(), all.high.y(), top)});
  std::erase_if(boxes, [](const bed::Box& box) { return (box.high - box.low).minCoeff() <= 0; });
  return boxes;
}

// A stone is removed if the bounding sphere of any of its pieces overlaps a sleeper: exact for
// pebbles, conservative for polyhedra. The gaps that this leaves beside a sleeper close in the
// stage `sleepers`. Each rank decides on its own stones; ghosts follow.
void dig_out_sleepers(World& world) {
  std::vector<Id> doomed;  // `remove` passes stones one by one with their id: collect ids first
  for (std::size_t i = 0; i < world.particles.size(); ++i) {
    bool hit = false;
    world.particles.pieces(i, [&](const Vec3& centre, double radius) {
      hit = hit || world.sleepers->overlaps(centre, radius);
    });
    if (hit) doomed.push_back(world.particles[i].id);
  }
  std::sort(doomed.begin(), doomed.end());
  world.particles.remove([&](const dem::ParticleView& stone) {
    return std::binary_search(doomed.begin(), doomed.end(), stone.id);
  });
}

// By centres of mass: stones that protrude from the profile by less than half remain, as on a real
// track.
void cut_to_profile(World& world, double crest) {
  world.particles.remove([&](const dem::ParticleView& s) {
    return s.position.z() > world.model.bed.top_at(s.position.y(), crest);
  });
}

}  // namespace trackbed::model
