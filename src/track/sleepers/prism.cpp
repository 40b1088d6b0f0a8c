// Sleepers are prisms: mass properties by Green's theorem over the profile, surface by extrusion.
// Exact for any profile without holes, without a closed form for each shape. The density is
// uniform: a real sleeper is heavier under the rails, which matters for its roll only.
#include "track/sleepers/prism.hpp"

namespace trackbed::track {

namespace {

// Integrals over a polygon by Green's theorem, as sums over its edges.
// For an edge from a to b with cross = a x b (m^2):
//   area = sum cross/2,  int x = sum cross (a + b)/6,  int x^2 = sum cross (a^2 + ab + b^2)/12.
// Signs are right for a counter-clockwise profile.
struct Moments {
  double area = 0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();   // of x, z
  Eigen::Vector2d second = Eigen::Vector2d::Zero();  // of x^2, z^2
};

Moments moments_of(const std::vector<Eigen::Vector2d>& polygon) {
  Moments m;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double cross = a.x() * b.y() - b.x() * a.y();
    m.area += cross / 2;
    m.first += cross / 6 * (a + b);
    m.second += cross / 12 * (a.cwiseProduct(a) + a.cwiseProduct(b) + b.cwiseProduct(b));
  }
  return m;
}

}  // namespace

// Principal axes are x, y, z: the profile is symmetric about x = 0, so that its product of inertia
// vanishes. Inertia per mass about y is the sum of both variances; about x and z the length adds
// l^2/12.
Prism bevelled_box(double width, double height, double length, double bevel) {
  const double x = width / 2;
  Prism prism;
  prism.length = length;
  prism.profile = bevel > 0
                      ? std::vector<Eigen::Vector2d>{{bevel - x, 0}, {x - bevel, 0}, {x, bevel},
                                                     {x, height},    {-x, height},   {-x, bevel}}
                      : std::vector<Eigen::Vector2d>{{-x, 0}, {x, 0}, {x, height}, {-x, height}};
  const Moments m = moments_of(prism.profile);
  const Eigen::Vector2d centre(0, m.first.y() / m.area);  // x: by symmetry
  prism.depth = centre.y();
  for (Eigen::Vector2d& point : prism.profile) point -= centre;
  const Eigen::Vector2d square =
      m.second / m.area - centre.cwiseProduct(centre);  // variance of x, z
  const double y_square = length * length / 12;
  prism.gyration = {y_square + square.y(), square.x() + square.y(), square.x() + y_square};
  prism.volume = m.area * length;
  return prism;
}

// Nodes: profile at y = -length/2, then at +length/2. A profile that is counter-clockwise with z up
// is counter-clockwise as seen from -y, so that the face at -y keeps its order.
// The numbering of nodes must not change: loads are stored by node.
Surface surface_of(const Prism& prism) {
  Surface surface;
  const auto n = static_cast<std::int32_t>(prism.profile.size());
  for (const double y : {-prism.length / 2, prism.length / 2})
    for (const Eigen::Vector2d& p : prism.profile) surface.position.emplace_back(p.x(), y, p.y());
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t next = (i + 1) % n;
    surface.triangles.push_back({i, n + i, n + next});
    surface.triangles.push_back({i, n + next, next});
  }
  // A convex profile is a fan about its first corner.
  for (std::int32_t i = 1; i + 1 < n; ++i) {
    surface.triangles.push_back({0, i, i + 1});
    surface.triangles.push_back({n, n + i + 1, n + i});
  }
  surface.motion.assign(surface.nodes(), Vec3::Zero());
  surface.clear_load();
  return surface;
}

}  // namespace trackbed::track
