// Bending sleepers. Their ballast is distributed over their length except the unsupported middle
// and integrated with the shape functions of w, so that its limits need not be nodes. A plane track
// has the left half, without rotation in the middle (symmetry).
//
// Seats are nodes, so that pads and heights below the rails are treated as for rigid sleepers. In
// the run-in the stiffness of sleepers increases like all others, otherwise they would be its soft
// part.
#include "track/line/sleeper_beam.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "track/line/line_impl.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

constexpr double same_multiple = 1e-9;  // relative, of lengths that should be multiples

// Adds nodes of `count` equal elements up to `to`.
void divide(std::vector<double>& nodes, double to, std::int64_t count) {
  const double from = nodes.back();
  for (std::int64_t i = 1; i <= count; ++i)
    nodes.push_back(from + (to - from) * static_cast<double>(i) / static_cast<double>(count));
}

}  // namespace

// Elements beyond the rails are not longer than those between.
SleeperMesh::SleeperMesh(const TrackParameters& track)
    : whole(track.sleeper_length), ballast((whole - track.sleeper.unsupported) / 2), from_end{0} {
  const double gauge = track.gauge, overhang = (whole - gauge) / 2;
  require(overhang > 0, "sleepers are longer than the gauge");
  const double size = gauge / static_cast<double>(track.sleeper.elements);
  const auto beyond =
      std::max<std::int64_t>(1, std::llround(std::ceil(overhang / size - same_multiple)));
  divide(from_end, overhang, beyond);
  seat[0] = from_end.size() - 1;
  if (track.dimension == Dimension::plane) {
    divide(from_end, whole / 2, track.sleeper.elements / 2);
    return;
  }
  divide(from_end, overhang + gauge, track.sleeper.elements);
  seat[1] = from_end.size() - 1;
  divide(from_end, whole, beyond);
}

std::size_t SleeperMesh::element_at(double s) const {
  const auto after = std::upper_bound(from_end.begin() + 1, from_end.end() - 1, s);
  return static_cast<std::size_t>(after - from_end.begin()) - 1;
}

std::size_t SleeperMesh::nearest_node(double s) const {
  const std::size_t e = element_at(s);
  return s - from_end[e] < from_end[e + 1] - s ? e : e + 1;
}

std::array<double, 2> SleeperMesh::on_ballast(std::size_t e) const {
  const double begin = from_end[e], end = from_end[e + 1];
  const double from = side(e) == 0 ? begin : std::max(begin, whole - ballast);
  const double to = side(e) == 0 ? std::min(end, ballast) : end;
  if (to <= from) return {0, 0};
  return {(from - begin) / (end - begin), (to - begin) / (end - begin)};
}

// Constant rectangular cross-section: shear coefficient 5/6, rotary inertia m h^2/12.
Beam sleeper_beam(const TrackParameters& track) {
  const SleeperBeamParameters& sleeper = track.sleeper;
  const double area = sleeper.width * sleeper.height,
               mass = track.sleeper_mass / track.sleeper_length;
  const double square = sleeper.height * sleeper.height / 12;  // m^2, of the radius of gyration
  Beam beam{.bending_stiffness = sleeper.young * area * square, .mass = mass};
  if (sleeper.theory == BeamTheory::euler) return beam;
  beam.shear_stiffness = 5.0 / 6 * sleeper.young / (2 * (1 + sleeper.poisson)) * area;
  beam.rotary_inertia = mass * square;
  return beam;
}

// f = (4.730)^2/(2 pi L^2) sqrt(E I/m), the first root of cos b L cosh b L = 1.
double bending_frequency(const TrackParameters& track) {
  const Beam beam = sleeper_beam(track);
  const double root = 4.730040744862704 / track.sleeper_length;
  return root * root / (2 * std::numbers::pi) * std::sqrt(beam.bending_stiffness / beam.mass);
}

// The middle of a half sleeper does not rotate.
void Line::Impl::number_across(Sleeper& sleeper) {
  for (std::size_t n = 0; n < mesh->from_end.size(); ++n) {
    const bool held = sides == 1 && n + 1 == mesh->from_end.size();
    const std::int32_t w = unknowns++;
    sleeper.across.push_back({w, held ? -1 : unknowns++});
  }
  for (std::size_t side = 0; side < sides; ++side)
    sleeper.unknown[side] = sleeper.across[mesh->seat[side]][0];
}

