// Stones with corners that are overloaded: they split, or a corner of theirs is crushed; and those
// that have worn.
//
// Every few sub-steps the contacts of each stone give its mean stress (Weber 1966; Bagi 1996,
// doi:10.1016/0167-6636(95)00044-5) and the pressure at its corners. The owner of a stone knows all
// of its contacts, in the same order on any rank, and decides where it breaks; all ranks cut it at
// the begin of the next window (cut_off.cpp).
//
// Cost: at each check one pass over all contacts, and another one if a stone may break; about two
// sub-steps.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "dem/particles/contact_loop.hpp"
#include "dem/shape/core.hpp"
#include "trackbed/core/decompositions.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::dem {

namespace {

struct Plane {
  Vec3 normal;
  double offset;  // m
};

// Draws for the same stone are independent of each other.
enum class Draw : std::uint64_t { splitting = 1, cutting = 2 };

double weibull_of(const BreakageParameters& p, Draw draw, std::int64_t key, double modulus) {
  const auto seed = mix(static_cast<std::uint64_t>(p.seed)) + static_cast<std::uint64_t>(draw);
  return weibull_factor(seed, static_cast<std::uint64_t>(key), modulus);
}

// Pa, compression positive, from minus the sum of force x arm over the contacts of a stone (Nm) and
// its volume (m^3).
Mat3 mean_stress(const Mat3& moment, double volume) {
  return (moment + moment.transpose()) / (2 * volume);
}

// Pa: sqrt((s1 - s2)^2 + (s2 - s3)^2 + (s3 - s1)^2)/3 of the principal stresses.
double octahedral(const Mat3& stress) {
  const Mat3 deviator = stress - stress.trace() / 3 * Mat3::Identity();
  return deviator.norm() / std::numbers::sqrt3;
}

double diameter_of(double volume) { return 2 * radius_of(volume); }

// Between the largest force and the one that opposes it most, with the normal in whose direction
// the stone is longest: so the section is small and the parts are compact. The choice of angles
// only limits how exactly the longest direction is found. With one loaded place, or if no force
// opposes the largest one, the plane goes through the centre of mass across the least compressed
// direction.
Plane splitting_plane(const Template& stone, const std::vector<ContactLoad>& loads,
                      const Mat3& stress) {
  constexpr double least_distance = 0.2;  // of the diameter, between the two places
  constexpr int angles = 36;
  const auto largest = std::max_element(
      loads.begin(), loads.end(),
      [](const ContactLoad& a, const ContactLoad& b) { return a.force.norm() < b.force.norm(); });
  const auto against =
      std::min_element(loads.begin(), loads.end(), [&](const ContactLoad& a, const ContactLoad& b) {
        return a.force.dot(largest->force) < b.force.dot(largest->force);
      });
  const Vec3 axis = against->arm - largest->arm;
  const bool opposed = against->force.dot(largest->force) < 0;
  if (!opposed || axis.norm() < least_distance * diameter_of(stone.volume))
    return {symmetric_modes(stress).vectors.col(0), 0};
  const Vec3 first = axis.unitOrthogonal(), second = axis.normalized().cross(first);
  Plane found{first, 0};
  double longest = 0;
  for (int k = 0; k < angles; ++k) {
    const double angle = std::numbers::pi * k / angles;
    const Vec3 normal = std::cos(angle) * first + std::sin(angle) * second;
    const double length = support_of(stone, normal) + support_of(stone, -normal);
    if (length > longest) longest = length, found.normal = normal;
  }
  found.offset = found.normal.dot(largest->arm);
  return found;
}

// The joint of a compound across which there is least compression, if this is less than the mean of
// the principal stresses.
std::optional<Plane> least_compressed_joint(const Template& stone, const Mat3& stress) {
  std::optional<Plane> found;
  double least = stress.trace() / 3;  // compression is positive
  for (const geom::Joint& joint : geom::joints_of(stone)) {
    const double across = joint.normal.dot(stress * joint.normal);
    if (across < least) least = across, found = Plane{joint.normal, joint.offset};
  }
  return found;
}

// Size of a part, of that which the cut gives it, at which it loads nothing more: it is reduced
// about its own centre of mass. `loads`: of the whole stone.
double free_size(const geom::StonePart& part, const Template& whole,
                 const std::vector<ContactLoad>& loads) {
  constexpr double margin = 1.02, least = 0.5;
  double size = 1;
  for (const ContactLoad& load : loads) {
    const double reach = support_of(part.stone, part.axes.conjugate() * load.out);
    const double receded = support_of(whole, load.out) - load.out.dot(part.centre) - reach;
    const double depth = load.overlap - receded;
    if (depth > 0) size = std::min(size, 1 - margin * depth / reach);
  }
  return std::max(size, least);
}

// m^2, of the section of a ball at this depth.
double rounded_area(double radius, double depth) {
  return depth < radius ? std::numbers::pi * depth * (2 * radius - depth)
                        : std::numbers::pi * radius * radius;
}

// m, the smallest of a stone: at any of its corners the section is at least as large as with it.
double least_rounding(const Template& stone) {
  return std::min_element(
             stone.pieces.begin(), stone.pieces.end(),
             [](const geom::Piece& a, const geom::Piece& b) { return a.radius < b.radius; })
      ->radius;
}

// m: depth below the top of a core, across `out`, at which its section, the face of a cut, is this
// large; `deepest` if it is smaller there.
double depth_of_area(const geom::Convex& core, const Vec3& out, double top, double area,
                     double deepest) {
  constexpr int halvings = 40;
  double low = 0, high = deepest;
  if (section_area(core, out, top - high) < area) return high;
  for (int k = 0; k < halvings; ++k) {
    const double middle = (low + high) / 2;
    (section_area(core, out, top - middle) < area ? low : high) = middle;
  }
  return high;
}

// Whether every piece has no more corners than the contact search can number.
bool numbered(const geom::StonePart& part) {
  return std::all_of(
      part.stone.pieces.begin(), part.stone.pieces.end(),
      [](const geom::Piece& piece) { return piece.core.vertices.size() <= most_corners; });
}

void set_plane(Cut& cut, const Plane& plane) {
  for (int k = 0; k < 3; ++k) cut.normal[k] = plane.normal[k];
  cut.offset = plane.offset;
}

// Sets the sizes of both parts; their volumes then, or none if one side has hardly any or too many
// corners.
std::optional<std::array<double, 2>> set_sizes(Cut& cut, const Template& whole,
                                               const std::vector<ContactLoad>& loads) {
  const auto parts = parts_of(whole, cut);
  if (!parts[0] || !parts[1] || !numbered(*parts[0]) || !numbered(*parts[1])) return {};
  std::array<double, 2> volumes{};
  for (std::size_t side = 0; side < 2; ++side) {
    cut.size[side] = free_size(*parts[side], whole, loads);
    volumes[side] = parts[side]->stone.volume * std::pow(cut.size[side], 3);
  }
  return volumes;
}

}  // namespace

