// Flow and forces of tetrahedra that yield: the same law and state as boxes, point by point, on the
// groups of eight of Tetrahedra.
//
// No enhanced strains: a point's stress is D (B (rest + u) - e) and hangs on no other point. Points
// of elements with curved edges differ in volume. Lanes of a group that do not yield are computed
// along and never looked at; groups without any are passed over.
//
// Weight is what the shape functions carry, mass is lumped otherwise (terms_import.cpp). Where
// stress cannot balance the difference, corners would fall upwards: a tetrahedron that has opened
// carries its weight by its mass, so that what is loose falls as a whole. The rest stays exact.
#include <algorithm>

#include "plasticity.hpp"
#include "room_within.hpp"
#include "trackbed/core/types.hpp"

namespace trackbed::fem {

namespace {

constexpr int components = 6, points = tetrahedron_points;

}  // namespace

void Plasticity::make_groups() {
  for (std::size_t z = 0; z < mesh_.zone.size(); ++z) {
    const Law* law = laws_[static_cast<std::size_t>(mesh_.solid[z])].get();
    if (law == nullptr) continue;
    const std::size_t group = z / lanes, lane = z % lanes;
    if (groups_.empty() || groups_.back().number != group) {
      Group none{group, {}};
      for (Cone& cone : none.cones) cone = {Lane{} + 1.0, Lane{}, Lane{}};  // nothing is beyond
      groups_.push_back(none);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      const MohrCoulomb::Cone& from = law->surface.cones()[k];
      Cone& to = groups_.back().cones[k];
      to.limit[lane] = from.limit, to.slope[lane] = from.slope, to.factor[lane] = from.factor;
    }
    number_[z] = static_cast<std::int64_t>(zone_.size());
    zone_.push_back(z);
    const TenNumbers load = tetrahedron_load(tetrahedra_->nodes_of(z));
    const double heavy =
        gravity * mesh_.solids.solid[static_cast<std::size_t>(mesh_.solid[z])].density;
    auto& moves = to_mass_.emplace_back();
    for (int k = 0; k < 10; ++k)
      moves[static_cast<std::size_t>(k)] =
          heavy * (load[k] - load.sum() * tetrahedron_mass_share(k));
  }
  opened_.assign(zone_.size(), 0.0);
}

// J, of the forces that move its weight.
double Plasticity::sag(std::size_t number, const Nodal& u) const {
  double sum = 0;
  for (int k = 0; k < 10; ++k)
    sum += to_mass_[number][static_cast<std::size_t>(k)] * u[2][mesh_.corner(zone_[number], k)];
  return sum;
}

// The forces set in where the nodes are now: their potential is lost there, as work of the opening.
void Plasticity::open(std::size_t number, const Nodal& u) {
  if (tetrahedra_ == nullptr || seeks_rest_ || opened_[number] != 0) return;
  opened_[number] = 1;
  work_[number] += sag(number, u);
}

// Plastic strain of a group's elements, in the lanes they have there.
// False if none of them has flowed.
bool Plasticity::gather(const Group& group, Part part, Tetrahedra::Points& strain) const {
  bool any = false;
  for (auto& component : strain)
    for (Lane& lane : component) lane = Lane{};
  for_lanes(group, [&](std::size_t number, int lane) {
    if (flowed_[number] == 0) return;
    any = true;
    for (int c = 0; c < components; ++c)
      for (int g = 0; g < points; ++g) {
        const std::size_t at = number * width_ + static_cast<std::size_t>(c * points + g);
        strain[c][g][lane] = part == Part::since_rest ? strain_[at] - rest_[at] : strain_[at];
      }
  });
  return any;
}

template <class Beyond>
void Plasticity::test_groups(const Nodal& rest, const Nodal& u, const Beyond& beyond) {
  Tetrahedra::Points stress, strain, relief;
  for (const Group& group : groups_) {
    tetrahedra_->stress(group.number, rest, u, stress);
    if (gather(group, Part::all, strain)) {
      tetrahedra_->hooke(group.number, strain, relief);
      for (int c = 0; c < components; ++c)
        for (int g = 0; g < points; ++g) stress[c][g] -= relief[c][g];
    }
    const Lane room = room_within(stress, group.cones);
    for_lanes(group, [&](std::size_t number, int lane) {
      if (room[lane] < 0) beyond(number, lane, stress);
    });
  }
}

void Plasticity::flow_groups(const Nodal& rest, const Nodal& u) {
  test_groups(rest, u, [&](std::size_t number, int lane, const auto& all) {
    const std::size_t zone = zone_[number];
    for (int g = 0; g < points; ++g) {
      Vec6 stress, plastic;
      for (int c = 0; c < components; ++c) stress(c) = all[c][g][lane];
      if (!law_of(zone).surface.bring_back(stress, plastic)) continue;
      for (int c = 0; c < components; ++c)
        strain_[number * width_ + static_cast<std::size_t>(c * points + g)] += plastic(c);
      work_[number] += stress.dot(plastic) * tetrahedra_->volume(zone, g);
      flowed_[number] = 1;
      if (law_of(zone).surface.opens(stress)) open(number, u);
    }
  });
}

void Plasticity::beyond_groups(const Nodal& rest, const Nodal& u, const Take& take) {
  test_groups(rest, u, [&](std::size_t number, int lane, const auto& all) {
    double stress[components * points];
    for (int c = 0; c < components; ++c)
      for (int g = 0; g < points; ++g) stress[c * points + g] = all[c][g][lane];
    take(number, stress);
  });
}

// Elements in ascending order, as everywhere.
void Plasticity::act_groups(Nodal& internal) const {
  Tetrahedra::Points strain, stress;
  for (const Group& group : groups_) {
    if (!gather(group, Part::since_rest, strain)) continue;
    tetrahedra_->hooke(group.number, strain, stress);
    std::uint8_t flowed[lanes] = {};
    for_lanes(group, [&](std::size_t number, int lane) { flowed[lane] = flowed_[number]; });
    tetrahedra_->take_off(group.number, stress, flowed, internal);
  }
  // After them all: which elements share a group hangs on the rank.
  for (std::size_t number = 0; number < zone_.size(); ++number) {
    if (opened_[number] == 0) continue;
    for (int k = 0; k < 10; ++k)
      internal[2][mesh_.corner(zone_[number], k)] -= to_mass_[number][static_cast<std::size_t>(k)];
  }
}

// Linear through the points: exact for the stress of a straight element.
Vec6 Plasticity::stress_at(std::size_t zone, const Vec3& xi, When when) const {
  Vec6 sum = Vec6::Zero();
  if (number_[zone] < 0) return sum;
  const Eigen::VectorXd e = strain(static_cast<std::size_t>(number_[zone]), when);
  const Voigt d = elasticity(mesh_.solids.solid[static_cast<std::size_t>(mesh_.solid[zone])]);
  const Eigen::Vector4d share = tetrahedron_weights(xi);
  for (int g = 0; g < points; ++g) sum -= share[g] * d * e.segment<6>(components * g);
  return sum;
}

ZonePoints Plasticity::points_of(std::size_t zone) const {
  return tetrahedra_ != nullptr ? tetrahedra_->points(zone) : law_of(zone).points;
}

}  // namespace trackbed::fem
