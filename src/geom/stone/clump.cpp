// Spheres that fill a mesh or a rounded convex piece.
//
// Centres are tried on a grid; for each, the largest sphere inside the body is known. The next
// sphere is the one with most grid points that are in no other sphere (greedy cover, within 1 - 1/e
// of the best choice of as many); since that number only falls, few have to be counted again each
// time.
//
// Bound of the greedy cover: Nemhauser, Wolsey, Fisher 1978, doi:10.1007/BF01588971; counting
// lazily: Minoux 1978, doi:10.1007/BFb0006528.
#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>
#include <queue>
#include <stdexcept>

#include "geom/convex/hull.hpp"
#include "trackbed/geom/mesh.hpp"

namespace trackbed::geom {

namespace {

// Cell centres of the box around a body, x running fastest. Cost: a distance per point, 64000 for a
// cube; a sphere of radius r costs r^2 rows in units of the spacing to count.
class Grid {
 public:
  // `body`: a mesh or a piece; `corners`, widened by `margin`, span its box.
  Grid(const auto& body, const std::vector<Vec3>& corners, double margin) {
    low_ = high_ = corners[0];
    for (const Vec3& p : corners) low_ = low_.cwiseMin(p), high_ = high_.cwiseMax(p);
    low_ -= Vec3::Constant(margin), high_ += Vec3::Constant(margin);
    spacing_ = (high_ - low_).maxCoeff() / cells;
    for (int k = 0; k < 3; ++k)
      count_[k] = std::max(1, static_cast<int>(std::ceil((high_ - low_)[k] / spacing_)));
    std::vector<Vec3> points;
    for (int i = 0; i < count_.prod(); ++i) points.push_back(at(i));
    depth_ = depths(body, points);
    free_before_.resize(points.size() / static_cast<std::size_t>(count_[0]) *
                        static_cast<std::size_t>(count_[0] + 1));
    for (int c = 0; c < count_[2]; ++c)
      for (int b = 0; b < count_[1]; ++b)
        for (int a = 0; a < count_[0]; ++a)
          row(b, c)[a + 1] = row(b, c)[a] + (depth(at(a, b, c)) > 0);
  }
  int size() const { return static_cast<int>(depth_.size()); }
  Vec3 at(int i) const {
    const Eigen::Vector3d cell(i % count_[0], i / count_[0] % count_[1], i / count_[0] / count_[1]);
    const Vec3 margin = (high_ - low_ - spacing_ * count_.cast<double>()) / 2;
    return low_ + margin + spacing_ * (cell + Vec3::Constant(0.5));
  }
  double depth(int i) const { return depth_[static_cast<std::size_t>(i)]; }
  // A bound of the number of grid points in the sphere around point i: their cells, of volume 1,
  // reach half a diagonal farther.
  int most_around(int i) const {
    const double reach = depth(i) / spacing_ + std::sqrt(3.0) / 2;
    return static_cast<int>(4 * std::numbers::pi / 3 * reach * reach * reach);
  }
  // Free grid points in the sphere around point i; marks them as used if `take`.
  int free_around(int i, bool take) {
    const double reach = depth(i) / spacing_;
    const int n = static_cast<int>(reach), x = i % count_[0], y = i / count_[0] % count_[1],
              z = i / count_[0] / count_[1];
    int found = 0;
    for (int c = std::max(0, z - n); c <= std::min(count_[2] - 1, z + n); ++c)
      for (int b = std::max(0, y - n); b <= std::min(count_[1] - 1, y + n); ++b) {
        const double square = reach * reach - (b - y) * (b - y) - (c - z) * (c - z);
        if (square < 0) continue;
        const int half = static_cast<int>(std::sqrt(square));
        const int first = std::max(0, x - half), end = std::min(count_[0], x + half + 1);
        int* before = row(b, c);
        const int here = before[end] - before[first];
        found += here;
        if (!take || here == 0) continue;
        for (int a = first; a < end; ++a) before[a] = before[first];
        for (int a = end; a <= count_[0]; ++a) before[a] -= here;
      }
    return found;
  }