double splitting_strength(const BreakageParameters& p, Id stone, std::int64_t splits,
                          double diameter) {
  const SplittingParameters& s = p.splitting;
  const std::int64_t key = piece_key(stone, static_cast<std::size_t>(splits));
  return s.strength * std::pow(diameter / s.diameter, -3 / s.weibull) *
         weibull_of(p, Draw::splitting, key, s.weibull);
}

double cutting_strength(const BreakageParameters& p, Id stone) {
  return p.cutting.strength * weibull_of(p, Draw::cutting, stone, p.cutting.weibull);
}

std::array<std::optional<geom::StonePart>, 2> parts_of(const Template& whole, const Cut& cut) {
  const Vec3 normal(cut.normal[0], cut.normal[1], cut.normal[2]);
  if (static_cast<BreakKind>(cut.kind) == BreakKind::wear)
    return {geom::worn(whole, cut.offset), std::nullopt};
  if (static_cast<BreakKind>(cut.kind) == BreakKind::cut)
    return {part_below(whole, normal, cut.offset), std::nullopt};
  return {part_below(whole, normal, cut.offset), part_below(whole, -normal, -cut.offset)};
}

namespace {

// The stone loses its corner at this contact, so that the new face bears the force. It does not if
// the rest would be too light or have too many corners, or if other pieces of the stone reach
// farther than the contact: the plane would cut them, too.
std::optional<Cut> cut_at(Cut cut, const BreakageParameters& p, const Template& whole,
                          const ContactLoad& load, double scale, double least_volume) {
  const double pressure = cutting_strength(p, cut.stone);
  const double diameter = diameter_of(whole.volume);
  const double force = -load.force.dot(load.out), area = force / pressure / (scale * scale);
  const double least = p.cutting.least_depth * diameter;
  // Most contacts end here: sections are costly.
  if (!(area > rounded_area(least_rounding(whole), least))) return {};
  const geom::Piece* piece = nullptr;  // that reaches farthest
  for (const geom::Piece& each : whole.pieces)
    if (!piece || support_of(each.core, load.out) + each.radius >
                      support_of(piece->core, load.out) + piece->radius)
      piece = &each;
  const double top = support_of(piece->core, load.out);
  if (load.arm.dot(load.out) + load.overlap + least < top + piece->radius) return {};
  if (rounded_area(piece->radius, least) >= area ||
      section_area(piece->core, load.out, top - least) >= area)
    return {};
  const double depth =
      depth_of_area(piece->core, load.out, top, area, p.cutting.largest_depth * diameter);
  set_plane(cut, {load.out, top + piece->radius - depth});
  cut.kind = static_cast<std::int64_t>(BreakKind::cut);
  const auto rest = parts_of(whole, cut)[0];
  if (!rest || !numbered(*rest) || rest->stone.volume < least_volume) return {};
  cut.force = force, cut.stress = pressure, cut.energy = load.energy;
  return cut;
}

// Numbers of contacts, those of the largest normal forces first.
std::vector<std::size_t> by_force(const std::vector<ContactLoad>& loads) {
  std::vector<std::size_t> order(loads.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return loads[a].force.dot(loads[a].out) < loads[b].force.dot(loads[b].out);
  });
  return order;
}

