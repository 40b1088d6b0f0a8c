// Parameters of materials and contact laws, each declared once, and rules between them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "trackbed/dem/law.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::dem {

namespace {

// A law applies to two materials in either order.
bool is_of(const ContactLaw& law, const std::string& one, const std::string& other) {
  return (law.first == one && law.second == other) || (law.first == other && law.second == one);
}

std::string listed(const std::vector<std::string>& names) {
  return names.empty() ? "the deck defines no [[material]]"
                       : fmt::format("there are {}", fmt::join(names, ", "));
}

}  // namespace

// Densities are those of the solid, not of the bed with its voids. Parameters that only some laws
// need may stay 0.
void Material::declare(input::Section& s) {
  // Stones store the number of their material: the order of existing materials must not change.
  auto fixed = s.fixed_by(input::state::earlier);
  s.text("name", name, "Name by which contacts, bed and sleepers refer to the material.", {}, true);
  fixed.end();
  s.number("density", density,
           {.unit = "kg/m3", .above = 0, .usually_from = 500, .usually_to = 2e4},
           "Density of the solid; it determines the mass of the stones and sleepers made of this "
           "material.");
  s.number(
      "local_damping", local_damping, {.unit = "-", .at_least = 0, .at_most = 0.999},
      "Cundall's local damping: ratio of the damping force, against the motion, to the net force.");
  s.number("young", young, {.unit = "Pa", .at_least = 0, .usually_from = 1e5, .usually_to = 1e12},
           "Young's modulus, for hertz contacts.");
  s.number("poisson", poisson, {.unit = "-", .above = -1, .at_most = 0.5},
           "Poisson's ratio, for hertz contacts.");
}

// All parameters of every law are in one list: the deck of a bed may change its law and keep the
// rest. Parameters that the chosen law does not use have no effect, as their descriptions state.
void ContactLaw::declare(input::Section& s) {
  s.text("first", first, "Name of one material.", {}, true);
  s.text("second", second, "Name of the other (or the same) material.", {}, true);
  s.choice(
      "law", kind, {"linear", "hertz"},
      "Contact law between the two materials. hertz in a plane model: parallel cylinders whose "
      "length equals the thickness of the model, k_n = pi/4 E* thickness.");
  s.number("k_n", k_n, {.unit = "N/m", .above = 0, .usually_from = 1e3, .usually_to = 1e12},
           "Normal stiffness, linear law.");
  s.number("k_s", k_s, {.unit = "N/m", .at_least = 0, .usually_from = 1e3, .usually_to = 1e12},
           "Tangential stiffness, linear law.");
  s.number("friction", friction, {.unit = "-", .at_least = 0, .usually_to = 2},
           "Coulomb's coefficient of friction.");
  s.number("zeta_n", zeta_n, {.unit = "-", .at_least = 0, .at_most = 1},
           "Normal viscous damping ratio, linear law. The restitution of a head-on collision is "
           "exp(-2 zeta acos(zeta) / sqrt(1 - zeta^2)); with attraction = true it is exp(-pi zeta "
           "/ sqrt(1 - zeta^2)). With sub-steps of the default length the restitution deviates "
           "from these formulas by up to 0.05.");
  s.number("zeta_s", zeta_s, {.unit = "-", .at_least = 0, .at_most = 1},
           "Tangential viscous damping ratio, linear law.");
  // Without attraction a restitution of 0 would need an infinite damper; 0.001 needs 16 times the
  // critical damping, and steps shorter by this factor.
  s.number("restitution", restitution, {.unit = "-", .at_least = 1e-3, .at_most = 1},
           "Coefficient of restitution of a head-on collision, hertz law; it sets the dampers of "
           "both the normal and the tangential spring. With sub-steps of the default length the "
           "restitution of a collision can differ by 0.05; a smaller dem.safety is more accurate.");
  s.flag("attraction", attraction,
         "Whether viscous damping may cause tension at the end of a collision; if not, the normal "
         "force F_n is at least 0.");
  s.number("rolling_friction", rolling_friction, {.unit = "-", .at_least = 0},
           "Coefficient of rolling friction: largest rolling moment divided by F_n R, where R = r1 "
           "r2/(r1 + r2) is the reduced radius of the circumscribed spheres of the two pieces. "
           "The coefficient is the tangent of the steepest slope on which a sphere that does not "
           "slide remains at rest; 0: rolling is free.");
  // From 2.25 mu_r^2 with mu_r = 0.01 (Ai et al. 2011, model C) to some multiple of k_s / k_n
  // (Iwashita, Oda 1998). A spring stiffer than the contact itself also reduces the step.
  s.number("rolling_stiffness", rolling_stiffness,
           {.unit = "-", .above = 0, .usually_from = 1e-4, .usually_to = 10},
           "Rolling stiffness: moment per angle of rolling, divided by k_n R^2.");
  s.number("zeta_r", zeta_r, {.unit = "-", .at_least = 0, .at_most = 1},
           "Viscous damping ratio of rolling.");
}

