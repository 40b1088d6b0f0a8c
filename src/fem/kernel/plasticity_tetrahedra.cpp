// Plastic strain and forces of yielding tetrahedra: the same law and state as for boxes, point by
// point, on the groups of eight of Tetrahedra.
//
// Without enhanced strains the stress of a point is D (B (u0 + u) - e) and depends on no other
// point. Points of elements with curved edges differ in volume. Lanes of a group that do not yield
// are computed too, but not used; groups without yielding solids are skipped.
//
// Weight is distributed by the shape functions, mass is lumped differently (terms_import.cpp).
// Where stress cannot balance the difference, corners would move upwards: the weight of a
// tetrahedron that has opened is distributed as its mass, so that loose material falls as a rigid
// body. Static equilibrium is not affected.
#include <algorithm>

#include "fem/kernel/plasticity.hpp"
#include "fem/material/yield_margin.hpp"
#include "trackbed/core/types.hpp"

namespace trackbed::fem {

namespace {

constexpr int components = 6, points = tetrahedron_points;

}  // namespace

void Plasticity::make_groups() {
  for (std::size_t z = 0; z < mesh_.element.size(); ++z) {
    const Law* law = laws_[static_cast<std::size_t>(mesh_.solid[z])].get();
    if (law == nullptr) continue;
    const std::size_t group = z / lanes, lane = z % lanes;
    if (groups_.empty() || groups_.back().number != group) {
      Group none{group, {}};
      for (Cone& cone : none.cones) cone = {Lane{} + 1.0, Lane{}, Lane{}};  // never beyond
      groups_.push_back(none);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      const MohrCoulomb::Cone& from = law->surface.cones()[k];
      Cone& to = groups_.back().cones[k];
      to.limit[lane] = from.limit, to.slope[lane] = from.slope, to.factor[lane] = from.factor;
    }
    number_[z] = static_cast<std::int64_t>(element_.size());
    element_.push_back(z);
    const TenNumbers load = tetrahedron_load(tetrahedra_->nodes_of(z));
    const double heavy =
        gravity * mesh_.solids.solid[static_cast<std::size_t>(mesh_.solid[z])].density;
    auto& moves = to_mass_.emplace_back();
    for (int k = 0; k < 10; ++k)
      moves[static_cast<std::size_t>(k)] =
          heavy * (load[k] - load.sum() * tetrahedron_mass_fraction(k));
  }
  opened_.assign(element_.size(), 0.0);
}

// J, work of the forces that redistribute its weight.
double Plasticity::weight_work(std::size_t number, const Nodal& u) const {
  double sum = 0;
  for (int k = 0; k < 10; ++k)
    sum += to_mass_[number][static_cast<std::size_t>(k)] * u[2][mesh_.corner(element_[number], k)];
  return sum;
}

// The forces start to act at the present displacement: their potential there is dissipated, as work
// of opening.
void Plasticity::open(std::size_t number, const Nodal& u) {
  if (tetrahedra_ == nullptr || in_static_ || opened_[number] != 0) return;
  opened_[number] = 1;
  work_[number] += weight_work(number, u);
}

// Plastic strain of the elements of a group, in their lanes. False if none of them has yielded.
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
        strain[c][g][lane] =
            part == Part::since_static ? strain_[at] - static_strain_[at] : strain_[at];
      }
  });
  return any;
}

template <class Beyond>
void Plasticity::test_groups(const Nodal& u0, const Nodal& u, const Beyond& beyond) {
  Tetrahedra::Points stress, strain, relief;
  for (const Group& group : groups_) {
    tetrahedra_->stress(group.number, u0, u, stress);
    if (gather(group, Part::all, strain)) {
      tetrahedra_->hooke(group.number, strain, relief);
      for (int c = 0; c < components; ++c)
        for (int g = 0; g < points; ++g) stress[c][g] -= relief[c][g];
    }
    const Lane margin = yield_margin(stress, group.cones);
    for_lanes(group, [&](std::size_t number, int lane) {
      if (margin[lane] < 0) beyond(number, lane, stress);
    });
  }
}

void Plasticity::flow_groups(const Nodal& u0, const Nodal& u) {
  test_groups(u0, u, [&](std::size_t number, int lane, const auto& all) {
    const std::size_t element = element_[number];
    for (int g = 0; g < points; ++g) {
      Vec6 stress, plastic;
      for (int c = 0; c < components; ++c) stress(c) = all[c][g][lane];
      if (!law_of(element).surface.bring_back(stress, plastic)) continue;
      for (int c = 0; c < components; ++c)
        strain_[number * width_ + static_cast<std::size_t>(c * points + g)] += plastic(c);
      work_[number] += stress.dot(plastic) * tetrahedra_->volume(element, g);
      flowed_[number] = 1;
      if (law_of(element).surface.opens(stress)) open(number, u);
    }
  });
}

void Plasticity::beyond_groups(const Nodal& u0, const Nodal& u, const Take& take) {
  test_groups(u0, u, [&](std::size_t number, int lane, const auto& all) {
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
    if (!gather(group, Part::since_static, strain)) continue;
    tetrahedra_->hooke(group.number, strain, stress);
    std::uint8_t flowed[lanes] = {};
    for_lanes(group, [&](std::size_t number, int lane) { flowed[lane] = flowed_[number]; });
    tetrahedra_->take_off(group.number, stress, flowed, internal);
  }
  // After all groups: the grouping of elements depends on the rank.
  for (std::size_t number = 0; number < element_.size(); ++number) {
    if (opened_[number] == 0) continue;
    for (int k = 0; k < 10; ++k)
      internal[2][mesh_.corner(element_[number], k)] -=
          to_mass_[number][static_cast<std::size_t>(k)];
  }
}

// Linear through the points: exact for the stress of an element with straight edges.
Vec6 Plasticity::stress_at(std::size_t element, const Vec3& xi, When when) const {
  Vec6 sum = Vec6::Zero();
  if (number_[element] < 0) return sum;
  const Eigen::VectorXd e = strain(static_cast<std::size_t>(number_[element]), when);
  const Voigt d = elasticity(mesh_.solids.solid[static_cast<std::size_t>(mesh_.solid[element])]);
  const Eigen::Vector4d fraction = tetrahedron_weights(xi);
  for (int g = 0; g < points; ++g) sum -= fraction[g] * d * e.segment<6>(components * g);
  return sum;
}

ElementPoints Plasticity::points_of(std::size_t element) const {
  return tetrahedra_ != nullptr ? tetrahedra_->points(element) : law_of(element).points;
}

}  // namespace trackbed::fem