// The stone splits at a joint or between its two largest forces, unless no part would be heavy
// enough.
std::optional<Cut> split_at(Cut cut, const Template& whole, const std::vector<ContactLoad>& loads,
                            const Mat3& stress, double least_volume) {
  cut.kind = static_cast<std::int64_t>(BreakKind::split);
  cut.force = cut.energy = 0;
  for (const ContactLoad& load : loads)
    cut.force = std::max(cut.force, load.force.norm()), cut.energy += load.energy;
  std::optional<std::array<double, 2>> volumes;
  if (const auto joint = least_compressed_joint(whole, stress))
    set_plane(cut, *joint), volumes = set_sizes(cut, whole, loads);
  const Plane plane = splitting_plane(whole, loads, stress);
  if (!volumes) set_plane(cut, plane), volumes = set_sizes(cut, whole, loads);
  if (!volumes) set_plane(cut, {plane.normal, 0}), volumes = set_sizes(cut, whole, loads);
  if (!volumes || std::max((*volumes)[0], (*volumes)[1]) < least_volume) return {};
  return cut;
}

}  // namespace

bool Particles::Impl::may_split(std::size_t b) const {
  return state.material[b] == breaking.material && state.held[b] == 0 &&
         shapes.core(shapes.begin(state.shape[b])).corners.size() > 1;
}

// Of a stone that is to be cut: what does not depend on how.
Cut Particles::Impl::cut_of_stone(std::size_t b) const {
  Cut cut{};
  cut.stone = state.id[b], cut.shape = state.shape[b], cut.scale = state.scale_now(b);
  cut.density = physics.materials[static_cast<std::size_t>(state.material[b])].density;
  cut.size[0] = cut.size[1] = 1;
  return cut;
}

bool Particles::Impl::may_wear(std::size_t b) const {
  return may_split(b) && shapes[state.shape[b]].pieces.size() == 1;
}

// Where a stone breaks, by all of its contacts; none if it does not.
std::optional<Cut> Particles::Impl::cut_of(std::size_t b,
                                           const std::vector<ContactLoad>& loads) const {
  const BreakageParameters& p = breaking.parameters;
  const Template& whole = shapes[state.shape[b]];
  const double scale = state.scale_now(b), volume = whole.volume * scale * scale * scale;
  Mat3 moment = Mat3::Zero();
  for (const ContactLoad& load : loads) moment -= scale * load.force * load.arm.transpose();
  const Mat3 stress = mean_stress(moment, volume);
  Cut cut = cut_of_stone(b);
  const double least_volume = breaking.least_mass / (cut.density * scale * scale * scale);
  cut.stress = octahedral(stress);
  const std::int64_t splits = shapes.label(shapes.begin(state.shape[b]));
  std::optional<Cut> found;
  if (p.splitting.strength > 0 &&
      cut.stress > splitting_strength(p, cut.stone, splits, diameter_of(volume)))
    found = split_at(cut, whole, loads, stress, least_volume);
  if (p.cutting.strength > 0)
    for (const std::size_t k : by_force(loads))
      if (!found) found = cut_at(cut, p, whole, loads[k], scale, least_volume);
  return found;
}

