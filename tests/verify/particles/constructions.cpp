#include "constructions.hpp"

#include <algorithm>
#include <cmath>

namespace trackbed::study {

Body::Body(const dem::Template& shape, const dem::NewParticle& p, double density)
    : core(dem::core_of(shape.pieces[0])),
      faces(shape.pieces[0].core.faces),
      scale(p.scale),
      mass(density * shape.volume * scale * scale * scale),
      inertia(mass * scale * scale * shape.gyration),
      x(p.position),
      v(p.velocity),
      q(p.attitude),
      corners(core.corners.size()) {
  l = q * Vec3((q.conjugate() * p.spin).cwiseProduct(inertia));
  place();
}

void Body::place() {
  const Mat3 turn = scale * q.toRotationMatrix();
  for (std::size_t k = 0; k < corners.size(); ++k) corners[k].set(turn * core.corners[k].vec3());
}

void Body::kick(const Vec3& force, const Vec3& torque, double dt) {
  v += dt / mass * force;
  l += dt * torque;
}

// Rotations about the principal axes one after the other, as in src/dem/particles/step.cpp.
void Body::drift(double dt) {
  x += dt * v;
  Vec3 body = q.conjugate() * l;
  for (const auto& [axis, fraction] : {std::pair(0, 0.5), {1, 0.5}, {2, 1.0}, {1, 0.5}, {0, 0.5}}) {
    const Quat step(
        Eigen::AngleAxisd(fraction * dt * body[axis] / inertia[axis], Vec3::Unit(axis)));
    q = q * step;
    body = step.conjugate() * body;
  }
  q.normalize();
  place();
}

double Body::kinetic() const {
  const Vec3 body = q.conjugate() * l;
  return 0.5 * mass * v.squaredNorm() + 0.5 * body.cwiseAbs2().cwiseQuotient(inertia).sum();
}

namespace {

dem::Vec4 at(const dem::Placed& core, std::size_t c) {
  const Vec3 p = core.corner(c);
  return {p.x(), p.y(), p.z(), 0};
}

void keep(const dem::FeatureRow& row, std::size_t slot, double reach, std::vector<Feature>& found) {
  const double delta = reach - row.distance(slot);
  if (!(delta > 0)) return;
  const dem::FeatureGroup& g = row.group(slot);
  const std::size_t k = slot % dem::lanes;
  const auto over_weight = [&](const dem::Lanes3& v) {
    return Vec3(Vec3(v.x[k], v.y[k], v.z[k]) / g.weight[k]);
  };
  found.push_back({delta, over_weight(g.normal), over_weight(g.point)});
}

void corner_features(const dem::Placed& i, const dem::Placed& j, bool of_i,
                     std::vector<Feature>& found) {
  const dem::Placed &own = of_i ? i : j, &other = of_i ? j : i;
  const std::size_t triangles = other.core->triangles.size();
  dem::FeatureRow row;
  for (std::size_t c = 0; c < own.corners.size(); ++c)
    for (const auto& t : other.core->triangles)
      row.add(of_i ? 1 : -1, i.radius, j.radius,
              {at(own, c), at(other, t[0]), at(other, t[1]), at(other, t[2])});
  row.compute_corners();
  for (std::size_t c = 0; c < own.corners.size(); ++c) {
    std::size_t best = c * triangles;
    for (std::size_t t = c * triangles; t < (c + 1) * triangles; ++t)
      if (row.distance(t) < row.distance(best)) best = t;
    keep(row, best, i.radius + j.radius, found);
  }
}

}  // namespace

void all_features(const Body& a, const Body& b, std::vector<Feature>& found) {
  const dem::Placed i = a.placed(a.x), j = b.placed(a.x);
  found.clear();
  corner_features(i, j, true, found), corner_features(i, j, false, found);
  dem::FeatureRow row;
  for (const auto& e : i.core->edges)
    for (const auto& f : j.core->edges)
      row.add(1, i.radius, j.radius, {at(i, e[0]), at(i, e[1]), at(j, f[0]), at(j, f[1])});
  row.compute_edges();
  for (std::size_t s = 0; s < row.size(); ++s) keep(row, s, i.radius + j.radius, found);
}

namespace {

// The face whose normal is closest to `direction` (corner positions from the origin of `i`, m).
struct FacePolygon {
  Vec3 normal = Vec3::Zero();
  double along = -2;
  std::vector<Vec3> corners;
};

FacePolygon facing(const Body& body, const dem::Placed& placed, const Vec3& direction) {
  const Vec3 local = body.q.conjugate() * direction;
  const geom::Face* best = &body.faces[0];
  for (const geom::Face& f : body.faces)
    if (f.normal.dot(local) > best->normal.dot(local)) best = &f;
  FacePolygon polygon{body.q * best->normal, best->normal.dot(local), {}};
  for (const int c : best->vertices)
    polygon.corners.push_back(placed.corner(static_cast<std::size_t>(c)));
  return polygon;
}

// Part of the polygon behind the plane through `on` with this outward normal.
std::vector<Vec3> cut(const std::vector<Vec3>& polygon, const Vec3& on, const Vec3& outward) {
  std::vector<Vec3> kept;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    const double da = outward.dot(a - on), db = outward.dot(b - on);
    if (da <= 0) kept.push_back(a);
    if ((da < 0) != (db < 0) && da != db) kept.push_back(a + da / (da - db) * (b - a));
  }
  return kept;
}

// Four points with the largest extent: the deepest, the farthest from it, and the farthest on
// either side.
void reduce(std::vector<Feature>& found) {
  if (found.size() <= 4) return;
  const auto best = [&](auto measure) {
    std::size_t at = 0;
    for (std::size_t k = 1; k < found.size(); ++k)
      if (measure(found[k]) > measure(found[at])) at = k;
    return at;
  };
  const std::size_t a = best([](const Feature& f) { return f.delta; });
  const std::size_t b = best([&](const Feature& f) { return (f.x - found[a].x).norm(); });
  const Vec3 side = (found[b].x - found[a].x).cross(found[a].n);
  const std::size_t c = best([&](const Feature& f) { return side.dot(f.x - found[a].x); });
  const std::size_t d = best([&](const Feature& f) { return -side.dot(f.x - found[a].x); });
  std::vector<std::size_t> chosen{a, b, c, d};
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  std::vector<Feature> kept;
  for (const std::size_t k : chosen) kept.push_back(found[k]);
  found = kept;
}

void closest_only(std::vector<Feature>& found) {
  if (found.size() < 2) return;
  found = {*std::max_element(found.begin(), found.end(),
                             [](const Feature& a, const Feature& b) { return a.delta < b.delta; })};
}

}  // namespace

