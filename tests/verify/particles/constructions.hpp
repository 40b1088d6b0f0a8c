// Alternative contact models for the overlap of two rounded convex cores, and two bodies to test
// them. For the study `stone_constructions`; the program uses the smooth maximum of
// src/dem/shape/features.hpp.
#pragma once

#include <functional>
#include <vector>

#include "dem/shape/features.hpp"
#include "dem/shape/separation.hpp"
#include "support/stone_pairs.hpp"

namespace trackbed::study {

// A convex body of one piece in motion.
struct Body {
  dem::Core core;
  std::vector<geom::Face> faces;  // at unit scale
  double scale, mass;
  Vec3 inertia;  // kg m^2, principal
  Vec3 x, v, l;  // m, m/s, kg m^2/s
  Quat q;
  std::vector<dem::Vec4> corners;  // m, from x

  Body(const dem::Template& shape, const dem::NewParticle& p, double density);
  void place();
  void kick(const Vec3& force, const Vec3& torque, double dt);
  void drift(double dt);
  double kinetic() const;
  dem::Placed placed(const Vec3& origin) const {
    return {&core, corners, x - origin, core.radius * scale};
  }
};

struct Feature {
  double delta;  // m
  Vec3 n, x;     // from i to j; point of contact from the centre of i
};

// Force on i and torques about both centres.
struct Response {
  Vec3 force = Vec3::Zero(), turn_i = Vec3::Zero(), turn_j = Vec3::Zero();
  void add(const Vec3& f, const Vec3& at, const Vec3& centre_j) {
    force += f, turn_i += at.cross(f), turn_j -= (at - centre_j).cross(f);
  }
};

// State of a pair that is kept from step to step.
struct Memory {
  Vec3 normal = Vec3::UnitZ();
};

// All features of the pair within reach.
void all_features(const Body& i, const Body& j, std::vector<Feature>& found);
// At most four points: the face of the other body opposite to the reference face, clipped to its
// prism (Sutherland, Hodgman 1974, doi:10.1145/360767.360802).
void clipped_manifold(const Body& i, const Body& j, Memory& memory, std::vector<Feature>& found);

using Construction = std::function<Response(const Body&, const Body&, double k, Memory&)>;
struct NamedConstruction {
  const char* name;
  Construction respond;
};
std::vector<NamedConstruction> constructions();

}  // namespace trackbed::study
