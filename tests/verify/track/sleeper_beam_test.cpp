// A single bending sleeper: free, and on a Winkler bed with and without ballast below its middle.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>
#include <set>

#include "support/verified.hpp"
#include "trackbed/core/decompositions.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::sleeper_beam_test {
namespace {

// Properties of a sleeper as a beam.
struct Bar {
  explicit Bar(const TrackParameters& t)
      : length(t.sleeper_length),
        area(t.sleeper.width * t.sleeper.height),
        stiffness(t.sleeper.young * area * t.sleeper.height * t.sleeper.height / 12),
        mass(t.sleeper_mass / length) {}
  double length, area, stiffness, mass;  // m, m^2, N m^2, kg/m
};

// Two sleepers with very soft pads.
Line loose(const TrackParameters& t, double unsupported = 0) {
  LineParameters p;
  p.track = t;
  p.track.sleeper.unsupported = unsupported;
  p.track.length = 0.6, p.track.elements = 1, p.track.run_in = 0;
  p.pad.stiffness = 1e-3, p.pad.damping = 0;
  return Line(p);
}

// Unknowns of the first sleeper.
std::vector<Eigen::Index> own_unknowns(const Line& line, double length) {
  std::set<Eigen::Index> found;
  for (int k = 0; k <= 1000; ++k)
    for (const std::int32_t unknown : line.sleeper_at(0, length * (k / 1000.0 - 0.5)).unknown)
      if (unknown >= 0) found.insert(unknown);
  return {found.begin(), found.end()};
}

// Hz, in ascending order, without the two rigid body modes.
std::vector<double> frequencies(const TrackParameters& t) {
  LineParameters p;
  p.track = t;
  p.track.length = 0.6, p.track.elements = 1, p.track.run_in = 0;
  p.track.zones = {{.from = -1, .to = 2, .bed = 0}};
  p.pad.stiffness = 1e-3;
  const Line line(p);
  const auto own = own_unknowns(line, t.sleeper_length);
  const Eigen::MatrixXd k = Eigen::MatrixXd(line.system().stiffness)(own, own);
  const Eigen::MatrixXd m = Eigen::MatrixXd(line.system().mass)(own, own);
  const Eigen::VectorXd squared = generalised_eigenvalues(k, m);
  std::vector<double> found;
  for (Eigen::Index n = 2; n < squared.size(); ++n)
    found.push_back(std::sqrt(squared[n]) / (2 * std::numbers::pi));
  return found;
}

// cos(b L) cosh(b L) = 1,  f = (b L)^2/(2 pi L^2) sqrt(E I/m).
TEST(FreeSleeper, HasTheBendingFrequenciesOfAFreeBar) {
  const Bar bar(bending(12));
  const std::vector<double> coarse = frequencies(bending(6)), fine = frequencies(bending(12)),
                            finest = frequencies(bending(24));
  // b = root/L; the square of the frequency is too high by (b h)^4/720.
  const verified::Tolerance mesh{1.5 / 1440,
                                 "cubic elements: (b h)^4 / 1440, one and a half times"};
  const verified::Tolerance order{0.2,
                                  "fourth order; next term (b h)^2 / 9 = 0.13 at the coarsest"};
  const std::array roots{4.730040744862704, 7.853204624095838, 10.995607838001671};
  for (std::size_t n = 0; n < roots.size(); ++n) {
    const double exact = roots[n] * roots[n] / (2 * std::numbers::pi * bar.length * bar.length) *
                         std::sqrt(bar.stiffness / bar.mass);
    verified::near(fmt::format("frequency {}, 20 elements", n + 1), "Hz", fine[n], exact,
                   mesh.of(std::pow(roots[n] / 20, 4) * exact));
    verified::near(fmt::format("order in element length, frequency {}", n + 1), "-",
                   std::log2((coarse[n] - exact) / (fine[n] - exact)), 4, order);
    verified::near(fmt::format("order in element length, 20 and 40 elements, frequency {}", n + 1),
                   "-", std::log2((fine[n] - exact) / (finest[n] - exact)), 4, order);
  }
}

// Timoshenko: w = sum A_j cosh(k_j s), psi = sum c_j A_j sinh(k_j s) for modes that are even about
// the middle (odd: cosh and sinh exchanged), s from the middle, with
//   (S k^2 + m w^2)(E I k^2 - S + r w^2) + S^2 k^2 = 0,   c = (S k^2 + m w^2)/(S k),
// S = k G A, N; r = rho I, kg m. No moment E I psi' and no shear S (w' - psi) at s = L/2: a
// determinant, real or imaginary, that is zero at the frequencies.
double determinant(const TrackParameters& t, double frequency, bool even) {
  using Complex = std::complex<double>;
  const Bar bar(t);
  const double shear = 5.0 / 6 * t.sleeper.young / (2 * (1 + t.sleeper.poisson)) * bar.area;
  const double rotary = bar.mass * t.sleeper.height * t.sleeper.height / 12;
  const double square = std::pow(2 * std::numbers::pi * frequency, 2);
  const double a = shear * bar.stiffness;
  const double b = shear * rotary * square + bar.mass * square * bar.stiffness;
  const double c = bar.mass * square * (rotary * square - shear);
  const double root = std::sqrt(b * b - 4 * a * c);
  std::array<Complex, 2> moment, force;
  for (std::size_t j = 0; j < 2; ++j) {
    const Complex k = std::sqrt(Complex((-b + (j == 0 ? root : -root)) / (2 * a)));
    const Complex turn = (shear * k * k + bar.mass * square) / (shear * k);
    const Complex like = std::cosh(k * bar.length / 2.0), other = std::sinh(k * bar.length / 2.0);
    moment[j] = turn * k * (even ? like : other);
    force[j] = (k - turn) * (even ? other : like);
  }
  const Complex d = moment[0] * force[1] - moment[1] * force[0];
  return d.real() + d.imag();
}

// By bisection within 5 % of the computed frequency.
double exact_frequency(const TrackParameters& t, double near, bool even) {
  double low = 0.95 * near, high = 1.05 * near;
  EXPECT_LT(determinant(t, low, even) * determinant(t, high, even), 0);
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (determinant(t, low, even) * determinant(t, middle, even) <= 0 ? high : low) = middle;
  }
  return low;
}