 private:
  static constexpr int cells = 40;  // along the longest side
  int at(int a, int b, int c) const { return a + count_[0] * (b + count_[1] * c); }
  // Per row along x, the number of free points before each point, and that of all of them.
  int* row(int b, int c) {
    return &free_before_[static_cast<std::size_t>((count_[0] + 1) * (b + count_[1] * c))];
  }
  Vec3 low_, high_;
  double spacing_ = 0;
  Eigen::Vector3i count_;
  std::vector<double> depth_;
  std::vector<int> free_before_;
};

// The queue holds the gain of each point when it was last counted, at first a bound. Gains only
// fall, so a point whose new count is still the largest in the queue is the best of all.
std::vector<Sphere> inner_spheres(Grid grid, int wanted) {
  std::priority_queue<std::pair<int, int>> gains;  // upper bound, grid point
  for (int i = 0; i < grid.size(); ++i)
    if (grid.depth(i) > 0) gains.push({grid.most_around(i), i});
  std::vector<Sphere> spheres;
  while (static_cast<int>(spheres.size()) < wanted && !gains.empty()) {
    const int i = gains.top().second;
    gains.pop();
    const int gain = grid.free_around(i, false);
    if (gain == 0) continue;
    if (!gains.empty() && gain < gains.top().first) {
      gains.push({gain, i});
      continue;
    }
    grid.free_around(i, true);
    spheres.push_back({grid.at(i), grid.depth(i)});
  }
  return spheres;
}

std::vector<Sphere> grown(std::vector<Sphere> spheres, double by) {
  for (Sphere& s : spheres) s.radius += by;
  return spheres;
}

// All radii are increased by the same amount, such that the union has the volume of the body. The
// volume grows with the radii, so a root is bracketed. Spheres then extend beyond the body about as
// far as the body extends beyond them: mean error near 0.
std::vector<Sphere> filled(const std::vector<Sphere>& spheres, double volume, double extent) {
  if (spheres.empty())
    throw std::invalid_argument(
        "the stone is too thin to be filled with spheres; use convex pieces instead");
  constexpr int cells = 128;
  constexpr int bits = 30;  // of the growth, far beyond the 1e-4 to which the volume is accurate
  const auto missing = [&](double by) { return volume - union_volume(grown(spheres, by), cells); };
  const double most = extent / 4, at_none = missing(0), at_most = missing(most);
  if (at_none <= 0) return spheres;
  if (at_most >= 0) return grown(spheres, most);
  std::uintmax_t steps = 60;
  const auto [low, high] = boost::math::tools::toms748_solve(
      missing, 0.0, most, at_none, at_most, boost::math::tools::eps_tolerance<double>(bits), steps);
  return grown(spheres, (low + high) / 2);
}

// Distances of evenly spread points of the surface from the union. Inside the union the depth in
// the nearest sphere, which is no more than the distance.
void measure(const Mesh& mesh, Clump& clump) {
  // Each triangle is divided into n^2 equal ones: the centres of those with the orientation of the
  // triangle are the samples. They have equal weights, which add up to the area of the triangle.
  const double step = extent_of(mesh.vertices) / 100;
  double total = 0, sum = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3 &a = mesh.vertices[static_cast<std::size_t>(i)],
               &b = mesh.vertices[static_cast<std::size_t>(j)],
               &c = mesh.vertices[static_cast<std::size_t>(k)];
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int n = std::max(1, static_cast<int>(std::ceil(longest / step)));
    const double area = (b - a).cross(c - a).norm() / (n * (n + 1));
    for (int p = 0; p < n; ++p)
      for (int q = 0; p + q < n; ++q) {
        const Vec3 x = a + (b - a) * (p + 1.0 / 3) / n + (c - a) * (q + 1.0 / 3) / n;
        double distance = (x - clump.spheres[0].centre).norm() - clump.spheres[0].radius;
        for (const Sphere& s : clump.spheres)
          distance = std::min(distance, (x - s.centre).norm() - s.radius);
        total += area;
        sum += area * std::abs(distance);
        clump.surface_furthest = std::max(clump.surface_furthest, std::abs(distance));
      }
  }
  clump.surface_error = sum / total;
}

}  // namespace

std::vector<Sphere> spheres_filling(const Piece& piece, int spheres) {
  const std::vector<Vec3>& corners = piece.core.vertices;
  return filled(inner_spheres(Grid(piece, corners, piece.radius), spheres),
                piece_solid(piece).volume, extent_of(corners) + 2 * piece.radius);
}

Clump clump(const Mesh& mesh, int spheres) {
  const double volume = mesh_solid(mesh).volume;
  Clump result;
  result.spheres = filled(inner_spheres(Grid(mesh, mesh.vertices, 0), spheres), volume,
                          extent_of(mesh.vertices));
  result.volume_error = union_solid(result.spheres, 192).volume / volume - 1;
  measure(mesh, result);
  return result;
}

}  // namespace trackbed::geom
