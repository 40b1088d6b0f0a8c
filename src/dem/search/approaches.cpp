// Search for pieces near surfaces. Triangles may be of any size: each is assigned to all cells
// covered by its box, so that one large wall does not increase the search distance of all
// particles.
#include <algorithm>
#include <unordered_map>

#include "dem/search/pairs.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::dem {

namespace {

// Region in which a triangle may be during the window, m.
struct Box {
  Vec3 low, high;
  bool overlaps(const Vec3& centre, double reach) const {
    return ((centre.array() + reach) >= low.array()).all() &&
           ((centre.array() - reach) <= high.array()).all();
  }
};

// Nodes move linearly, so the box around both ends of the window contains all positions in between.
Box box_of(const Surface& surface, std::size_t triangle) {
  Box box{Vec3::Constant(1e300), Vec3::Constant(-1e300)};
  for (const std::int32_t node : surface.triangles[triangle])
    for (const double s : {0.0, 1.0}) {
      const Vec3 at = node_at(surface, node, s);
      box.low = box.low.cwiseMin(at), box.high = box.high.cwiseMax(at);
    }
  return box;
}

// Triangles of one surface sorted into the columns (in x) of the grid that they may reach. Columns
// and not cells: a bed is long and low, and the few triangles of a column are quickly tested by
// their boxes.
class Columns {
 public:
  Columns(const Surface& surface, double width, double reach) : width_(width) {
    boxes_.reserve(surface.triangles.size());
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      boxes_.push_back(box_of(surface, t));
      const Box& box = boxes_.back();
      // Nodes far from the rank's stones may be unknown here (core/surface.hpp); no stone reaches
      // them.
      if (!box.low.allFinite() || !box.high.allFinite()) continue;
      const std::int64_t first = column(box.low.x() - reach), last = column(box.high.x() + reach);
      if (last - first > long_triangle) {
        everywhere_.push_back(static_cast<int>(t));
        continue;
      }
      for (std::int64_t c = first; c <= last; ++c) members_[c].push_back(static_cast<int>(t));
    }
  }
  // Triangles whose box is within reach, ascending.
  void near(const Vec3& centre, double reach, std::vector<int>& found) const {
    found.clear();
    const auto take = [&](const std::vector<int>& triangles) {
      for (const int t : triangles)
        if (boxes_[static_cast<std::size_t>(t)].overlaps(centre, reach)) found.push_back(t);
    };
    // Ascending: the order in which triangles are examined decides which of two equal ones is
    // taken, and must not depend on the search.
    take(everywhere_);
    const auto here = members_.find(column(centre.x()));
    if (here != members_.end()) take(here->second);
    std::sort(found.begin(), found.end());
  }

 private:
  static constexpr std::int64_t long_triangle = 64;  // columns; longer ones are always tested
  std::int64_t column(double x) const { return static_cast<std::int64_t>(std::floor(x / width_)); }
  double width_;
  std::vector<Box> boxes_;
  std::vector<int> everywhere_;
  std::unordered_map<std::int64_t, std::vector<int>> members_;
};

// Patches of (piece, surface) that were in contact before: the history of a piece with one surface,
// one record for each patch.
void take_history(const std::vector<History>& history, std::int64_t key, int name,
                  std::vector<Approach::Patch>& patches) {
  // `patch_key` falls as the patch number rises: the range of a surface begins with its highest
  // patch.
  const History lowest = history_of_keys(key, patch_key(name, 0x7fffffff));
  for (auto h = std::lower_bound(history.begin(), history.end(), lowest);
       h != history.end() && h->first == key && h->second <= patch_key(name, 0); ++h) {
    const std::int64_t code = -1 - h->second;
    Approach::Patch patch{.patch = static_cast<int>(code & 0xffffffff), .touching = true};
    patch.turn = h->turn, patch.size = h->size, patch.ring = h->ring;
    patch.xi.set(Eigen::Map<const Vec3>(h->xi));
    patch.roll.set(Eigen::Map<const Vec3>(h->roll));
    patches.push_back(patch);
  }
  std::sort(patches.begin(), patches.end(),
            [](const auto& a, const auto& b) { return a.patch < b.patch; });
}

}  // namespace

// All pieces of own particles that may touch a surface before the next rebuild. Local; ghosts are
// left out: their owners compute the contact, and each load is added once.
//
// Cost: one search per particle and surface with the ball around the particle; its pieces are
// examined only if that finds something.
//
// A surface is not repeated across periodic sides. A particle is shifted into the domain and tested
// against the surfaces there, so a surface must extend beyond a periodic side. The shift is added
// to the particle's position and never stored in it: positions stay unwrapped. Lists are rebuilt at
// once when a particle crosses such a side, so that its image does not depend on their age.
void find_approaches(const Scene& scene, const std::vector<Surface*>& surfaces,
                     const std::vector<int>& names, const std::vector<History>& history,
                     std::vector<Approach>& approaches) {
  approaches.clear();
  const State& s = scene.state;
  std::vector<int> found;
  // A corner may be behind the surface by `largest_corner_depth` of the radius; its triangle must
  // still be found.
  const double beyond = scene.shapes.any_stones() ? 1 + largest_corner_depth : 1;
  const auto reach = [&](double radius) { return beyond * radius + scene.skin; };
  double furthest = 0;
  for (std::size_t b = 0; b < s.own; ++b) furthest = std::max(furthest, reach(s.x[b].w));
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    const Columns columns(*surfaces[k], scene.grid.edge().x(), furthest);
    for (std::size_t b = 0; b < s.own; ++b) {
      const Lattice::Image home = scene.grid.locate(s.x[b].vec3());
      const Vec3 shift(home.wrap[0] * scene.grid.period(0), home.wrap[1] * scene.grid.period(1),
                       home.wrap[2] * scene.grid.period(2));
      columns.near(s.x[b].vec3() + shift, reach(s.x[b].w), found);
      if (found.empty()) continue;
      const int law = scene.laws.index(static_cast<int>(s.material[b]), surfaces[k]->material);
      require(law >= 0, "there is a contact law between the materials of a particle and a surface");
      for (std::size_t p = scene.pieces.begin[b]; p < scene.pieces.begin[b + 1]; ++p) {
        const Vec4& x = scene.pieces.x[p];
        columns.near(x.vec3() + shift, reach(x.w), found);
        if (found.empty()) continue;
        // Patches get their history; overlap and normal follow when forces are computed.
        Approach a{static_cast<std::int32_t>(p),
                   static_cast<std::int32_t>(k),
                   shift,
                   found,
                   law,
                   {},
                   {},
                   {}};
        take_history(history, piece_key(s.id[b], p - scene.pieces.begin[b]), names[k], a.patches);
        approaches.push_back(std::move(a));
      }
    }
  }
}

}  // namespace trackbed::dem
