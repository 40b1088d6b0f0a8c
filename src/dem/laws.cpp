#include "laws.hpp"

#include <fmt/format.h>

#include <limits>

#include "trackbed/core/error.hpp"
#include "trackbed/dem/stiffness.hpp"

// A switch over the kinds of laws has no default here: a new kind is not compiled before each of
// them has its case.
#pragma GCC diagnostic error "-Wswitch"

namespace trackbed::dem {

namespace {

int material_named(const Physics& physics, const std::string& name) {
  const int number = physics.material(name);
  if (number >= 0) return number;
  throw InputError({fmt::format("contact: \"{}\" is not the name of a material", name)});
}

Rolling rolling_of(const ContactLaw& c) {
  if (!(c.rolling_friction > 0)) return {};
  return {c.rolling_friction, c.rolling_stiffness, c.zeta_r};
}

Law linear_law(const ContactLaw& c) {
  return {.rooted = false,
          .least = c.attraction ? -std::numeric_limits<double>::infinity() : 0,
          .k_n = c.k_n,
          .k_s = c.k_s,
          .c_n = 2 * c.zeta_n * std::sqrt(c.k_n),
          .c_s = 2 * c.zeta_s * std::sqrt(c.k_s),
          .mu = c.friction,
          .rolling = rolling_of(c)};
}

// k_n and k_s over sqrt(R delta), Pa: 4/3 E* and 8 G* (Hertz; Mindlin 1949).
struct HertzStiffness {
  double e_star, g_star;
  double normal() const { return 4.0 / 3.0 * e_star; }
  double shear() const { return 8 * g_star; }
};

HertzStiffness hertz_stiffness(const Material& a, const Material& b) {
  const auto softness = [](const Material& m) { return (1 - m.poisson * m.poisson) / m.young; };
  const auto shear_softness = [](const Material& m) {
    return 2 * (2 - m.poisson) * (1 + m.poisson) / m.young;
  };
  return {1 / (softness(a) + softness(b)), 1 / (shear_softness(a) + shear_softness(b))};
}

Law hertz_law(const ContactLaw& c, const Material& a, const Material& b) {
  if (a.young <= 0 || b.young <= 0)
    throw InputError(
        {fmt::format("contact {}-{}: the hertz law needs young above 0 in both "
                     "materials",
                     a.name, b.name)});
  const HertzStiffness k = hertz_stiffness(a, b);
  const double beta = hertz_damping(c.restitution, !c.attraction);
  const double damping = 2 * std::sqrt(5.0 / 6.0) * beta;
  return {.rooted = true,
          .least = c.attraction ? -std::numeric_limits<double>::infinity() : 0,
          .k_n = k.normal(),
          .k_s = k.shear(),
          .c_n = damping * std::sqrt(2 * k.e_star),
          .c_s = damping * std::sqrt(8 * k.g_star),
          .mu = c.friction,
          .rolling = rolling_of(c)};
}

Law law_of(const ContactLaw& c, const Material& a, const Material& b) {
  Law law;
  switch (c.kind) {
    case LawKind::linear:
      law = linear_law(c);
      break;
    case LawKind::hertz:
      law = hertz_law(c, a, b);
      break;
  }
  return law;
}

// N/m, normal and tangential; hertz: at this contact radius, sqrt(R delta), m.
struct Stiffness {
  double normal = 0, shear = 0;
};

Stiffness stiffness_of(const ContactLaw& c, const Material& a, const Material& b,
                       double contact_radius) {
  Stiffness k;
  switch (c.kind) {
    case LawKind::linear:
      k = {c.k_n, c.k_s};
      break;
    case LawKind::hertz: {
      const HertzStiffness over = hertz_stiffness(a, b);
      k = {over.normal() * contact_radius, over.shear() * contact_radius};
      break;
    }
  }
  return k;
}

// Restitution of m x'' = -(x^1.5 + 2 sqrt(5/6) beta sqrt(1.5) x^0.25 x') from x' = 1: the Hertz
// collision in units of its mass and stiffness. Fourth-order Runge-Kutta.
double restitution_of(double beta, bool cut) {
  const double damping = 2 * std::sqrt(5.0 / 6.0) * beta * std::sqrt(1.5);
  const auto force = [&](double x, double v) {
    if (x <= 0) return 0.0;
    const double f = x * std::sqrt(x) + damping * std::sqrt(std::sqrt(x)) * v;
    return cut ? std::max(f, 0.0) : f;
  };
  double x = 0, v = 1;
  constexpr double h = 2e-3;      // of an elastic collision that lasts about 3.2
  constexpr int longest = 10000;  // steps; what has not come back by then is all but at rest
  for (int step = 0; step < longest; ++step) {
    const double a1 = -force(x, v), v2 = v + 0.5 * h * a1;
    const double a2 = -force(x + 0.5 * h * v, v2), v3 = v + 0.5 * h * a2;
    const double a3 = -force(x + 0.5 * h * v2, v3), v4 = v + h * a3;
    const double a4 = -force(x + h * v3, v4);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    if (v < 0 && (x <= 0 || (cut && force(x, v) <= 0))) break;
  }
  return std::max(-v, 0.0);
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

double hertz_damping(double restitution, bool cut) {
  if (restitution >= 1) return 0;
  double low = 0, high = 20;
  for (int i = 0; i < 45; ++i) {
    const double middle = 0.5 * (low + high);
    (restitution_of(middle, cut) > restitution ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double stiffest_contact(const Physics& physics, double radius, double largest_overlap) {
  double stiffest = 0;
  for (const ContactLaw& c : physics.laws) {
    const int a = physics.material(c.first), b = physics.material(c.second);
    if (needs_young(c.kind) && (a < 0 || b < 0)) continue;
    const auto material = [&](int m) {
      return m < 0 ? Material{} : physics.materials[static_cast<std::size_t>(m)];
    };
    const Stiffness k =
        stiffness_of(c, material(a), material(b), radius * std::sqrt(largest_overlap));
    const double rolling = c.rolling_friction > 0 ? c.rolling_stiffness * k.normal : 0;
    stiffest = std::max({stiffest, k.normal, k.shear, rolling});
  }
  return stiffest;
}

double stable_step(const Physics& physics, const Parameters& parameters, double lightest,
                   double largest, std::string* limit) {
  const double stiffest = stiffest_contact(physics, largest, parameters.largest_overlap);
  if (limit)
    *limit = fmt::format("the lightest particle ({:.4g} kg) on the stiffest contact ({:.4g} N/m)",
                         lightest, stiffest);
  return parameters.safety * std::sqrt(lightest / stiffest);
}

LawTable::LawTable(const Physics& physics)
    : materials_(physics.materials.size()), pair_(materials_ * materials_, -1) {
  std::vector<std::string> problems;
  for (const ContactLaw& c : physics.laws) {
    const auto a = static_cast<std::size_t>(material_named(physics, c.first));
    const auto b = static_cast<std::size_t>(material_named(physics, c.second));
    if (pair_[a * materials_ + b] >= 0)
      problems.push_back(fmt::format("contact {}-{} is given twice", c.first, c.second));
    pair_[a * materials_ + b] = pair_[b * materials_ + a] = static_cast<int>(laws_.size());
    laws_.push_back(law_of(c, physics.materials[a], physics.materials[b]));
  }
  if (!problems.empty()) throw InputError(problems);
  for (const Law& law : laws_) friction_.push_back(law.mu), rolls_ |= law.rolling.mu > 0;
}

void LawTable::override_friction(double mu) {
  for (std::size_t k = 0; k < laws_.size(); ++k) laws_[k].mu = mu < 0 ? friction_[k] : mu;
}

}  // namespace trackbed::dem