void clipped_manifold(const Body& a, const Body& b, Memory& memory, std::vector<Feature>& found) {
  constexpr double face_contact = 0.98;  // cosine of 11 degrees: normal along a face's
  const dem::Placed i = a.placed(a.x), j = b.placed(a.x);
  const double reach = i.radius + j.radius;
  found.clear();
  const dem::Slab slab = dem::widest_slab(i, j, memory.normal, 1e-9 * reach);
  memory.normal = slab.normal;
  if (slab.width > reach) return;
  const FacePolygon of_i = facing(a, i, slab.normal), of_j = facing(b, j, -slab.normal);
  if (std::max(of_i.along, of_j.along) > face_contact) {
    const bool first = of_i.along >= of_j.along;
    const FacePolygon &reference = first ? of_i : of_j, &incident = first ? of_j : of_i;
    std::vector<Vec3> points = incident.corners;
    for (std::size_t k = 0; k < reference.corners.size(); ++k) {
      const Vec3& on = reference.corners[k];
      const Vec3 side = reference.corners[(k + 1) % reference.corners.size()] - on;
      points = cut(points, on, side.cross(reference.normal));
    }
    const Vec3 n = first ? reference.normal : Vec3(-reference.normal);
    for (const Vec3& p : points) {
      const double above = reference.normal.dot(p - reference.corners[0]);
      if (above < reach) found.push_back({reach - above, n, p - 0.5 * above * reference.normal});
    }
    reduce(found);
  }
  if (!found.empty()) return;
  all_features(a, b, found);
  closest_only(found);
}

namespace {

Response smooth_maximum(const Body& i, const Body& j, double k, double p) {
  thread_local std::vector<Feature> found;
  all_features(i, j, found);
  double sum = 0;
  for (const Feature& f : found) sum += std::pow(f.delta, p);
  const double largest = std::pow(sum, 1 / p);
  Response response;
  for (const Feature& f : found)
    response.add(-k * largest * std::pow(f.delta / largest, p - 1) * f.n, f.x, j.x - i.x);
  return response;
}

Response each(const std::vector<Feature>& found, const Body& i, const Body& j, double k) {
  Response response;
  for (const Feature& f : found) response.add(-k * f.delta * f.n, f.x, j.x - i.x);
  return response;
}

}  // namespace

std::vector<NamedConstruction> constructions() {
  const auto smooth = [](double p) {
    return
        [p](const Body& i, const Body& j, double k, Memory&) { return smooth_maximum(i, j, k, p); };
  };
  const auto single = [](const Body& i, const Body& j, double k, Memory&) {
    thread_local std::vector<Feature> found;
    all_features(i, j, found);
    closest_only(found);
    return each(found, i, j, k);
  };
  const auto clipped = [](const Body& i, const Body& j, double k, Memory& memory) {
    thread_local std::vector<Feature> found;
    clipped_manifold(i, j, memory, found);
    return each(found, i, j, k);
  };
  const auto sum = [](const Body& i, const Body& j, double k, Memory&) {
    thread_local std::vector<Feature> found;
    all_features(i, j, found);
    return each(found, i, j, k);
  };
  return {{"smooth maximum, p = 6", smooth(6)},   {"smooth maximum, p = 4", smooth(4)},
          {"smooth maximum, p = 16", smooth(16)}, {"single closest point", single},
          {"clipped manifold", clipped},          {"sum of all features", sum}};
}

}  // namespace trackbed::study
