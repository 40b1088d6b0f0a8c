// Masses, borders and the critical step of a ground of tetrahedra.
//
// Masses are lumped as tetrahedron_mass_share says: above 0 everywhere, so that explicit steps are
// possible, and the same in implicit ones. Weight and border terms are what the shape functions
// carry: uniform weight leaves a column in the state of stress it has. On a six-node face that is a
// third of the area, weighed by the Jacobian there, amid each edge, and nothing at corners.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>

#include "terms.hpp"
#include "tetrahedron.hpp"

namespace trackbed::fem {

namespace {

TenNodes places(const Mesh& mesh, std::size_t zone) {
  TenNodes nodes;
  for (int k = 0; k < 10; ++k)
    nodes[static_cast<std::size_t>(k)] = mesh.position(mesh.corner(zone, k));
  return nodes;
}

Vec3 middle(const TenNodes& nodes) { return (nodes[0] + nodes[1] + nodes[2] + nodes[3]) / 4; }

// Shares, m^2, of the nodes 3, 4 and 5 of a face.
//   dx/d(xi, eta) there with N_0 = l_0 (2 l_0 - 1), ..., N_3 = 4 l_0 l_1, ...; weights 1/6.
Vec3 areas(const std::array<Vec3, 6>& x) {
  // Shares of the corners at the nodes 3, 4, 5.
  const std::array<Vec3, 3> at = {Vec3(0.5, 0.5, 0), Vec3(0, 0.5, 0.5), Vec3(0.5, 0, 0.5)};
  Vec3 found;
  for (int m = 0; m < 3; ++m) {
    const Vec3& l = at[static_cast<std::size_t>(m)];
    // d/dl_i with the three shares as if they were independent; xi = l_1, eta = l_2, l_0 the rest.
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

// Of one face: which nodes, and their shares of its area.
struct FaceShare {
  std::array<std::int32_t, 6> node;
  Vec3 area;  // m^2, of the last three
};
FaceShare share_of(const Mesh& mesh, const Imported::Face& face) {
  FaceShare share;
  std::array<Vec3, 6> x;
  for (std::size_t k = 0; k < 6; ++k) {
    const int local = tetrahedron_faces[static_cast<std::size_t>(face.side)][k];
    share.node[k] = mesh.corner(static_cast<std::size_t>(face.zone), local);
    x[k] = mesh.position(share.node[k]);
  }
  share.area = areas(x);
  return share;
}

const Elastic& solid_of(const Mesh& mesh, std::int32_t zone) {
  const std::int32_t solid = mesh.solid[static_cast<std::size_t>(zone)];
  return mesh.solids.solid[static_cast<std::size_t>(solid)];
}

// A quiet face that looks down is a base: it has springs. Pa/m.
double spring_of(const Mesh& mesh, const GroundParameters& parameters, const Imported::Face& face) {
  if (face.axis != 2 || !face.low) return 0;
  return base_spring(parameters, solid_of(mesh, face.zone), mesh.imported->depth);
}

struct Builder {
  const Mesh& mesh;
  const GroundParameters& parameters;
  Terms& terms;

  void hold(const FaceShare& share, std::vector<std::uint8_t>& held, int bits) const {
    for (const std::int32_t n : share.node)
      held[static_cast<std::size_t>(n)] |= static_cast<std::uint8_t>(bits);
  }
  // Dashpots; at rest as in terms.cpp: a base is held unless springs carry it, a side is a roller.
  void quiet(const Imported::Face& face, const FaceShare& share) const {
    const bool base = face.axis == 2 && face.low;
    const double spring = spring_of(mesh, parameters, face);
    const Impedance of = impedance(solid_of(mesh, face.zone), false);
    if (!base || spring == 0) hold(share, terms.held_at_rest, base ? 7 : 1 << face.axis);
    for (int m = 0; m < 3; ++m) {
      const std::int32_t node = share.node[static_cast<std::size_t>(3 + m)];
      for (int c = 0; c < 3; ++c)
        terms.damping[c][node] += share.area[m] * (c == face.axis ? of.normal : of.tangential);
      if (spring > 0) terms.springs.push_back({node, spring * share.area[m]});
    }
  }
  void border(const Imported::Face& face) const {
    const FaceShare share = share_of(mesh, face);
    if (face.holds == BorderKind::quiet) return quiet(face, share);
    if (face.holds == BorderKind::free) return;
    const int bits = face.holds == BorderKind::fixed ? 7 : 1 << face.axis;
    hold(share, terms.held, bits), hold(share, terms.held_at_rest, bits);
  }
};

}  // namespace

// Zones, then faces, both ascending: the same bits on any number of ranks.
void Terms::add_tetrahedra(const Mesh& mesh, const GroundParameters& parameters) {
  carried.assign(mesh.nodes(), 0.0);
  for (std::size_t z = 0; z < mesh.zone.size(); ++z) {
    const Elastic& solid = solid_of(mesh, static_cast<std::int32_t>(z));
    const TenNumbers load = tetrahedron_load(places(mesh, z));
    const double whole = solid.density * load.sum();  // kg
    for (int k = 0; k < 10; ++k) {
      const std::int32_t node = mesh.corner(z, k);
      const double share = whole * tetrahedron_mass_share(k);
      mass[static_cast<std::size_t>(node)] += share;
      carried[static_cast<std::size_t>(node)] += solid.density * load[k];
      for (int c = 0; c < 3; ++c)
        damping[c][node] += (solid.rayleigh_mass - parameters.rayleigh_mass) * share;
    }
  }
  const Builder builder{mesh, parameters, *this};
  for (const Imported::Face& face : mesh.imported->borders) builder.border(face);
  for (int c = 0; c < 3; ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n)
      damping[c][n] += parameters.rayleigh_mass * mass[n];
  merge(springs);
}

// Faces in ascending order, as above.
std::vector<BasePart> quiet_base(const Mesh& mesh) {
  std::vector<BasePart> parts;
  for (const Imported::Face& face : mesh.imported->borders) {
    if (face.holds != BorderKind::quiet || face.axis != 2 || !face.low) continue;
    const FaceShare share = share_of(mesh, face);
    const Impedance of = impedance(solid_of(mesh, face.zone), false);
    for (int m = 0; m < 3; ++m) {
      const double across = share.area[m] * of.tangential, along = share.area[m] * of.normal;
      parts.push_back({share.node[static_cast<std::size_t>(3 + m)], {across, across, along}});
    }
  }
  return parts;
}

namespace {

using Springs = std::map<std::size_t, Eigen::VectorXd>;  // N/m on an element's freedoms, by zone

// Springs on nodes of an element, from its faces on a quiet base.
Springs springs_below(const Mesh& mesh, const GroundParameters& parameters) {
  Springs springs;
  for (const Imported::Face& face : mesh.imported->borders) {
    const double spring = spring_of(mesh, parameters, face);
    if (face.holds != BorderKind::quiet || spring == 0) continue;
    const auto zone = static_cast<std::size_t>(face.zone);
    auto& on = springs.try_emplace(zone, Eigen::VectorXd::Zero(30)).first->second;
    const FaceShare share = share_of(mesh, face);
    for (int m = 0; m < 3; ++m) {
      const auto& local = tetrahedron_faces[static_cast<std::size_t>(face.side)];
      on.segment<3>(3 * local[static_cast<std::size_t>(3 + m)]).array() += spring * share.area[m];
    }
  }
  return springs;
}

// s, of central differences with the damping by stiffness.
double step_of(const Mesh& mesh, std::size_t z, Eigen::MatrixXd k) {
  const Elastic& solid = solid_of(mesh, static_cast<std::int32_t>(z));
  const double whole = solid.density * tetrahedron_volume(places(mesh, z));
  Eigen::VectorXd root(30);
  for (int f = 0; f < 30; ++f) root[f] = 1 / std::sqrt(whole * tetrahedron_mass_share(f / 3));
  k = (root.asDiagonal() * k * root.asDiagonal()).eval();
  const double squared = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k, Eigen::EigenvaluesOnly)
                             .eigenvalues()
                             .maxCoeff();
  const double omega = std::sqrt(squared), damped = 0.5 * solid.rayleigh_stiffness * omega;
  return 2 / omega * (std::sqrt(1 + damped * damped) - damped);
}

// Collective: the element by its number in the file, or by where it is if there is no file.
std::string name_of(const Mesh& mesh, const GroundParameters& parameters, Id zone, bool mine) {
  if (!parameters.mesh.empty()) return fmt::format("tetrahedron {} of the file", zone + 1);
  Vec3 place = Vec3::Constant(-std::numeric_limits<double>::infinity());
  if (mine) place = middle(places(mesh, static_cast<std::size_t>(mesh.local_zone(zone))));
  mesh.comm.max(std::span<double>(place.data(), 3));
  return fmt::format("a tetrahedron at x = {:.3g}, y = {:.3g}, z = {:.3g} m", place.x(), place.y(),
                     place.z());
}

}  // namespace

// The bound of terms.hpp, element by element: some 50 us each, which only explicit steps need.
// Collective; the same step on all ranks.
double critical_step_of_tetrahedra(const Mesh& mesh, const GroundParameters& parameters,
                                   const Stiffness& stiffness, std::string& limit) {
  double shortest = std::numeric_limits<double>::infinity();
  if (parameters.integrator != Integrator::explicit_) return shortest;
  const Springs springs = springs_below(mesh, parameters);
  Id which = -1;
  for (std::size_t z = 0; z < mesh.zone.size(); ++z) {
    Eigen::MatrixXd k = stiffness.matrix(mesh, z);
    if (const auto on = springs.find(z); on != springs.end()) k.diagonal() += on->second;
    const double step = step_of(mesh, z, std::move(k));
    if (step < shortest) shortest = step, which = mesh.zone[z];
  }
  const double least = -mesh.comm.max(-shortest);
  // Each rank may hold it; the lowest number is said.
  const Id found = shortest == least ? which : mesh.zone_count();
  const Id lowest = -mesh.comm.max(-found);
  limit = name_of(mesh, parameters, lowest, found == lowest);
  return least;
}

}  // namespace trackbed::fem
