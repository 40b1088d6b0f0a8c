// Masses, borders and the critical step of a ground of tetrahedra.
//
// Masses are lumped with tetrahedron_mass_share: positive everywhere, so that explicit steps are
// possible, and the same in implicit ones. Weight and border terms are integrals of the shape
// functions: uniform weight then causes the exact stress in a column. On a six-node face that is a
// third of the area, weighted by the Jacobian there, at each mid-edge node, and nothing at corners.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>

#include "fem/boundary/terms.hpp"
#include "fem/shape/tetrahedron.hpp"
#include "trackbed/core/decompositions.hpp"

namespace trackbed::fem {

namespace {

TenNodes places(const Mesh& mesh, std::size_t element) {
  TenNodes nodes;
  for (int k = 0; k < 10; ++k)
    nodes[static_cast<std::size_t>(k)] = mesh.position(mesh.corner(element, k));
  return nodes;
}

Vec3 middle(const TenNodes& nodes) { return (nodes[0] + nodes[1] + nodes[2] + nodes[3]) / 4; }

// Areas, m^2, of the nodes 3, 4 and 5 of a face.
//   dx/d(xi, eta) there with N_0 = l_0 (2 l_0 - 1), ..., N_3 = 4 l_0 l_1, ...; weights 1/6.
Vec3 areas(const std::array<Vec3, 6>& x) {
  // Area coordinates of the nodes 3, 4, 5.
  const std::array<Vec3, 3> at = {Vec3(0.5, 0.5, 0), Vec3(0, 0.5, 0.5), Vec3(0.5, 0, 0.5)};
  Vec3 found;
  for (int m = 0; m < 3; ++m) {
    const Vec3& l = at[static_cast<std::size_t>(m)];
    // d/dl_i with the three coordinates as if independent; xi = l_1, eta = l_2, l_0 the remaining
    // one.
    std::array<Vec3, 3> by;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t next = (i + 1) % 3, last = (i + 2) % 3;
      by[i] = (4 * l[static_cast<Eigen::Index>(i)] - 1) * x[i] +
              4 * l[static_cast<Eigen::Index>(next)] * x[3 + i] +
              4 * l[static_cast<Eigen::Index>(last)] * x[3 + last];
    }
    found[m] = (by[1] - by[0]).cross(by[2] - by[0]).norm() / 6;
  }
  return found;
}

// Nodes of a face, and their parts of its area.
struct FaceAreas {
  std::array<std::int32_t, 6> node;
  Vec3 area;  // m^2, of the last three
};
FaceAreas areas_of(const Mesh& mesh, const Imported::Face& face) {
  FaceAreas part;
  std::array<Vec3, 6> x;
  for (std::size_t k = 0; k < 6; ++k) {
    const int local = tetrahedron_faces[static_cast<std::size_t>(face.side)][k];
    part.node[k] = mesh.corner(static_cast<std::size_t>(face.element), local);
    x[k] = mesh.position(part.node[k]);
  }
  part.area = areas(x);
  return part;
}

const Elastic& solid_of(const Mesh& mesh, std::int32_t element) {
  const std::int32_t solid = mesh.solid[static_cast<std::size_t>(element)];
  return mesh.solids.solid[static_cast<std::size_t>(solid)];
}

// A viscous face that faces down is a base: it has springs. Pa/m.
double spring_of(const Mesh& mesh, const GroundParameters& parameters, const Imported::Face& face) {
  if (face.axis != 2 || !face.low) return 0;
  return base_spring(parameters, solid_of(mesh, face.element), mesh.imported->depth);
}

struct ImportedBuilder {
  const Mesh& mesh;
  const GroundParameters& parameters;
  Terms& terms;

  void hold(const FaceAreas& part, std::vector<std::uint8_t>& held, int bits) const {
    for (const std::int32_t n : part.node)
      held[static_cast<std::size_t>(n)] |= static_cast<std::uint8_t>(bits);
  }
  // Dashpots; static conditions as in terms.cpp: a base without springs is held, a side is a
  // roller.
  void viscous(const Imported::Face& face, const FaceAreas& part) const {
    const bool base = face.axis == 2 && face.low;
    const double spring = spring_of(mesh, parameters, face);
    const Impedance of = impedance(solid_of(mesh, face.element), false);
    if (!base || spring == 0) hold(part, terms.held_static, base ? 7 : 1 << face.axis);
    for (int m = 0; m < 3; ++m) {
      const std::int32_t node = part.node[static_cast<std::size_t>(3 + m)];
      for (int c = 0; c < 3; ++c)
        terms.damping[c][node] += part.area[m] * (c == face.axis ? of.normal : of.tangential);
      if (spring > 0) terms.springs.push_back({node, spring * part.area[m]});
    }
  }
  void border(const Imported::Face& face) const {
    const FaceAreas part = areas_of(mesh, face);
    if (face.holds == BorderKind::viscous) return viscous(face, part);
    if (face.holds == BorderKind::free) return;
    const int bits = face.holds == BorderKind::fixed ? 7 : 1 << face.axis;
    hold(part, terms.held, bits), hold(part, terms.held_static, bits);
  }
};

}  // namespace