TEST(FreeSleeper, HasTheFrequenciesOfATimoshenkoBeam) {
  const auto coarse = frequencies(bending(6, BeamTheory::timoshenko)),
             fine = frequencies(bending(12, BeamTheory::timoshenko)),
             finest = frequencies(bending(24, BeamTheory::timoshenko));
  const Bar bar(bending(12));
  // Shear and rotary inertia lower the frequency by about r = 0.33 (b H)^2/2, b that of a thin bar:
  // of this part elements miss (b h)^2/12.
  const verified::Tolerance mesh{1.0 / 24,
                                 "second order in shear: 0.33 (b H)^2 / 2 times (b h)^2 / 12"};
  const verified::Tolerance order{0.1, "second order; the fourth order of bending adds up to 0.1"};
  const double height = bending(12).sleeper.height;
  for (std::size_t n = 0; n < 3; ++n) {
    const double b = (n + 1.5) * std::numbers::pi / bar.length, size = bar.length / 20;
    const double exact = exact_frequency(bending(12, BeamTheory::timoshenko), fine[n], n % 2 == 0);
    verified::near(fmt::format("frequency {}, 20 elements", n + 1), "Hz", fine[n], exact,
                   mesh.of(0.33 * std::pow(b * height * b * size, 2) * exact));
    verified::near(fmt::format("order in element length, frequency {}", n + 1), "-",
                   std::log2((coarse[n] - exact) / (fine[n] - exact)), 2, order);
    verified::near(fmt::format("order in element length, 20 and 40 elements, frequency {}", n + 1),
                   "-", std::log2((fine[n] - exact) / (finest[n] - exact)), 2, order);
  }
}

// Elements between the rails. The error of deflections is about (b h)^4/200, b = 1.2/m on this bed.
constexpr std::int64_t finest = 24;
const verified::Tolerance fourth{0.2, "fourth order; next term (b h)^2 = 0.09 at the coarsest"};

// Static displacements under P downwards at each of `at` (m from the middle).
Vector loaded(const Line& line, const std::vector<double>& at, double force) {
  Vector load = Vector::Zero(line.system().mass.rows());
  for (const double y : at) line.sleeper_at(0, y).add(-force, load);
  return Statics(line.system()).flexibility(load);
}

// Finite beam with free ends, P at the middle (Hetenyi 1946, Beams on elastic foundation):
//   w = P b/(2 k) (cosh bL + cos bL + 2)/(sinh bL + sin bL),
//   M = P/(4 b) (cosh bL - cos bL)/(sinh bL + sin bL),   4 b^4 = k/(E I).
TEST(SleeperOnAWinklerBed, UnderAForceAtItsMiddle) {
  constexpr double force = 100e3;
  const auto off = [&](std::int64_t elements) {
    const TrackParameters t = bending(elements);
    const Bar bar(t);
    const double bed = 2 * BallastParameters{}.stiffness / bar.length;
    const double b = std::pow(bed / (4 * bar.stiffness), 0.25), bl = b * bar.length;
    const double below = std::sinh(bl) + std::sin(bl);
    const double w = force * b / (2 * bed) * (std::cosh(bl) + std::cos(bl) + 2) / below;
    const double m = force / (4 * b) * (std::cosh(bl) - std::cos(bl)) / below;
    const Line line = loose(t);
    const Vector u = loaded(line, {0}, force);
    const double found = -line.sleeper_at(0, 0).deflection(u),
                 moment = line.sleeper_moment(0, 0, u);
    if (elements == finest) {
      const verified::Tolerance deflection{5e-7, "(b h)^4 / 200 = 1.6e-7, three times"};
      const verified::Tolerance moments{2e-6, "fourth order as the deflection, up to ten times it"};
      verified::near("deflection at the middle, 40 elements", "m", found, w, deflection.of(w));
      verified::near("moment at the middle, 40 elements", "N m", moment, m, moments.of(m));
    }
    return std::abs(found - w);
  };
  const double coarse = off(6), middle = off(12), fine = off(finest);
  verified::near("order in element length, deflection", "-", std::log2(coarse / middle), 4, fourth);
  verified::near("order in element length, 20 and 40 elements, deflection", "-",
                 std::log2(middle / fine), 4, fourth);
}

