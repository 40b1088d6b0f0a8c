// Solid bodies under weight, loads and contact forces, solved redundantly on every rank.
#include <fmt/format.h>

#include <map>
#include <numeric>

#include "fem/bodies/bodies_impl.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// rad: with small-displacement strains a rotation t stretches a body by t^2/2, here 0.1 %.
constexpr double largest_turn = 0.05;

std::vector<BodyMesh> meshes_of(const std::vector<Body>& bodies) {
  std::vector<BodyMesh> meshes;
  std::int32_t first = 0;
  for (const Body& body : bodies) {
    meshes.emplace_back(body, first);
    first += meshes.back().nodes();
  }
  return meshes;
}

Vec3 sum_of(const NodeWeights& at, const BodiesSystem& system, const BodiesSystem::Vector& values) {
  Vec3 sum = Vec3::Zero();
  for (const NodeWeight& one : at) sum += one.weight * system.of(values, one.node);
  return sum;
}

}  // namespace

// With m the consistent mass: linear momentum is e_c . m v, and the angular one about the centre
//   L_k = sum (r x m v)_k = sum v . m (e_k x r),
// so both are sums over nodes with weights that do not change.
Bodies::Impl::RigidWeights Bodies::Impl::rigid_weights(const BodyMesh& mesh) {
  RigidWeights weights;
  const auto nodes = static_cast<std::size_t>(mesh.nodes());
  weights.fraction.assign(nodes, 0);
  for (auto& turn : weights.turn) turn.assign(nodes, Vec3::Zero());
  const double fraction = 1 / static_cast<double>(mesh.elements());
  const Vec3 inertia = mesh.inertia() / mesh.mass();
  for (std::int64_t e = 0; e < mesh.elements(); ++e) {
    const auto corners = mesh.corners(e);
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) {
        const auto node =
            static_cast<std::size_t>(corners[static_cast<std::size_t>(a)] - mesh.first);
        const double mass = fraction * mass_fraction(a, b);
        const Vec3 arm = mesh.position(corners[static_cast<std::size_t>(b)]) - mesh.centre();
        weights.fraction[node] += mass;
        for (int k = 0; k < 3; ++k)
          weights.turn[static_cast<std::size_t>(k)][node] +=
              mass / inertia[k] * Vec3::Unit(k).cross(arm);
      }
  }
  return weights;
}

Bodies::Impl::Impl(const BodiesParameters& given)
    : parameters(given), meshes(meshes_of(given.bodies)), system(meshes, given) {
  for (std::size_t b = 0; b < meshes.size(); ++b) {
    rigid.push_back(rigid_weights(meshes[b]));
    if (!meshes[b].body.touched) continue;
    touched.push_back(b);
    surfaces.push_back(surface_of(meshes[b], node_of.emplace_back()));
  }
}

Vec3 Bodies::Impl::mean(std::size_t body, const BodiesSystem::Vector& values) const {
  Vec3 sum = Vec3::Zero();
  const std::vector<double>& fraction = rigid[body].fraction;
  for (std::size_t n = 0; n < fraction.size(); ++n)
    sum += fraction[n] * system.of(values, meshes[body].first + static_cast<std::int32_t>(n));
  return sum;
}

Vec3 Bodies::Impl::turn(std::size_t body, const BodiesSystem::Vector& values) const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t n = 0; n < rigid[body].fraction.size(); ++n) {
    const Vec3 value = system.of(values, meshes[body].first + static_cast<std::int32_t>(n));
    for (int k = 0; k < 3; ++k)
      sum[k] += rigid[body].turn[static_cast<std::size_t>(k)][n].dot(value);
  }
  return sum;
}

Bodies::Bodies(const BodiesParameters& parameters) : impl_(std::make_unique<Impl>(parameters)) {
  show_at_rest();
}
Bodies::~Bodies() = default;
Bodies::Bodies(Bodies&&) noexcept = default;

std::size_t Bodies::count() const { return impl_->meshes.size(); }
double Bodies::mass(std::size_t body) const { return impl_->meshes.at(body).mass(); }
Vec3 Bodies::centre(std::size_t body) const { return impl_->meshes.at(body).centre(); }
Vec3 Bodies::origin() const { return impl_->origin; }
std::vector<Surface>& Bodies::surfaces() { return impl_->surfaces; }