// Rules state the keys that they read, so that a message points to the wrong line. Whether every
// pair in contact has a law is known only when particles and surfaces exist (`check_laws`).
void Physics::declare(input::Section& s) {
  s.tables("material", materials, "A material of particles, sleepers, ground or walls.");
  s.tables("contact", laws, "The contact law of a pair of materials.");
  for (std::size_t m = 0; m < materials.size(); ++m)
    s.rule(fmt::format("material[{}].name", m), material(materials[m].name) == static_cast<int>(m),
           "is already the name of an earlier [[material]]; choose another name",
           {.reads = {"material"}});
  for (std::size_t c = 0; c < laws.size(); ++c) {
    const std::string key = fmt::format("contact[{}]", c);
    const ContactLaw& law = laws[c];
    rule_of_name(s, key + ".first", law.first);
    rule_of_name(s, key + ".second", law.second);
    const auto same = std::find_if(laws.begin(), laws.end(), [&](const ContactLaw& earlier) {
      return is_of(earlier, law.first, law.second);
    });
    s.rule(key, same == laws.begin() + static_cast<std::ptrdiff_t>(c),
           fmt::format("the law between \"{}\" and \"{}\" is given twice; remove one of them",
                       law.first, law.second),
           {.reads = {key}});
    s.rule(key + ".k_s", law.kind != LawKind::linear || law.k_s > 0 || law.friction == 0,
           "without tangential stiffness there is no friction; give a value above 0, or "
           "friction = 0",
           {.severity = input::Severity::warning, .reads = {key}});
    const auto stiff = [&](const std::string& name) {
      const int number = material(name);
      return number >= 0 && materials[static_cast<std::size_t>(number)].young > 0;
    };
    s.rule(key + ".law", !needs_young(law.kind) || (stiff(law.first) && stiff(law.second)),
           fmt::format("needs young above 0 in both materials; that of \"{}\" is 0",
                       stiff(law.first) ? law.second : law.first),
           {.reads = {key, "material"}});
  }
}

int Physics::material(const std::string& name) const {
  for (std::size_t m = 0; m < materials.size(); ++m)
    if (materials[m].name == name) return static_cast<int>(m);
  return -1;
}

bool Physics::has_law(const std::string& one, const std::string& other) const {
  return std::any_of(laws.begin(), laws.end(),
                     [&](const ContactLaw& law) { return is_of(law, one, other); });
}

// For all tables that name a material, in this module and in others.
void Physics::rule_of_name(input::Section& s, const std::string& key,
                           const std::string& name) const {
  std::vector<std::string> names;
  for (const Material& known : materials) names.push_back(known.name);
  const std::string near = input::nearest(name, names);
  s.rule(key, material(name) >= 0,
         fmt::format("there is no [[material]] \"{}\"; {}", name,
                     near.empty() ? listed(names) : fmt::format("did you mean {}?", near)),
         {.reads = {"material", key}});
}

}  // namespace trackbed::dem
