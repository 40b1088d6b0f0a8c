// Floor and walls of a container as triangles: coupling and contacts use triangles only, and
// another kind of wall would need a second implementation of the same contact.
//
// Every wall is a profile (outwards, upwards) swept along a horizontal path: two points for a flat
// wall, a polygon for a cylinder. So one function generates boxes, cylinders, rims of halves and
// boards. Cost: nodes of path times nodes of profile, a few hundred at most. Rejected: a smooth
// cylinder as an analytic shape, since the distance of polyhedra is computed to triangles only.
// Walls of a box that never move are plain rectangles.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "plate.hpp"
#include "trackbed/bed/bed.hpp"

namespace trackbed::bed {

namespace {

// m: exceeds the depth (half a stone) behind a surface at which a contact is lost.
constexpr double board = 0.05;
// m: boards end this far below the floor, so that their lower face touches no stone on it.
constexpr double below_floor = 0.01;

// Nodes of a wall at z = 0, with the stones on the left of the path; `outward` is the step at a
// node that displaces the wall by 1 m away from them.
struct Path {
  std::vector<Vec3> at, outward;  // m, -
  bool closed = false;
};

// The section of a wall: distance outwards and height, m, from the top down on the side of the
// stones.
using Profile = std::vector<std::array<double, 2>>;

// Two triangles for each piece of path and profile. The direction along the path, then down the
// profile: the normal is to the left of the path, towards the stones.
Surface wall(const std::string& name, int material, const Path& path, const Profile& profile) {
  Surface surface;
  surface.name = name;
  surface.material = material;
  for (std::size_t i = 0; i < path.at.size(); ++i)
    for (const auto& [out, up] : profile)
      surface.position.push_back(path.at[i] + out * path.outward[i] + Vec3(0, 0, up));
  const std::size_t rows = profile.size(), ends = path.at.size();
  const auto node = [&](std::size_t i, std::size_t k) {
    return static_cast<std::int32_t>((i % ends) * rows + k);
  };
  for (std::size_t i = 0; i + (path.closed ? 0 : 1) < ends; ++i)
    for (std::size_t k = 0; k + 1 < rows; ++k) {
      surface.triangles.push_back({node(i, k), node(i + 1, k), node(i + 1, k + 1)});
      surface.triangles.push_back({node(i, k), node(i + 1, k + 1), node(i, k + 1)});
    }
  surface.motion.assign(surface.nodes(), Vec3::Zero());
  surface.clear_load();
  return surface;
}

// Anticlockwise seen from above, so the stones are on the left. At a corner of the polygon the
// outward step is longer, so that outer faces are parallel to the inner ones.
Path around(const Container& c) {
  Path path;
  path.closed = true;
  const double half = std::numbers::pi / facets;
  for (int k = 0; k < facets; ++k) {
    const double turn = 2 * half * k;
    const Vec3 out(std::cos(turn), std::sin(turn), 0);
    path.at.push_back(c.centre() + c.radius() * out);
    path.outward.push_back(out / std::cos(half));
  }
  return path;
}

struct NamedPath {
  std::string name;
  Path path;
};

// The sides of a box that are not periodic, each longer than the bed by `past` at both ends.
std::vector<NamedPath> sides(const Container& c, double past) {
  const Footprint inside{c.low, c.high}, outside = inside.grown(past);
  const Vec3 &a = outside.low, &b = outside.high;
  const auto straight = [](const Vec3& from, const Vec3& to, const Vec3& out) {
    return Path{.at = {from, to}, .outward = {out, out}};
  };
  const double left = c.low.x(), right = c.high.x(), front = c.low.y(), back = c.high.y();
  std::vector<NamedPath> all;
  if (!c.periodic[0]) {
    all.push_back(
        {"wall.left", straight(Vec3(left, b.y(), 0), Vec3(left, a.y(), 0), -Vec3::UnitX())});
    all.push_back(
        {"wall.right", straight(Vec3(right, a.y(), 0), Vec3(right, b.y(), 0), Vec3::UnitX())});
  }
  if (c.dimension == Dimension::space && !c.periodic[1]) {
    all.push_back(
        {"wall.front", straight(Vec3(a.x(), front, 0), Vec3(b.x(), front, 0), -Vec3::UnitY())});
    all.push_back(
        {"wall.back", straight(Vec3(b.x(), back, 0), Vec3(a.x(), back, 0), Vec3::UnitY())});
  }
  return all;
}

// The rim of a half begins at the division and extends outwards: below the upper half, above the
// lower one.
void add_halves(std::vector<Surface>& all, const NamedPath& side, const Container& c, double height,
                int material, double foot) {
  const double rim = c.beside + beyond;
  all.push_back(
      wall(side.name + ".lower", material, side.path, {{rim, c.split}, {0, c.split}, {0, foot}}));
  all.push_back(wall(side.name + ".upper", material, side.path,
                     {{0, std::max(height, c.split + beyond)}, {0, c.split}, {rim, c.split}}));
}

}  // namespace

// Counter-clockwise seen from the side of the stones, to which normals point.
Surface plate(const std::string& name, int material, const Vec3& corner, const Vec3& first,
              const Vec3& second) {
  Surface surface;
  surface.name = name;
  surface.material = material;
  surface.position = {corner, corner + first, corner + first + second, corner + second};
  surface.triangles = {{0, 1, 2}, {0, 2, 3}};
  surface.motion.assign(surface.nodes(), Vec3::Zero());
  surface.clear_load();
  return surface;
}

// A plane model is centred on y = 0.
Container::Container(const dem::Domain& domain)
    : dimension(domain.dimension),
      periodic{domain.periodic[0], domain.periodic[1]},
      depth(std::max(-domain.low.z(), beyond)) {
  const bool plane = dimension == Dimension::plane;
  const double half = domain.thickness / 2;
  low = {domain.low.x(), plane ? -half : domain.low.y(), 0};
  high = {domain.high.x(), plane ? half : domain.high.y(), 0};
}

Vec3 Container::centre() const { return (low + high) / 2; }
double Container::radius() const { return (high.x() - low.x()) / 2; }
double Container::clear_radius() const { return radius() * std::cos(std::numbers::pi / facets); }

// A polygon of n triangles: A = n/2 r^2 sin(2 pi/n).
double Container::area() const {
  if (kind == ContainerKind::box) return Footprint{low, high}.area();
  return facets / 2.0 * radius() * radius() * std::sin(2 * std::numbers::pi / facets);
}

namespace {

// Up to `height`, m, with the foot below the ground; they extend beyond the bed on all sides.
void add_rectangles(std::vector<Surface>& all, const Container& c, double height, int material) {
  const Footprint inside{c.low, c.high}, outside = inside.grown(beyond);
  const Vec3 size = outside.high - outside.low;
  const Vec3 along(size.x(), 0, 0), across(0, size.y(), 0);
  const Vec3 down(0, 0, -c.depth), up(0, 0, height + c.depth);
  if (!c.periodic[0]) {
    const Vec3 left(inside.low.x(), outside.low.y(), 0), right(inside.high.x(), outside.low.y(), 0);
    all.push_back(plate("wall.left", material, left + down, across, up));    // normal +x
    all.push_back(plate("wall.right", material, right + down, up, across));  // normal -x
  }
  if (c.dimension == Dimension::space && !c.periodic[1]) {
    const Vec3 front(outside.low.x(), inside.low.y(), 0), back(outside.low.x(), inside.high.y(), 0);
    all.push_back(plate("wall.front", material, front + down, up, along));  // normal +y
    all.push_back(plate("wall.back", material, back + down, along, up));    // normal -y
  }
}

// Halves, boards, or the plain wall of a cylinder.
void add_profiles(std::vector<Surface>& all, const Container& c, double height, int material) {
  const bool halves = c.split > 0, boards = !halves && c.beside > 0;
  const double foot = boards ? -below_floor : -c.depth;
  Profile plain{{0, height}, {0, foot}};
  if (boards) plain.insert(plain.end(), {{board, foot}, {board, height}});
  const double past = boards ? board : beyond + c.beside;
  const auto paths = c.kind == ContainerKind::cylinder
                         ? std::vector<NamedPath>{{"wall.cylinder", around(c)}}
                         : sides(c, past);
  for (const NamedPath& side : paths)
    if (halves)
      add_halves(all, side, c, height, material, foot);
    else
      all.push_back(wall(side.name, material, side.path, plain));
}

}  // namespace

// Names are used in checkpoints. Walls extend down to the end of the domain, since the ground below
// may settle. Boards end just below the floor, so that they clear it as soon as they are lifted.
std::vector<Surface> walls(const Container& container, double height, int material, bool floor) {
  std::vector<Surface> all;
  if (floor) {
    const Footprint inside{container.low, container.high};
    const Footprint reach = inside.grown(beyond + container.beside);
    const Vec3 size = reach.high - reach.low;
    all.push_back(plate("floor", material, reach.low, Vec3(size.x(), 0, 0), Vec3(0, size.y(), 0)));
  }
  const bool plain =
      container.kind == ContainerKind::box && container.split <= 0 && container.beside <= 0;
  if (plain)
    add_rectangles(all, container, height, material);
  else
    add_profiles(all, container, height, material);
  return all;
}

}  // namespace trackbed::bed