void Bodies::place(const Vec3& origin) {
  impl_->origin = origin;
  impl_->system.reset();
  show_at_rest();
}

void Bodies::show_at_rest() {
  Impl& impl = *impl_;
  for (std::size_t s = 0; s < impl.surfaces.size(); ++s)
    for (std::size_t n = 0; n < impl.node_of[s].size(); ++n) {
      const std::int32_t node = impl.node_of[s][n];
      impl.surfaces[s].position[n] = impl.origin + impl.meshes[impl.touched[s]].position(node) +
                                     impl.system.of(impl.system.displacement, node);
      impl.surfaces[s].motion[n].setZero();
    }
}

// Weights of the same node are summed, so that each node occurs once.
NodeWeights Bodies::over(std::size_t body, Side side, const Patch& patch) const {
  const auto points = BodyMesh::points(patch);
  std::map<std::int32_t, double> sum;
  for (const auto& [x, y] : points)
    for (const NodeWeight& one : impl_->meshes.at(body).at(side, x, y))
      sum[one.node] += one.weight / static_cast<double>(points.size());
  NodeWeights weights;
  for (const auto& [node, weight] : sum)
    if (weight != 0) weights.push_back({node, weight});
  return weights;
}

// The weight is applied with the consistent mass, as the inertia is: free fall has no strain.
void Bodies::advance(double dt, double gravity, std::span<const PatchLoad> loads,
                     const std::vector<std::span<const Vec3>>& node_force) {
  Impl& impl = *impl_;
  require(node_force.empty() || node_force.size() == impl.surfaces.size(),
          "one list of node forces per surface");
  BodiesSystem::Vector& force = impl.cleared_force();
  for (std::size_t b = 0; b < impl.meshes.size(); ++b)
    for (std::int32_t n = 0; n < impl.meshes[b].nodes(); ++n)
      impl.system.add(
          impl.meshes[b].first + n,
          {0, 0,
           -gravity * impl.meshes[b].mass() * impl.rigid[b].fraction[static_cast<std::size_t>(n)]},
          force);
  for (const PatchLoad& load : loads)
    for (const NodeWeight& one : load.at) impl.system.add(one.node, one.weight * load.force, force);
  for (std::size_t s = 0; s < node_force.size(); ++s)
    for (std::size_t n = 0; n < node_force[s].size(); ++n)
      impl.system.add(impl.node_of[s][n], node_force[s][n], force);
  show_at_rest();
  impl.change = -impl.system.displacement;
  impl.system.step(dt, force);
  impl.change += impl.system.displacement;
  for (std::size_t s = 0; s < impl.surfaces.size(); ++s)
    for (std::size_t n = 0; n < impl.node_of[s].size(); ++n)
      impl.surfaces[s].motion[n] = impl.system.of(impl.change, impl.node_of[s][n]);
}

// Bodies are linear: the response to the loads is added to the motion, also to that of the
// surfaces.
void Bodies::add_loads(std::span<const PatchLoad> loads) {
  Impl& impl = *impl_;
  BodiesSystem::Vector& force = impl.cleared_force();
  for (const PatchLoad& load : loads)
    for (const NodeWeight& one : load.at) impl.system.add(one.node, one.weight * load.force, force);
  impl.change = -impl.system.displacement;
  impl.system.add(force);
  impl.change += impl.system.displacement;
  for (std::size_t s = 0; s < impl.surfaces.size(); ++s)
    for (std::size_t n = 0; n < impl.node_of[s].size(); ++n)
      impl.surfaces[s].motion[n] += impl.system.of(impl.change, impl.node_of[s][n]);
}

double Bodies::mobility(double dt, const NodeWeights& of, const NodeWeights& by) {
  BodiesSystem& system = impl_->system;
  const auto spread = [&](const NodeWeights& over) {
    BodiesSystem::Vector& all = impl_->cleared_force();
    for (const NodeWeight& one : over) system.add(one.node, {0, 0, one.weight}, all);
    return all;
  };
  const BodiesSystem::Vector rate = system.mobility(dt, spread(by));
  return spread(of).dot(rate);
}

