// Contact laws and the materials to which they apply. The kernels are in src/dem/law/contact.hpp.
#pragma once

#include <string>
#include <vector>

#include "trackbed/input/section.hpp"

namespace trackbed::dem {

struct Material {
  std::string name;
  double density = 2650;     // kg/m^3 of the solid
  double local_damping = 0;  // Cundall's alpha on force and moment
  double young = 0;          // Pa, hertz only
  double poisson = 0.25;     // hertz only
  void declare(input::Section& s);
};

// linear: F_n = k_n delta, F_s incremental with k_s, viscous damping as ratio of the critical one.
// hertz: Hertz-Mindlin from the materials' young and poisson, damped to the given restitution; in a
// plane model the contact of parallel cylinders whose length is the thickness of the model.
enum class LawKind { linear, hertz };
bool needs_young(LawKind kind);  // above 0 in both materials is required

struct ContactLaw {
  std::string first, second;  // material names
  LawKind kind = LawKind::linear;
  double k_n = 5e8, k_s = 5e8;  // N/m
  double friction = 0.5;
  double zeta_n = 0, zeta_s = 0;  // of critical, linear only
  double restitution = 1;         // hertz only
  bool attraction = false;        // whether damping may pull at the end of a collision
  double rolling_friction = 0;    // mu_r: largest rolling moment over F_n R; 0: rolling is free
  double rolling_stiffness = 1;   // k_r over k_n R^2
  double zeta_r = 0;              // of critical
  void declare(input::Section& s);
};

struct Physics {
  std::vector<Material> materials;
  std::vector<ContactLaw> laws;     // one per pair of materials that may be in contact
  double thickness = 0;             // m, of a plane model, where hertz is a line contact; 0: space
  void declare(input::Section& s);  // [[material]], [[contact]]

  int material(const std::string& name) const;                           // index; -1: unknown
  bool has_law(const std::string& one, const std::string& other) const;  // by names of materials
  // Declares the rule that the text parameter `key`, with the value `name`, names a material.
  void rule_of_name(input::Section& s, const std::string& key, const std::string& name) const;
};

}  // namespace trackbed::dem
