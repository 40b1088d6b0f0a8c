// The longest stable sub-step of the contacts that there are.
//
// With the velocities of half a sub-step ago, M a = -K u - C v alternates from sub-step to sub-step
// and grows where the largest eigenvalue of M^-1 (dt^2 K + 2 dt C) exceeds 4 (one mass:
// Belytschko, Liu, Moran, Nonlinear Finite Elements, 2000, section 6.2, with the damping force late
// by half a step). The eigenvalue is that of all stones together: neighbours move against each
// other, so that single stones, with their neighbours held, have up to half of it only. It is found
// by Lanczos iteration (Golub, Van Loan, Matrix Computations, 2013, section 10.1) from the contacts
// alone: no matrix is stored.
//
// A contact that slides has no tangential stiffness: this is a limit for the contacts that stick.
// Not included: bonds, torsional and rolling resistance, moments of the normal force of stones with
// corners about their point of contact, sleepers and walls (heavy).
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "dem/particles/contact_loop.hpp"
#include "trackbed/core/hash.hpp"
#include "trackbed/par/exact_totals.hpp"

namespace trackbed::dem {

namespace {

constexpr double alternates = 4;       // dt^2 w^2 + 2 dt 2 zeta w of the alternating motion
constexpr double tangent_hertz = 1.5;  // dF/d delta over F/delta
// The largest eigenvalue converges first: on beds of 66 and 510 stones 600 give the same to 1e-12.
constexpr int iterations = 40;
constexpr double spanned = 1e-12;  // what remains beside all motions that the start contains
constexpr double slides = 0.999;   // of the largest tangential force, which sliding contacts have
constexpr double accurate = 1e-3;  // relative, of the eigenvalue at the step that is found
constexpr int solutions = 12;      // for a step; each halves the error at least

// Translation, m/s, and rotation, rad/s in space axes, of one particle.
struct Motion {
  double numbers[6] = {};
  Vec3 velocity() const { return {numbers[0], numbers[1], numbers[2]}; }
  Vec3 spin() const { return {numbers[3], numbers[4], numbers[5]}; }
};

// A contact, seen from both stones; levers from the centres of mass, m.
struct Spring {
  std::size_t first, second;
  Vec3 lever_first, lever_second, normal;
  double along, across;  // kg, dt^2 k + 2 dt c of the normal and of the tangential force
};

}  // namespace

// dt^2 K + 2 dt C in units of the masses, of this rank's stones and their contacts.
class Particles::AlternatingMotion {
 public:
  AlternatingMotion(Impl& particles, double dt) : r_(particles), motions_(particles.state.size()) {
    const State& s = r_.state;
    plane_ = r_.domain.dimension == Dimension::plane;
    ContactLoop(r_).run_known([&](const ContactView& c, double, std::size_t first,
                                  std::size_t second, const Law& law, double radius) {
      const bool surface = second == ContactLoop::no_particle;
      const double m = s.v[first].w;
      const double effective = surface ? m : m * s.v[second].w / (m + s.v[second].w);
      const auto k = coefficients<true>(law.springs, c.overlap, std::sqrt(effective), radius);
      const double pressed = std::abs(c.force.dot(c.normal));
      const double sheared = (c.force - c.force.dot(c.normal) * c.normal).norm();
      const bool sticks = sheared < slides * law.springs.mu * pressed;
      // The overlap of features grows |N| times as fast as the faces approach (stone_law.hpp).
      const double rate = c.overlap > 0 ? pressed / (k.k_n * c.overlap) : 1;
      const double k_n = k.k_n * rate * rate * (law.springs.hertz > 0 ? tangent_hertz : 1);
      const double c_n = k.c_n * rate * rate / std::max(1.0, rate);
      springs_.push_back({first, second, c.point - c.first_centre, c.point - c.second_centre,
                          c.normal, dt * dt * k_n + 2 * dt * c_n,
                          sticks ? dt * dt * k.k_s + 2 * dt * k.c_s : 0});
    });
    for (std::size_t b = 0; b < s.own; ++b) axes_.push_back(quat(s.q[b]).toRotationMatrix());
  }

  std::size_t size() const { return 6 * r_.state.own; }