Vec3 Bodies::trapezoidal(double dt, const NodeWeights& at) const {
  const BodiesSystem& system = impl_->system;
  return displacement(at) - system.beyond_trapezoid(dt) * sum_of(at, system, system.acceleration);
}

Vec3 Bodies::displacement(const NodeWeights& at) const {
  return sum_of(at, impl_->system, impl_->system.displacement);
}

Vec3 Bodies::velocity(const NodeWeights& at) const {
  return sum_of(at, impl_->system, impl_->system.velocity);
}

BodyMotion Bodies::motion(std::size_t body) const {
  const BodiesSystem& system = impl_->system;
  return {impl_->mean(body, system.displacement), impl_->mean(body, system.velocity),
          impl_->mean(body, system.acceleration), impl_->turn(body, system.displacement),
          impl_->turn(body, system.velocity)};
}

Vec3 Bodies::pad_force(std::size_t pad) const {
  const Pad& p = impl_->parameters.pads.at(pad);
  const NodeWeights below = over(p.below, Side::upper, p.patch),
                    above = over(p.above, Side::lower, p.patch);
  return p.stiffness.cwiseProduct(displacement(below) - displacement(above)) +
         p.damping.cwiseProduct(velocity(below) - velocity(above));
}

// The bending moment of an element is that of its middle: at a border between two bending elements,
// one side alone would have an error of half of the change over an element.
std::array<double, 6> Bodies::stress(std::size_t body, const Vec3& place) const {
  const BodyMesh& mesh = impl_->meshes.at(body);
  const std::vector<BodyMesh::Place> around = mesh.around(place);
  Eigen::Matrix<double, 6, 1> stress = Eigen::Matrix<double, 6, 1>::Zero();
  for (const BodyMesh::Place& found : around) {
    const auto corners = mesh.corners(found.element);
    Eigen::Matrix<double, 24, 1> u;
    for (int k = 0; k < 8; ++k)
      u.segment<3>(3 * k) =
          impl_->system.of(impl_->system.displacement, corners[static_cast<std::size_t>(k)]);
    stress += mesh.hexahedron.stress(found.xi) * u / static_cast<double>(around.size());
  }
  std::array<double, 6> all;
  std::copy_n(stress.data(), 6, all.begin());
  return all;
}

BodiesTotals Bodies::totals() const {
  const BodiesSystem& system = impl_->system;
  BodiesTotals totals;
  for (const BodyMesh& mesh : impl_->meshes) totals.elements += mesh.elements();
  totals.unknowns = static_cast<std::int64_t>(system.unknowns());
  totals.factor = system.factor();
  totals.kinetic = system.kinetic();
  totals.elastic = system.elastic();
  return totals;
}

std::size_t Bodies::memory() const {
  constexpr std::size_t entry = sizeof(double) + sizeof(int);
  const auto numbers = [](const auto& matrix) {
    return static_cast<std::size_t>(matrix.nonZeros());
  };
  const BodiesSystem& system = impl_->system;
  return entry * (numbers(system.mass()) + numbers(system.damping()) + numbers(system.stiffness()) +
                  static_cast<std::size_t>(system.factor()));
}

std::string Bodies::trouble() const {
  for (std::size_t b = 0; b < count(); ++b) {
    const BodiesSystem::Vector& moved = impl_->system.displacement;
    const std::string& name = impl_->meshes[b].body.name;
    const double turned = impl_->turn(b, moved).norm();
    if (!impl_->mean(b, moved).allFinite())
      return fmt::format(
          "the position of {} is not a number; use a smaller time.step or dem.safety, or a shorter "
          "time.window",
          name);
    if (turned > largest_turn)
      return fmt::format(
          "{} has turned by {:.3g} rad; the model assumes small displacements and allows at most "
          "{:g} rad; use smaller loads or a stiffer support",
          name, turned, largest_turn);
  }
  return "";
}

}  // namespace trackbed::fem
