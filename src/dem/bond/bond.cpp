// Forces follow from the present poses alone and not from increments: they neither drift nor depend
// on the time step, and a restart needs no more than the places at which the bond was made.
// Rejected: increments of force in rotated contact planes (Potyondy and Cundall 2004), which a
// closed path does not bring back to zero.
#include "dem/bond/bond.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace trackbed::dem {

namespace {

Vec3 arm_of(const Bond& bond, int side) { return Eigen::Map<const Vec3>(bond.arm[side]); }
Quat axes_of(const Bond& bond, int side) {
  return Quat(Eigen::Map<const Eigen::Vector4d>(bond.axes[side]));
}

// Vector along the axis, rad long.
Vec3 rotation_vector(const Quat& q) {
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2 * q.vec();
  return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

// Of two masses or moments that a spring connects; the other one if one of them is held.
double reduced(double a, double b) {
  if (std::isinf(a)) return b;
  return std::isinf(b) ? a : a * b / (a + b);
}

}  // namespace

BondSection section_of(const Bond& bond, const Domain& domain) {
  const double r = bond.radius;
  if (domain.dimension == Dimension::plane)
    return {2 * r * domain.thickness, 2.0 / 3 * r * r * domain.thickness,
            std::numeric_limits<double>::infinity()};
  constexpr double pi = std::numbers::pi;
  return {pi * r * r, pi / 4 * r * r * r, pi / 2 * r * r * r};
}

BondStiffness stiffness_of(const Bond& bond, const BondParameters& p, const Domain& domain) {
  const BondSection s = section_of(bond, domain);
  const double e = p.young / bond.length, g = p.shear_ratio * e;
  const bool plane = domain.dimension == Dimension::plane;
  return {e * s.area, g * s.area, e * s.bending * bond.radius,
          plane ? 0 : g * s.torsion * bond.radius};
}

Bond make_bond(Id first, Id second, int kind, const BondedBody& i, const BondedBody& j,
               const Vec3& point, const Vec3& normal, double radius) {
  Bond bond{};
  bond.first = first, bond.second = second, bond.kind = kind;
  const Quat axes = Quat::FromTwoVectors(Vec3::UnitX(), normal);
  int side = 0;
  for (const BondedBody* body : {&i, &j}) {
    Eigen::Map<Vec3>(bond.arm[side]) = body->q.conjugate() * Vec3(point - body->x);
    Eigen::Map<Eigen::Vector4d>(bond.axes[side]) = (body->q.conjugate() * axes).coeffs();
    ++side;
  }
  bond.radius = radius, bond.length = (j.x - i.x).norm();
  return bond;
}

BondResponse respond(const Bond& bond, const BondParameters& p, const Domain& domain,
                     const BondedBody& i, const BondedBody& j) {
  const BondStiffness k = stiffness_of(bond, p, domain);
  const Quat axes_i = i.q * axes_of(bond, 0);
  Quat axes_j = j.q * axes_of(bond, 1);
  if (axes_i.dot(axes_j) < 0) axes_j.coeffs() *= -1;
  const Quat axes = Quat(axes_i.coeffs() + axes_j.coeffs()).normalized();
  const Vec3 at_i = i.x + i.q * arm_of(bond, 0), at_j = j.x + j.q * arm_of(bond, 1);
  const Vec3 u = axes.conjugate() * Vec3(at_j - at_i);
  const Vec3 phi = rotation_vector(axes_i.conjugate() * axes_j);
  const double left = 1 - damage(bond.worst, p);
  const Vec3 force = Vec3(k.normal, k.shear, k.shear).cwiseProduct(u);
  const Vec3 moment = Vec3(k.torsion, k.bending, k.bending).cwiseProduct(phi);
  const BondSection section = section_of(bond, domain);
  BondResponse r;
  r.normal = force.x() / section.area + p.moment * moment.tail<2>().norm() / section.bending;
  r.shear =
      force.tail<2>().norm() / section.area + p.moment * std::abs(moment.x()) / section.torsion;
  r.energy = 0.5 * left * (force.dot(u) + moment.dot(phi));
  r.point = 0.5 * (at_i + at_j);
  r.elastic = axes * Vec3(left * force), r.twisting = axes * Vec3(left * moment);
  r.force = r.elastic, r.moment = r.twisting, r.dissipated = 0;
  if (p.damping == 0) return r;
  const Vec3 v = j.v + j.w.cross(r.point - j.x) - i.v - i.w.cross(r.point - i.x);
  const Vec3 spin = axes.conjugate() * Vec3(j.w - i.w), speed = axes.conjugate() * v;
  const double c = 2 * p.damping * left * std::sqrt(reduced(i.mass, j.mass));
  const double c_r = 2 * p.damping * left * std::sqrt(reduced(i.inertia, j.inertia));
  const Vec3 roots(std::sqrt(k.normal), std::sqrt(k.shear), std::sqrt(k.shear));
  const Vec3 turning(std::sqrt(k.torsion), std::sqrt(k.bending), std::sqrt(k.bending));
  const Vec3 damping = c * roots.cwiseProduct(speed);
  const Vec3 against_spin = c_r * turning.cwiseProduct(spin);
  r.force += axes * damping, r.moment += axes * against_spin;
  r.dissipated = damping.dot(speed) + against_spin.dot(spin);
  return r;
}

double utilisation(const BondResponse& r, const BondParameters& p) {
  return std::max(r.normal / p.tension, r.shear / p.shear);
}

bool by_shear(const BondResponse& r, const BondParameters& p) {
  return r.shear / p.shear > r.normal / p.tension;
}

// The force falls linearly with the deformation, from the strength to zero.
double damage(double worst, const BondParameters& p) {
  if (worst <= 1) return 0;
  if (worst >= p.softening) return 1;
  return p.softening / (p.softening - 1) * (1 - 1 / worst);
}

}  // namespace trackbed::dem
