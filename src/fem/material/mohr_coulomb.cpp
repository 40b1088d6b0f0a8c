// Sets of active planes are tried in a fixed order until one has non-negative multipliers and
// satisfies all planes: the complementarity problem of the return mapping, solved exactly. At most
// 41 systems of three unknowns; the first set nearly always fits.
//
// The planes of s3 over s1 and so on need no test: the return of an ordered stress to a set that is
// symmetric in its axes is ordered, and the edge planes exclude the others.
#include "fem/material/mohr_coulomb.hpp"

#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

namespace trackbed::fem {

namespace {

// Relative to the stresses: a plane violated by less counts as satisfied.
constexpr double held = 1e-12;

// (1 + sin a) / (1 - sin a) of an angle in degrees.
double passive(double angle) {
  const double sine = std::sin(angle * std::numbers::pi / 180);
  return (1 + sine) / (1 - sine);
}

// All sets of one to three of six planes, small sets first.
constexpr std::array<unsigned char, 41> make_sets() {
  std::array<unsigned char, 41> sets{};
  std::size_t count = 0;
  for (int size = 1; size <= 3; ++size)
    for (unsigned set = 1; set < 64; ++set)
      if (std::popcount(set) == size) sets[count++] = static_cast<unsigned char>(set);
  return sets;
}
constexpr auto sets = make_sets();

// In the plane of the track y is a principal axis: one rotation about it, no iteration.
Principal principal_of_plane(const Vec6& s) {
  const double mean = 0.5 * (s(0) + s(2)), half = 0.5 * (s(0) - s(2));
  const double radius = std::sqrt(half * half + s(5) * s(5));
  const double angle = 0.5 * std::atan2(s(5), half);  // of the larger one, from x towards z
  const Vec3 high(std::cos(angle), 0, std::sin(angle)), low(-high.z(), 0, high.x());
  std::array<double, 3> value = {mean + radius, mean - radius, s(1)};
  std::array<Vec3, 3> axis = {high, low, Vec3::UnitY()};
  for (std::size_t k = 2; k > 0 && value[k] > value[k - 1]; --k) {
    std::swap(value[k], value[k - 1]);
    std::swap(axis[k], axis[k - 1]);
  }
  Principal found;
  for (int k = 0; k < 3; ++k) {
    found.value[k] = value[static_cast<std::size_t>(k)];
    found.axes.col(k) = axis[static_cast<std::size_t>(k)];
  }
  return found;
}

}  // namespace

Principal principal(const Vec6& s) {
  if (s(3) == 0 && s(4) == 0) return principal_of_plane(s);
  Mat3 tensor;
  tensor << s(0), s(3), s(5), s(3), s(1), s(4), s(5), s(4), s(2);
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(tensor);  // smallest first
  return {solver.eigenvalues().reverse(), solver.eigenvectors().rowwise().reverse()};
}

MohrCoulomb::MohrCoulomb(const Elastic& solid, const Strength& strength) {
  const double n = passive(strength.friction_angle), m = passive(strength.dilation_angle);
  const double limit = 2 * strength.cohesion * std::sqrt(n), tension = strength.tensile_strength;
  planes_[0] = {{n, 0, -1}, {m, 0, -1}, limit, {}};
  planes_[1] = {{n, -1, 0}, {m, -1, 0}, limit, {}};  // s2 = s3: triaxial extension
  planes_[2] = {{0, n, -1}, {0, m, -1}, limit, {}};  // s1 = s2: triaxial compression
  for (int k = 0; k < 3; ++k)
    planes_[static_cast<std::size_t>(3 + k)] = {Vec3::Unit(k), Vec3::Unit(k), tension, {}};
  const Mat3 stiffness = elasticity(solid).topLeftCorner<3, 3>();
  for (Plane& plane : planes_) plane.back = stiffness * plane.flow;
  // Over the angle between compression and extension, with J the second invariant,
  //   N s1 - s3 = (N - 1) p + 2 sqrt(J/3) [(N + 1/2) cos t + sqrt(3)/2 sin t]
  // is largest where the bracket is sqrt(N^2 + N + 1); s1 is at most p + 2 sqrt(J/3).
  cones_[0] = {limit, n - 1, 4.0 / 3 * (n * n + n + 1)};
  cones_[1] = {tension, 1, 4.0 / 3};
}

double MohrCoulomb::beyond(const Vec3& s) const {
  const double high = s.maxCoeff(), low = s.minCoeff();
  const Plane& main = planes_[0];
  return std::max(main.normal(0) * high - low - main.limit, high - planes_[3].limit);
}

// The margin is the rounding error of the return and of principal values.
bool MohrCoulomb::opens(const Vec6& stress) const {
  const double limit = planes_[3].limit, rounding = 1e-9 * (stress.norm() + std::abs(limit));
  return principal(stress).value[0] >= limit - rounding;
}

// Multipliers x of the set: normal_i (stress - sum_j x_j back_j) = limit_i.
bool MohrCoulomb::try_set(unsigned set, double rounding, Vec3& stress, Vec3& plastic) const {
  std::array<const Plane*, 3> active{};
  int count = 0;
  for (std::size_t k = 0; k < planes_.size(); ++k)
    if ((set >> k & 1) != 0) active[static_cast<std::size_t>(count++)] = &planes_[k];
  Mat3 system = Mat3::Identity();  // rows of inactive planes: 1 x = 0
  Vec3 right = Vec3::Zero();
  double size = 1;
  for (int i = 0; i < count; ++i) {
    const Plane& plane = *active[static_cast<std::size_t>(i)];
    for (int j = 0; j < count; ++j)
      system(i, j) = plane.normal.dot(active[static_cast<std::size_t>(j)]->back);
    right(i) = plane.normal.dot(stress) - plane.limit;
    size *= system(i, i);
  }
  // Without dilation or friction some planes are linearly dependent: a smaller set suffices.
  if (std::abs(system.determinant()) <= 1e-9 * size) return false;
  const Vec3 multiplier = system.inverse() * right;
  if (multiplier.minCoeff() < 0) return false;
  Vec3 returned = stress, flowed = Vec3::Zero();
  for (int i = 0; i < count; ++i) {
    returned -= multiplier(i) * active[static_cast<std::size_t>(i)]->back;
    flowed += multiplier(i) * active[static_cast<std::size_t>(i)]->flow;
  }
  for (const Plane& plane : planes_)
    if (plane.normal.dot(returned) - plane.limit > rounding) return false;
  stress = returned, plastic = flowed;
  return true;
}

// Tangent with the planes of the set active: I - back (normal . back)^-1 normal.
Mat3 MohrCoulomb::principal_slope(unsigned set) const {
  std::array<const Plane*, 3> active{};
  int count = 0;
  for (std::size_t k = 0; k < planes_.size(); ++k)
    if ((set >> k & 1) != 0) active[static_cast<std::size_t>(count++)] = &planes_[k];
  Mat3 system = Mat3::Identity(), back = Mat3::Zero(), normal = Mat3::Zero();
  for (int i = 0; i < count; ++i) {
    normal.row(i) = active[static_cast<std::size_t>(i)]->normal.transpose();
    back.col(i) = active[static_cast<std::size_t>(i)]->back;
  }
  system.topLeftCorner(count, count) = (normal * back).topLeftCorner(count, count);
  return Mat3::Identity() - back * system.inverse() * normal;
}

namespace {

// Derivative of an isotropic function of a tensor: principal values change by `slope`, and a
// rotation of the axes changes the given and the returned tensor in proportion to the differences
// of their principal values (Ogden 1984, Non-linear elastic deformations, section 6.1.4).
Voigt turned_slope(const Mat3& slope, const Principal& trial, const Vec3& returned) {
  // Below this difference two values count as equal, and the limit of the ratio is used.
  const double same = 1e-9 * trial.value.cwiseAbs().maxCoeff();
  Mat3 ratio = Mat3::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double apart = trial.value(i) - trial.value(j);
      ratio(i, j) = std::abs(apart) > same
                        ? (returned(i) - returned(j)) / apart
                        : 0.5 * (slope(i, i) - slope(i, j) + slope(j, j) - slope(j, i));
    }
  Voigt found;
  for (int k = 0; k < 6; ++k) {
    Mat3 unit = Mat3::Zero();
    unit(k % 3, k < 3 ? k : (k + 1) % 3) = unit(k < 3 ? k : (k + 1) % 3, k % 3) = 1;
    const Mat3 given = trial.axes.transpose() * unit * trial.axes;
    Mat3 change = ratio.cwiseProduct(given);
    change.diagonal() = slope * given.diagonal();
    const Mat3 t = trial.axes * change * trial.axes.transpose();
    found.col(k) << t(0, 0), t(1, 1), t(2, 2), t(0, 1), t(1, 2), t(2, 0);
  }
  return found;
}

}  // namespace

