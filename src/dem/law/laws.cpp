// Conversion of the deck's declarations to data of the kernels, and the resulting time step. Run
// once per model and not per sub-step. Symbols and sources: contact.hpp.
#include "dem/law/laws.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "trackbed/core/error.hpp"
#include "trackbed/dem/stiffness.hpp"

namespace trackbed::dem {

namespace {

int material_named(const Physics& physics, const std::string& name) {
  const int number = physics.material(name);
  if (number >= 0) return number;
  throw InputError({fmt::format("contact: there is no material \"{}\"", name)});
}

// Without a coefficient there is no law: the kernels then skip rolling altogether.
Rolling<double> rolling_of(const ContactLaw& c) {
  if (!(c.rolling_friction > 0)) return {};
  return {c.rolling_friction, c.rolling_stiffness, c.zeta_r};
}

double least_force(const ContactLaw& c) {
  return c.attraction ? -std::numeric_limits<double>::infinity() : 0;
}

// c = 2 zeta sqrt(m_eff k); the masses are those of the pair and are applied later, so c is stored
// over sqrt(m_eff).
Law linear_law(const ContactLaw& c) {
  return {.springs = {.k_n = c.k_n,
                      .k_s = c.k_s,
                      .c_n = 2 * c.zeta_n * std::sqrt(c.k_n),
                      .c_s = 2 * c.zeta_s * std::sqrt(c.k_s),
                      .mu = c.friction,
                      .least = least_force(c)},
          .rolling = rolling_of(c)};
}

// k_n and k_s over sqrt(R delta), Pa: 4/3 E* and 8 G* (Hertz; Mindlin 1949).
struct HertzStiffness {
  double e_star, g_star;
  double normal() const { return 4.0 / 3.0 * e_star; }
  double shear() const { return 8 * g_star; }
};

//   1/E* = (1 - nu_a^2)/E_a + (1 - nu_b^2)/E_b,
//   1/G* = 2 (2 - nu_a)(1 + nu_a)/E_a + 2 (2 - nu_b)(1 + nu_b)/E_b,
// E Young's modulus, Pa, nu Poisson's ratio. Mindlin's tangential stiffness is that without slip;
// partial slip is not modelled, the whole contact sticks or slides.
HertzStiffness hertz_stiffness(const Material& a, const Material& b) {
  const auto softness = [](const Material& m) { return (1 - m.poisson * m.poisson) / m.young; };
  const auto shear_softness = [](const Material& m) {
    return 2 * (2 - m.poisson) * (1 + m.poisson) / m.young;
  };
  return {1 / (softness(a) + softness(b)), 1 / (shear_softness(a) + shear_softness(b))};
}

// With a = sqrt(R delta), m: c_n = 2 sqrt(5/6) beta sqrt(2 E* a m_eff), and c_s with 8 G* in place
// of 2 E*. The kernels multiply by sqrt(a m_eff).
Law spherical_hertz_law(const ContactLaw& c, const HertzStiffness& k) {
  const double damping = 2 * std::sqrt(5.0 / 6.0) * hertz_damping(c.restitution, !c.attraction);
  return {.springs = {.k_n = k.normal(),
                      .k_s = k.shear(),
                      .c_n = damping * std::sqrt(2 * k.e_star),
                      .c_s = damping * std::sqrt(8 * k.g_star),
                      .mu = c.friction,
                      .least = least_force(c),
                      .hertz = 1},
          .rolling = rolling_of(c)};
}

// Parallel cylinders of length L, plane models: F = pi/4 E* L delta for any radii (the logarithm of
// the exact law is left out: Popov 2010, Contact Mechanics and Friction, 5.16,
// doi:10.1007/978-3-642-10803-7), and the tangential stiffness in Mindlin's ratio 4 G*/E* to it.
struct LineStiffness {
  double normal, shear;  // N/m
  LineStiffness(const HertzStiffness& k, double length)
      : normal(std::numbers::pi / 4 * k.e_star * length), shear(4 * k.g_star / k.e_star * normal) {}
};

Law line_hertz_law(const ContactLaw& c, const HertzStiffness& k, double length) {
  const LineStiffness line(k, length);
  ContactLaw linear = c;
  linear.k_n = line.normal, linear.k_s = line.shear;
  linear.zeta_n = linear.zeta_s = linear_damping(c.restitution, !c.attraction);
  return linear_law(linear);
}

// `thickness`: m, of a plane model; 0 in space.
Law hertz_law(const ContactLaw& c, const Material& a, const Material& b, double thickness) {
  if (a.young <= 0 || b.young <= 0)
    // A deck is checked before (parameters.cpp); this is for callers without one.
    throw InputError(
        {fmt::format("contact {}-{}: the hertz law needs young above 0 in both "
                     "materials",
                     a.name, b.name)});
  const HertzStiffness k = hertz_stiffness(a, b);
  return thickness > 0 ? line_hertz_law(c, k, thickness) : spherical_hertz_law(c, k);
}

// Kinds of laws become numbers here and, for limits of the step, in `stiffness_of`.
Law law_of(const ContactLaw& c, const Material& a, const Material& b, double thickness) {
  Law law;
  switch (c.kind) {
    case LawKind::linear:
      law = linear_law(c);
      break;
    case LawKind::hertz:
      law = hertz_law(c, a, b, thickness);
      break;
  }
  return law;
}

// N/m, normal and tangential; hertz in space: at this contact size, sqrt(R delta), m.
struct Stiffness {
  double normal = 0, shear = 0;
};

Stiffness stiffness_of(const ContactLaw& c, const Material& a, const Material& b, double thickness,
                       double contact_size) {
  Stiffness k;
  switch (c.kind) {
    case LawKind::linear:
      k = {c.k_n, c.k_s};
      break;
    case LawKind::hertz: {
      const HertzStiffness over = hertz_stiffness(a, b);
      k = {over.normal() * contact_size, over.shear() * contact_size};
      if (thickness > 0) {
        const LineStiffness line(over, thickness);
        k = {line.normal, line.shear};
      }
      break;
    }
  }
  return k;
}

// Restitution of x'' = -force(x, x') that begins with x = 0, x' = 1: a collision in units of its
// mass, stiffness and speed. `cut`: the force does not pull. Fourth-order Runge-Kutta.
template <class Force>
double restitution_of(const Force& law, bool cut) {
  const auto force = [&](double x, double v) {
    if (x <= 0) return 0.0;
    const double f = law(x, v);
    return cut ? std::max(f, 0.0) : f;
  };
  double x = 0, v = 1;
  constexpr double h = 2e-3;      // of an elastic collision that lasts about 3.2
  constexpr int longest = 10000;  // steps; by then bodies have separated or are nearly at rest
  for (int step = 0; step < longest; ++step) {
    const double a1 = -force(x, v), v2 = v + 0.5 * h * a1;
    const double a2 = -force(x + 0.5 * h * v, v2), v3 = v + 0.5 * h * a2;
    const double a3 = -force(x + 0.5 * h * v2, v3), v4 = v + h * a3;
    const double a4 = -force(x + h * v3, v4);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    // The collision ends when the bodies separate or, without attraction, when the force has become
    // zero: the speed is constant from there on.
    if (v < 0 && (x <= 0 || (cut && force(x, v) <= 0))) break;
  }
  return std::max(-v, 0.0);
}

// The damping whose collision has this restitution. Restitution falls as damping grows, so
// bisection converges. 45 halvings leave 6e-13 of the damping; the restitution errs by up to 1e-4
// (linear) and 1e-5 (hertz), since the integration ends with a whole step.
template <class Restitution>
double damping_for(double restitution, const Restitution& of) {
  if (restitution >= 1) return 0;
  double low = 0, high = 20;
  for (int i = 0; i < 45; ++i) {
    const double middle = 0.5 * (low + high);
    (of(middle) > restitution ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

bool needs_young(LawKind kind) {
  bool needs = false;
  switch (kind) {
    case LawKind::linear:
      break;
    case LawKind::hertz:
      needs = true;
      break;
  }
  return needs;
}

// In these units a Hertz collision, x^1.5 + 2 sqrt(5/6) beta sqrt(1.5) x^0.25 x', has no parameter
// but beta: restitution does not depend on speed, size or stiffness, which is the purpose of this
// form of damping. With attraction beta = -ln e / sqrt(ln^2 e + pi^2).
double hertz_damping(double restitution, bool cut) {
  return damping_for(restitution, [&](double beta) {
    const double damping = 2 * std::sqrt(5.0 / 6.0) * beta * std::sqrt(1.5);
    return restitution_of(
        [&](double x, double v) {
          return x * std::sqrt(x) + damping * std::sqrt(std::sqrt(x)) * v;
        },
        cut);
  });
}

double linear_damping(double restitution, bool cut) {
  return damping_for(restitution, [&](double zeta) {
    return restitution_of([&](double x, double v) { return x + 2 * zeta * v; }, cut);
  });
}

Physics with_stiffness(Physics physics, double fraction) {
  for (ContactLaw& c : physics.laws) c.k_n *= fraction, c.k_s *= fraction;
  for (Material& m : physics.materials) m.young *= fraction;
  return physics;
}

// Hertz: k = F/delta; the slope of F is 1.5 times that, which the safety of the step covers. A
// spring of rolling resistance has its own frequency and counts too.
double stiffest_contact(const Physics& physics, double radius, double largest_overlap) {
  double stiffest = 0;
  for (const ContactLaw& c : physics.laws) {
    const int a = physics.material(c.first), b = physics.material(c.second);
    if (needs_young(c.kind) && (a < 0 || b < 0)) continue;
    const auto material = [&](int m) {
      return m < 0 ? Material{} : physics.materials[static_cast<std::size_t>(m)];
    };
    const Stiffness k = stiffness_of(c, material(a), material(b), physics.thickness,
                                     radius * std::sqrt(largest_overlap));
    const double rolling = c.rolling_friction > 0 ? c.rolling_stiffness * k.normal : 0;
    stiffest = std::max({stiffest, k.normal, k.shear, rolling});
  }
  return stiffest;
}

namespace {

// Damping ratio c / (2 sqrt(k m)) of the most damped law, 1 if none is above. Only a Hertz law of a
// restitution below about 0.15 is: without attraction the ratio grows without limit as the
// restitution approaches 0.
double largest_damping(const Physics& physics) {
  double largest = 1;
  for (const ContactLaw& c : physics.laws) {
    const int a = physics.material(c.first), b = physics.material(c.second);
    if (!needs_young(c.kind) || a < 0 || b < 0) continue;
    const Springs<double> s =
        law_of(c, physics.materials[static_cast<std::size_t>(a)],
               physics.materials[static_cast<std::size_t>(b)], physics.thickness)
            .springs;
    if (s.k_n > 0) largest = std::max(largest, s.c_n / (2 * std::sqrt(s.k_n)));
    if (s.k_s > 0) largest = std::max(largest, s.c_s / (2 * std::sqrt(s.k_s)));
  }
  return largest;
}

}  // namespace

// A mass on a spring, central difference: dt < 2 sqrt(m/k). A particle has many contacts at once
// and rotates more easily than it translates, hence the safety factor well below 2. The lightest
// particle and the stiffest contact need not belong together: this is on the safe side and cheap.
// A damper alone slows the mass down within m/c. With a damping ratio x above 1 this is shorter
// than the time of the spring, and a longer step would turn the motion round and make energy. The
// step is divided by x, so that c dt/m is never above twice the safety factor.
double stable_step(const Physics& physics, const Parameters& parameters, double lightest,
                   double largest, std::string* limit) {
  const double stiffest = stiffest_contact(physics, largest, parameters.largest_overlap);
  const double damping = largest_damping(physics);
  if (limit) {
    *limit = fmt::format(
        "{:g} sqrt(m/k), where {:g} is dem.safety, m = {:.4g} kg the mass of the lightest stone "
        "and "
        "k = {:.4g} N/m the stiffness of the stiffest contact",
        parameters.safety, parameters.safety, lightest, stiffest);
    if (damping > 1)
      *limit += fmt::format(
          ", divided by the largest damping ratio of the contact laws, {:.3g} (low restitution)",
          damping);
  }
  return parameters.safety * std::sqrt(lightest / stiffest) / damping;
}

namespace {

// One mass on springs with the frequency w sqrt(k_n/m) and dampers of the ratio x, whose force is
// that of the velocity half a step ago, is stable up to
//   s = (2/w) (sqrt(1 + x^2) - x)    in units of sqrt(m/k_n).
// w^2 and x as of many contacts at once: fitted to compressed beds of stones of 12 corners.
double steady_safety_of(const ContactLaw& c) {
  const double stiffest = std::max(c.k_n, c.k_s);
  const double w = std::sqrt((16 * c.k_n + 14 * c.k_s) / stiffest);
  const double x = 2 * std::max(c.zeta_n, c.zeta_s);
  return 2 / w * (std::sqrt(1 + x * x) - x);
}

}  // namespace

// Not known for Hertz's law, whose stiffness changes with the overlap.
double steady_safety(const Physics& physics) {
  double least = std::numeric_limits<double>::infinity();
  for (const ContactLaw& c : physics.laws) {
    switch (c.kind) {
      case LawKind::linear:
        if (c.k_n > 0) least = std::min(least, steady_safety_of(c));
        break;
      case LawKind::hertz:
        break;
    }
  }
  return least;
}

// The surface of a sphere yields to a tangential force 7/2 times as much as its centre does. With
// the velocity of half a step ago, u'' = -7/2 (k_s u + c_s u')/m alternates from step to step if
// 7/2 (c_s dt + k_s dt^2 / 2)/m >= 2. With dt = s sqrt(m/k), c_s = 2 zeta_s sqrt(k_s m) and q^2 =
// k_s/k, k the larger stiffness: 7/4 (q s)^2 + 7 zeta_s (q s) = 2.
double steady_friction(const Physics& physics) {
  double least = std::numeric_limits<double>::infinity();
  for (const ContactLaw& c : physics.laws) {
    if (needs_young(c.kind) || !(c.k_s > 0 && c.zeta_s > 0 && c.friction > 0)) continue;
    const double q = std::sqrt(c.k_s / std::max(c.k_n, c.k_s)), x = 7 * c.zeta_s;
    least = std::min(least, (std::sqrt(x * x + 14) - x) / (3.5 * q));
  }
  return least;
}

// All problems at once. A pair that is not given stays at -1; whether it is needed is known only
// when particles and surfaces exist (`check_laws`).
LawTable::LawTable(const Physics& physics)
    : materials_(physics.materials.size()), pair_(materials_ * materials_, -1) {
  std::vector<std::string> problems;
  if (physics.laws.size() > most_laws)
    problems.push_back(fmt::format("contact: {} laws are given, the maximum is {}",
                                   physics.laws.size(), most_laws));
  for (const ContactLaw& c : physics.laws) {
    const auto a = static_cast<std::size_t>(material_named(physics, c.first));
    const auto b = static_cast<std::size_t>(material_named(physics, c.second));
    if (pair_[a * materials_ + b] >= 0)
      problems.push_back(fmt::format("contact {}-{} is given twice", c.first, c.second));
    pair_[a * materials_ + b] = pair_[b * materials_ + a] = static_cast<int>(laws_.size());
    laws_.push_back(law_of(c, physics.materials[a], physics.materials[b], physics.thickness));
  }
  if (!problems.empty()) throw InputError(problems);
  for (const Law& law : laws_) friction_.push_back(law.springs.mu), rolls_ |= law.rolling.mu > 0;
}

// For stages with softer contacts. The override of friction is kept.
void LawTable::set_stiffness(const Physics& physics) {
  const LawTable other(physics);
  for (std::size_t k = 0; k < laws_.size(); ++k) {
    const double mu = laws_[k].springs.mu;
    laws_[k] = other.laws_[k];
    laws_[k].springs.mu = mu;
  }
}

// For stages that pack with less friction. The limit of rolling is not changed.
void LawTable::override_friction(double mu) {
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k].springs.mu = mu < 0 ? friction_[k] : mu;
}

void LawTable::scale_friction(double factor) {
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k].springs.mu = factor * friction_[k];
}

}  // namespace trackbed::dem