// Elements, then faces, both ascending: bitwise identical on any number of ranks.
void Terms::add_tetrahedra(const Mesh& mesh, const GroundParameters& parameters) {
  carried.assign(mesh.nodes(), 0.0);
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    const Elastic& solid = solid_of(mesh, static_cast<std::int32_t>(z));
    const TenNumbers load = tetrahedron_load(places(mesh, z));
    const double whole = solid.density * load.sum();  // kg
    for (int k = 0; k < 10; ++k) {
      const std::int32_t node = mesh.corner(z, k);
      const double part = whole * tetrahedron_mass_fraction(k);
      mass[static_cast<std::size_t>(node)] += part;
      carried[static_cast<std::size_t>(node)] += solid.density * load[k];
      for (int c = 0; c < 3; ++c)
        damping[c][node] += (solid.rayleigh_mass - parameters.rayleigh_mass) * part;
    }
  }
  const ImportedBuilder builder{mesh, parameters, *this};
  for (const Imported::Face& face : mesh.imported->borders) builder.border(face);
  for (int c = 0; c < 3; ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n)
      damping[c][n] += parameters.rayleigh_mass * mass[n];
  merge(springs);
}

// Faces in ascending order, as above.
std::vector<BasePart> viscous_base(const Mesh& mesh) {
  std::vector<BasePart> parts;
  for (const Imported::Face& face : mesh.imported->borders) {
    if (face.holds != BorderKind::viscous || face.axis != 2 || !face.low) continue;
    const FaceAreas part = areas_of(mesh, face);
    const Impedance of = impedance(solid_of(mesh, face.element), false);
    for (int m = 0; m < 3; ++m) {
      const double across = part.area[m] * of.tangential, along = part.area[m] * of.normal;
      parts.push_back({part.node[static_cast<std::size_t>(3 + m)], {across, across, along}});
    }
  }
  return parts;
}

namespace {

using Springs = std::map<std::size_t, Eigen::VectorXd>;  // N/m on degrees of freedom, by element

// Springs on nodes of an element, from its faces on a viscous base.
Springs springs_below(const Mesh& mesh, const GroundParameters& parameters) {
  Springs springs;
  for (const Imported::Face& face : mesh.imported->borders) {
    const double spring = spring_of(mesh, parameters, face);
    if (face.holds != BorderKind::viscous || spring == 0) continue;
    const auto element = static_cast<std::size_t>(face.element);
    auto& on = springs.try_emplace(element, Eigen::VectorXd::Zero(30)).first->second;
    const FaceAreas part = areas_of(mesh, face);
    for (int m = 0; m < 3; ++m) {
      const auto& local = tetrahedron_faces[static_cast<std::size_t>(face.side)];
      on.segment<3>(3 * local[static_cast<std::size_t>(3 + m)]).array() += spring * part.area[m];
    }
  }
  return springs;
}

// s, step of central differences with stiffness-proportional damping, from omega^2.
double step_from(double squared, const Elastic& solid) {
  const double omega = std::sqrt(squared), damped = 0.5 * solid.rayleigh_stiffness * omega;
  return 2 / omega * (std::sqrt(1 + damped * damped) - damped);
}

// At least the largest eigenvalue, and at most 1.53 times it for 30 of them: the eighth root of the
// sum of their eighth powers. Takes far less time than the eigenvalues.
double above_eigenvalues(const Eigen::MatrixXd& a) {
  const double size = a.norm();
  const Eigen::MatrixXd square = (a / size) * (a / size), fourth = square * square;
  constexpr double rounding = 1e-9;  // far above that of the products
  return size * std::pow(fourth.norm(), 0.25) * (1 + rounding);
}

// s, of an element, or a lower bound of it that is above `shortest`.
double step_of(const Mesh& mesh, std::size_t z, Eigen::MatrixXd k, double shortest) {
  const Elastic& solid = solid_of(mesh, static_cast<std::int32_t>(z));
  const double whole = solid.density * tetrahedron_volume(places(mesh, z));
  Eigen::VectorXd root(30);
  for (int f = 0; f < 30; ++f) root[f] = 1 / std::sqrt(whole * tetrahedron_mass_fraction(f / 3));
  k = (root.asDiagonal() * k * root.asDiagonal()).eval();
  const double at_least = step_from(above_eigenvalues(k), solid);
  return at_least > shortest ? at_least : step_from(symmetric_eigenvalues(k).maxCoeff(), solid);
}

// Collective: names the element by its number in the file, or by its position if there is no file.
std::string name_of(const Mesh& mesh, const GroundParameters& parameters, Id element, bool mine) {
  if (!parameters.mesh.empty())
    return fmt::format("tetrahedron number {} in the file, counting only tetrahedra", element + 1);
  Vec3 place = Vec3::Constant(-std::numeric_limits<double>::infinity());
  if (mine) place = middle(places(mesh, static_cast<std::size_t>(mesh.local_element(element))));
  mesh.comm.max(std::span<double>(place.data(), 3));
  return fmt::format("a tetrahedron at x = {:.3g}, y = {:.3g}, z = {:.3g} m", place.x(), place.y(),
                     place.z());
}

}  // namespace

// The bound of terms.hpp, element by element, needed for explicit steps only.
// Collective; the same step on all ranks.
double critical_step_of_tetrahedra(const Mesh& mesh, const GroundParameters& parameters,
                                   const Stiffness& stiffness, std::string& limit) {
  double shortest = std::numeric_limits<double>::infinity();
  if (parameters.integrator != Integrator::explicit_) return shortest;
  const Springs springs = springs_below(mesh, parameters);
  Id which = -1;
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    Eigen::MatrixXd k = stiffness.matrix(mesh, z);
    if (const auto on = springs.find(z); on != springs.end()) k.diagonal() += on->second;
    const double step = step_of(mesh, z, std::move(k), shortest);
    if (step < shortest) shortest = step, which = mesh.element[z];
  }
  const double least = -mesh.comm.max(-shortest);
  // Several ranks may hold it; the lowest number is reported.
  const Id found = shortest == least ? which : mesh.element_count();
  const Id lowest = -mesh.comm.max(-found);
  limit = name_of(mesh, parameters, lowest, found == lowest);
  return least;
}

}  // namespace trackbed::fem