bool MohrCoulomb::bring_back(Vec6& stress, Vec6& plastic, Voigt* slope) const {
  Principal trial = principal(stress);
  const double scale = trial.value.cwiseAbs().maxCoeff() * planes_[0].normal(0) + planes_[0].limit;
  if (!(beyond(trial.value) > held * scale)) return false;
  Vec3 flowed = Vec3::Zero(), returned = trial.value;
  unsigned set = 0;
  // Where sets adjoin, rounding may exclude all of them: later passes have larger tolerances.
  bool found = false;
  for (double rounding = 1e-3 * held; !found && rounding < 1; rounding *= 100)
    for (std::size_t k = 0; k < sets.size() && !found; ++k)
      found = try_set(set = sets[k], rounding * scale, returned, flowed);
  const auto turned = [&](const Vec3& value) {
    const Mat3 t = trial.axes * value.asDiagonal() * trial.axes.transpose();
    Vec6 v;
    v << t(0, 0), t(1, 1), t(2, 2), t(0, 1), t(1, 2), t(2, 0);
    return v;
  };
  if (slope != nullptr) *slope = turned_slope(principal_slope(set), trial, returned);
  stress = turned(returned);
  plastic = turned(flowed);
  plastic.tail<3>() *= 2;
  return true;
}

}  // namespace trackbed::fem