BeamElement Line::Impl::across_element(const Sleeper& sleeper, std::size_t e) const {
  Beam beam = sleeper_beam(parameters.track);
  const double heavier = zone_factor(&TrackZone::sleeper, sleeper.x);
  beam.mass *= heavier;
  beam.rotary_inertia *= heavier;
  beam.bending_stiffness *= run_in(sleeper.x);
  beam.shear_stiffness *= run_in(sleeper.x);
  return {beam, mesh->length(e)};
}

std::array<std::int32_t, 4> Line::Impl::unknowns_across(const Sleeper& sleeper,
                                                        std::size_t e) const {
  const RailNode &one = sleeper.across[e], &other = sleeper.across[e + 1];
  return {one[0], one[1], other[0], other[1]};
}

// N/m^2, N s/m^2, below an element.
std::array<double, 2> Line::Impl::bed_across(const Sleeper& sleeper, std::size_t e) const {
  const double factor = bed_factor(sleeper.x, mesh->side(e)) / mesh->ballast;
  return {parameters.ballast.stiffness * factor, parameters.ballast.damping * factor};
}

void Line::Impl::add_across(std::size_t index) {
  const Sleeper& sleeper = sleepers[index];
  for (std::size_t e = 0; e < mesh->elements(); ++e) {
    const BeamElement element = across_element(sleeper, e);
    const auto [bed, damper] = bed_across(sleeper, e);
    const bool hangs = parameters.track.gap(sleeper.x, mesh->side(e)) > 0;
    const Matrix4 below = hangs ? Matrix4::Zero().eval() : element.bed(mesh->on_ballast(e));
    add_element(unknowns_across(sleeper, e), element.mass(), damper * below,
                element.stiffness() + bed * below);
    if (hangs) add_gap_across(index, e);
  }
  for (std::size_t side = 0; side < sides; ++side) add_ground_across(index, side);
}

// Gap below the sleeper: stops at the two Gauss points of each element, exact for a uniform force
// of the bed.
void Line::Impl::add_gap_across(std::size_t index, std::size_t e) {
  const Sleeper& sleeper = sleepers[index];
  const BeamElement element = across_element(sleeper, e);
  const auto [from, to] = mesh->on_ballast(e);
  const auto [bed, damper] = bed_across(sleeper, e);
  const double half = (to - from) / 2, carried = half * mesh->length(e);
  if (carried <= 0) return;
  for (const double at : {-1 / std::sqrt(3.0), 1 / std::sqrt(3.0)}) {
    const Four shape = -element.deflection(from + half * (1 + at));
    RailPoint point{.unknown = unknowns_across(sleeper, e)};
    for (std::size_t k = 0; k < 4; ++k) point.value[k] = shape[static_cast<Eigen::Index>(k)];
    stops.push_back(
        {point, parameters.track.gap(sleeper.x, mesh->side(e)), bed * carried, damper * carried});
  }
}

// Height of the ground at the left and the right end of an element per height at the spring of a
// side: 1 on one rail; on two rails, between which the ground is a straight line,
//   phi(y) = (1 +- y/d)/2,   d the arm of the springs, y m to the left of the middle.
std::array<double, 2> Line::Impl::ground_shape_across(std::size_t e, std::size_t side) const {
  if (sides == 1) return {1, 1};
  const double arm = (side == 0 ? 1 : -1) * parameters.track.bearing_arm();
  const auto at = [&](double s) { return (1 + (mesh->whole / 2 - s) / arm) / 2; };
  return {at(mesh->from_end[e]), at(mesh->from_end[e + 1])};
}