// Own stones that may break, ascending: by sums over their contacts, a little on the safe side, as
// these are rounded otherwise than in `cut_of`.
std::vector<std::size_t> Particles::Impl::suspects(const ContactLoop& contacts) const {
  constexpr double safe = 1 - 1e-9;
  const BreakageParameters& p = breaking.parameters;
  std::vector<Mat3> moments(state.own, Mat3::Zero());
  std::vector<double> forces(state.own, 0.0);  // N, largest normal one
  const auto add = [&](std::size_t b, const Vec3& arm, const Vec3& force, const Vec3& normal) {
    if (b >= state.own) return;
    moments[b] -= force * arm.transpose();
    forces[b] = std::max(forces[b], std::abs(force.dot(normal)));
  };
  contacts.run_known(
      [&](const ContactView& c, double, std::size_t first, std::size_t second, auto...) {
        add(first, c.point - c.first_centre, c.force, c.normal);
        if (second != ContactLoop::no_particle)
          add(second, c.point - c.second_centre, -c.force, c.normal);
      });
  std::vector<std::size_t> found;
  for (std::size_t b = 0; b < state.own; ++b) {
    if (!(forces[b] > 0) || !may_split(b)) continue;
    const Template& whole = shapes[state.shape[b]];
    const double scale = state.scale_now(b), volume = whole.volume * scale * scale * scale;
    const Mat3 stress = mean_stress(moments[b], volume);
    const std::int64_t splits = shapes.label(shapes.begin(state.shape[b]));
    const bool splitting =
        p.splitting.strength > 0 &&
        octahedral(stress) > safe * splitting_strength(p, state.id[b], splits, diameter_of(volume));
    const double least = p.cutting.least_depth * diameter_of(whole.volume);
    const bool cutting = p.cutting.strength > 0 &&
                         forces[b] > safe * cutting_strength(p, state.id[b]) * scale * scale *
                                         rounded_area(least_rounding(whole), least);
    if (splitting || cutting) found.push_back(b);
  }
  return found;
}

void Particles::Impl::find_cuts(int steps_of_window) {
  const BreakageParameters& p = breaking.parameters;
  if (!breaking.active || !p.of_corners() || steps % p.check_steps >= steps_of_window) return;
  if (p.crushes()) find_overloads();
  if (p.wears()) find_worn();
}

// What friction dissipates on stones that may wear, in a sub-step.
void Particles::Impl::add_friction_work() {
  if (!breaking.active || !breaking.parameters.wears()) return;
  for (std::size_t b = 0; b < state.own; ++b)
    if (may_wear(b)) state.rubbed[b] += state.t[b].w;
}

// Stones whose wear has reached a step, unless they break now. A stone that is nearly a ball wears
// no more.
void Particles::Impl::find_worn() {
  const WearParameters& p = breaking.parameters.wear;
  const auto breaks = [&](Id id) {
    return std::any_of(breaking.cuts.begin(), breaking.cuts.end(),
                       [&](const Cut& cut) { return cut.stone == id; });
  };
  for (std::size_t b = 0; b < state.own; ++b) {
    if (!may_wear(b)) {
      state.rubbed[b] = 0;
      continue;
    }
    const double lost = p.coefficient * state.rubbed[b] / p.hardness;
    const Template& whole = shapes[state.shape[b]];
    const double unit = std::pow(state.scale_now(b), 3);
    if (!(lost > p.step * whole.volume * unit) || breaks(state.id[b])) continue;
    Cut cut = cut_of_stone(b);
    cut.kind = static_cast<std::int64_t>(BreakKind::wear), cut.offset = lost / unit;
    if (parts_of(whole, cut)[0])
      breaking.cuts.push_back(cut);
    else
      state.rubbed[b] = 0;
  }
}

void Particles::Impl::find_overloads() {
  const ContactLoop contacts(*this);
  const std::vector<std::size_t> stones = suspects(contacts);
  if (stones.empty()) return;
  std::unordered_map<std::size_t, std::vector<ContactLoad>> loads;
  for (const std::size_t b : stones) loads[b];
  const auto take = [&](std::size_t b, const ContactView& c, const Vec3& centre, double side,
                        double energy) {
    const auto found = b < state.own ? loads.find(b) : loads.end();
    if (found == loads.end()) return;
    const Quat back = quat(state.q[b]).conjugate();
    const double scale = state.scale_now(b);
    found->second.push_back({back * Vec3(c.point - centre) / scale, back * Vec3(side * c.normal),
                             back * Vec3(side * c.force), c.overlap / scale, energy});
  };
  contacts.run_known(
      [&](const ContactView& c, double energy, std::size_t first, std::size_t second, auto...) {
        take(first, c, c.first_centre, 1, energy);
        if (second != ContactLoop::no_particle) take(second, c, c.second_centre, -1, energy);
      });
  for (const std::size_t b : stones)
    if (const auto cut = cut_of(b, loads[b])) breaking.cuts.push_back(*cut);
}

}  // namespace trackbed::dem