  // Of a vector of translations and of rotations in principal axes, in units of the root of mass or
  // moment. Collective among neighbours.
  Eigen::VectorXd times(const Eigen::VectorXd& x) {
    const State& s = r_.state;
    for (std::size_t b = 0; b < s.own; ++b) spread(b, x);
    r_.halo.forward(motions_.data(), motions_.data() + s.own);
    std::vector<Motion> forces(s.own);
    const auto add = [&](std::size_t b, const Vec3& force, const Vec3& lever) {
      if (b >= s.own) return;
      const Vec3 torque = lever.cross(force);
      for (int a = 0; a < 3; ++a)
        forces[b].numbers[a] += force[a], forces[b].numbers[3 + a] += torque[a];
    };
    for (const Spring& c : springs_) {
      const bool surface = c.second == ContactLoop::no_particle;
      Vec3 apart = motions_[c.first].velocity() + motions_[c.first].spin().cross(c.lever_first);
      if (!surface)
        apart -= motions_[c.second].velocity() + motions_[c.second].spin().cross(c.lever_second);
      const Vec3 along = c.normal * c.normal.dot(apart);
      const Vec3 force = c.along * along + c.across * (apart - along);
      add(c.first, force, c.lever_first);
      if (!surface) add(c.second, -force, c.lever_second);
    }
    Eigen::VectorXd product = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(size()));
    for (std::size_t b = 0; b < s.own; ++b) gather(b, forces[b], product);
    return product;
  }

 private:
  bool moves(std::size_t b, int a) const { return r_.state.held[b] == 0 && (!plane_ || a != 1); }
  bool turns(std::size_t b, int a) const { return r_.state.held[b] == 0 && (!plane_ || a == 1); }
  Mat3 axes(std::size_t b) const { return plane_ ? Mat3(Mat3::Identity()) : axes_[b]; }

  void spread(std::size_t b, const Eigen::VectorXd& x) {
    const auto at = static_cast<Eigen::Index>(6 * b);
    const double mass = r_.state.v[b].w;
    const Vec3 inertia = r_.state.inertia[b].vec3();
    Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
    for (int a = 0; a < 3; ++a) {
      if (moves(b, a)) velocity[a] = x[at + a] / std::sqrt(mass);
      if (turns(b, a)) spin[a] = x[at + 3 + a] / std::sqrt(inertia[a]);
    }
    spin = axes(b) * spin;
    for (int a = 0; a < 3; ++a)
      motions_[b].numbers[a] = velocity[a], motions_[b].numbers[3 + a] = spin[a];
  }

  void gather(std::size_t b, const Motion& force, Eigen::VectorXd& into) const {
    const auto at = static_cast<Eigen::Index>(6 * b);
    const Vec3 inertia = r_.state.inertia[b].vec3(), torque = axes(b).transpose() * force.spin();
    for (int a = 0; a < 3; ++a) {
      if (moves(b, a)) into[at + a] = force.velocity()[a] / std::sqrt(r_.state.v[b].w);
      if (turns(b, a)) into[at + 3 + a] = torque[a] / std::sqrt(inertia[a]);
    }
  }

  Impl& r_;
  bool plane_ = false;
  std::vector<Spring> springs_;
  std::vector<Mat3> axes_;
  std::vector<Motion> motions_;  // ghosts after own particles
};

// The largest eigenvalue at dt over that of the alternating motion.
double Particles::alternation(double dt) const {
  Impl& r = *impl_;
  AlternatingMotion matrix(r, dt);
  const auto n = static_cast<Eigen::Index>(matrix.size());
  // Start and products are the same on any number of ranks.
  Eigen::VectorXd x(n), before = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Id id = r.state.id[static_cast<std::size_t>(k / 6)];
    x[k] = uniform(0, static_cast<std::uint64_t>(6 * id + k % 6)) - 0.5;
  }
  const auto product = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return par::exact_totals(r.comm, {}, static_cast<std::size_t>(n), [&](std::size_t k) {
      const auto at = static_cast<Eigen::Index>(k);
      return par::ExactTerm{0, a[at] * b[at]};
    })[0];
  };
  std::vector<double> diagonal, beside;
  double length = std::sqrt(product(x, x));
  for (int k = 0; k < iterations && length > spanned; ++k) {
    x /= length;
    Eigen::VectorXd next = matrix.times(x);
    if (k > 0) next -= length * before, beside.push_back(length);
    diagonal.push_back(product(x, next));
    next -= diagonal.back() * x;
    before.swap(x), x.swap(next);
    length = std::sqrt(product(x, x));
  }
  if (diagonal.empty()) return 0;
  const auto size = static_cast<Eigen::Index>(diagonal.size());
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solved;
  solved.computeFromTridiagonal(Eigen::Map<Eigen::VectorXd>(diagonal.data(), size),
                                Eigen::Map<Eigen::VectorXd>(beside.data(), size - 1),
                                Eigen::EigenvaluesOnly);
  return solved.eigenvalues().maxCoeff() / alternates;
}

// From above: the eigenvalue falls at least as much as the step, and at most as its square.
double Particles::stable_step(double dt) const {
  for (int k = 0; k < solutions; ++k) {
    const double ratio = alternation(dt);
    if (!(ratio > 1 + accurate)) break;
    dt /= std::sqrt(ratio);
  }
  return dt;
}

}  // namespace trackbed::dem