// Force of all ballast, of stiffness k per length at heights w, on the ground. On two rails the
// force at a side is the work-equivalent one,
//   integral of k phi (g - w) = K g - integral of k phi w,   K = integral of k phi^2,
// g the height of the ground there; the coupling to the other side, integral of k phi_l phi_r,
// vanishes with this arm.
void Line::Impl::add_ground_across(std::size_t index, std::size_t side) {
  Sleeper& sleeper = sleepers[index];
  for (std::size_t one = 0; one < sides; ++one)
    if (parameters.track.gap(sleeper.x, one) > 0) return;
  Kelvin& lowest = sleeper.lowest[side];
  std::map<std::int32_t, double> on;
  for (std::size_t e = 0; e < mesh->elements(); ++e) {
    const auto [from, to] = mesh->on_ballast(e);
    const auto [bed, damper] = bed_across(sleeper, e);
    const std::array<double, 2> ends = ground_shape_across(e, side);
    const auto phi = [&](double xi) { return ends[0] + (ends[1] - ends[0]) * xi; };
    const double a = phi(from), b = phi(to);
    const double square = (to - from) * mesh->length(e) * (a * a + a * b + b * b) / 3;
    lowest.stiffness += bed * square, lowest.damping += damper * square;
    const Four force = bed * across_element(sleeper, e).area({from, to}, ends);
    const auto unknown = unknowns_across(sleeper, e);
    for (std::size_t k = 0; k < 4; ++k)
      if (unknown[k] >= 0) on[unknown[k]] += force[static_cast<Eigen::Index>(k)];
  }
  for (const auto& [unknown, force] : on)
    if (force != 0) sleeper.on[side].emplace_back(unknown, force / lowest.stiffness);
}

bool Line::sleepers_bend() const { return impl_->mesh.has_value(); }

// For rigid sleepers linear between the heights below the rails.
RailPoint Line::sleeper_at(std::size_t i, double y) const {
  const Impl& impl = *impl_;
  const Sleeper& sleeper = impl.sleepers.at(i);
  RailPoint point;
  if (!impl.mesh) {
    const double aside = impl.sides == 1 ? 0.5 : y / impl.parameters.track.gauge;
    point.unknown = {sleeper.unknown[0], sleeper.unknown[1], -1, -1};
    point.value = {0.5 + aside, 0.5 - aside, 0, 0};
    return point;
  }
  const SleeperMesh& mesh = *impl.mesh;
  const double s = mesh.whole / 2 - (impl.sides == 1 ? std::abs(y) : y);
  const std::size_t e = mesh.element_at(s);
  const BeamElement element = impl.across_element(sleeper, e);
  const double xi = (s - mesh.from_end[e]) / mesh.length(e);
  const Four shape = element.deflection(xi);
  point.unknown = impl.unknowns_across(sleeper, e);
  for (std::size_t k = 0; k < 4; ++k) point.value[k] = shape[static_cast<Eigen::Index>(k)];
  point.local = element.local_flexibility(xi);
  return point;
}

// Mean of the elements on both sides, including ballast between nodes; inertia forces and stops
// between nodes are not included, which leaves an error of order h^2 in the mean.
double Line::sleeper_moment(std::size_t i, double y, const Vector& u) const {
  const Impl& impl = *impl_;
  require(impl.mesh.has_value(), "bending moments are those of bending sleepers");
  const SleeperMesh& mesh = *impl.mesh;
  const Sleeper& sleeper = impl.sleepers.at(i);
  const auto ends = [&](std::size_t e) -> Four {
    const BeamElement element = impl.across_element(sleeper, e);
    Matrix4 k = element.stiffness();
    if (impl.parameters.track.gap(sleeper.x, mesh.side(e)) == 0)
      k += impl.bed_across(sleeper, e)[0] * element.bed(mesh.on_ballast(e));
    const auto unknown = impl.unknowns_across(sleeper, e);
    Four at = Four::Zero();
    for (std::size_t n = 0; n < 4; ++n)
      if (unknown[n] >= 0) at[static_cast<Eigen::Index>(n)] = u[unknown[n]];
    return k * at;
  };
  const std::size_t node = mesh.nearest_node(mesh.whole / 2 - (impl.sides == 1 ? std::abs(y) : y));
  require(node > 0, "bending moments are evaluated at inner nodes of a sleeper");
  const double left = ends(node - 1)[3];
  return node == mesh.elements() ? left : (left - ends(node)[1]) / 2;
}

}  // namespace trackbed::track