// P at both seats, the middle u m without ballast. By symmetry one half, from y = 0 to L/2, in
// parts:
//   E I w'''' + k w = 0:  w = sum of e^(+-b y) cos b y, e^(+-b y) sin b y, or of 1, y, y^2, y^3,
// joined with w, w', w'' and with P in w''' at the seat; w' = w''' = 0 at the middle, w'' = w''' =
// 0 at the end.
struct Exact {
  Exact(const TrackParameters& t, double unsupported, double force) : bar(t) {
    const double bed = BallastParameters{}.stiffness / ((bar.length - unsupported) / 2);
    b = std::pow(bed / (4 * bar.stiffness), 0.25);
    border = {0, unsupported / 2, t.gauge / 2, bar.length / 2};
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(12, 12);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(12);
    const auto put = [&](Eigen::Index row, std::size_t part, double y, int derivative,
                         double sign) {
      rows.block(row, 4 * static_cast<Eigen::Index>(part), 1, 4) +=
          sign * shapes(part, y, derivative).transpose() / std::pow(b, derivative);
    };
    put(0, 0, 0, 1, 1), put(1, 0, 0, 3, 1), put(2, 2, border[3], 2, 1), put(3, 2, border[3], 3, 1);
    for (std::size_t joint = 0; joint < 2; ++joint)
      for (int d = 0; d < 4; ++d) {
        const auto row = static_cast<Eigen::Index>(4 + 4 * joint) + d;
        put(row, joint, border[joint + 1], d, -1), put(row, joint + 1, border[joint + 1], d, 1);
      }
    right[11] = -force / bar.stiffness / std::pow(b, 3);
    factor = rows.fullPivLu().solve(right);
  }
  // The four functions of a part, or their derivatives.
  Eigen::Vector4d shapes(std::size_t part, double y, int derivative) const {
    Eigen::Vector4d value;
    if (part == 0) {
      const double d = derivative;
      for (int n = 0; n < 4; ++n) {
        double f = std::pow(b, n);
        for (int k = 0; k < derivative; ++k) f *= n - k;
        value[n] = n < d ? 0 : f * std::pow(y, n - derivative);
      }
      return value;
    }
    for (int n = 0; n < 2; ++n) {
      const std::complex<double> root(n == 0 ? b : -b, b);
      const auto of = std::pow(root, derivative) * std::exp(root * (y - border[3] / 2));
      value[2 * n] = of.real(), value[2 * n + 1] = of.imag();
    }
    return value;
  }
  double at(double y, int derivative) const {
    const std::size_t part = y < border[1] ? 0 : y < border[2] ? 1 : 2;
    return shapes(part, y, derivative).dot(factor.segment<4>(4 * static_cast<Eigen::Index>(part)));
  }
  double moment(double y) const { return bar.stiffness * at(y, 2); }

  Bar bar;
  double b;  // 1/m
  std::array<double, 4> border;
  Eigen::VectorXd factor;
};

TEST(SleeperOnAWinklerBed, UnderBothRails) {
  constexpr double force = 60e3;
  const verified::Tolerance deflection{
      2e-6, "(b h)^4 / 200 of both loads, of deflections up to three times as large: 1e-6, twice"};
  const verified::Tolerance moments{5e-6, "fourth order as the deflection, up to ten times it"};
  for (const double unsupported : {1e-9, 0.7}) {
    const std::string what = unsupported < 0.1 ? "ballast everywhere" : "0.7 m without ballast";
    const auto off = [&](std::int64_t elements) {
      const TrackParameters t = bending(elements);
      const Exact exact(t, unsupported, force);
      const Line line = loose(t, unsupported);
      const Vector u = loaded(line, {0.75, -0.75}, force);
      double sum = 0;
      for (const double y : {0.0, 0.75, 1.25}) {
        const double found = line.sleeper_at(0, y).deflection(u);
        if (elements == finest)
          verified::near(fmt::format("deflection at {:g} m, {}, 40 elements", y, what), "m", found,
                         exact.at(y, 0), deflection.of(exact.at(0.75, 0)));
        sum += std::abs(found - exact.at(y, 0));
      }
      if (elements == finest)
        for (const double y : {0.0, 0.75})
          verified::near(fmt::format("moment at {:g} m, {}, 40 elements", y, what), "N m",
                         line.sleeper_moment(0, y, u), exact.moment(y),
                         moments.of(exact.moment(0.75)));
      return sum;
    };
    const double coarse = off(6), middle = off(12), fine = off(finest);
    verified::near(fmt::format("order in element length, {}", what), "-",
                   std::log2(coarse / middle), 4, fourth);
    verified::near(fmt::format("order in element length, 20 and 40 elements, {}", what), "-",
                   std::log2(middle / fine), 4, fourth);
  }
}

}  // namespace
}  // namespace trackbed::track::sleeper_beam_test
