// Plastic strain and forces of yielding elements; output is in plasticity_output.cpp.
//
// A fixed order of sums makes results bitwise identical: rounding in lanes is that of scalars,
// lists of PatternMap have a fixed order, elements are added to nodes by ascending number on the
// rank that owns the node. The state of an element depends on its own corners alone, so ranks that
// share it agree without a message. Rejected: dense matrices (twice the time of all else), return
// mapping in lanes (principal values and sets branch, and few points need it).
//
// A batch is eight elements of a run. Lanes beyond the end of a run compute values from the nodes
// that follow (or padding), which are not used.
#include "fem/kernel/plasticity.hpp"

#include <algorithm>

#include "fem/material/yield_margin.hpp"

namespace trackbed::fem {

namespace {

// Number of points and components of an element; order component * points + point.
template <int D>
struct Shape {
  static constexpr int points = 1 << D, components = D == 3 ? 6 : 4;
};

}  // namespace

template <int D>
struct Plasticity::Batch {
  static constexpr int points = Shape<D>::points, components = Shape<D>::components;
  Lane value[components][points];

  void to_patterns() {
    for (auto& component : value) fem::to_patterns<D>(component);
  }
  void to_corners() {
    for (auto& component : value) fem::to_corners<D>(component);
  }
  // Values of `count` elements in turn, minus those of `less` if given; other lanes 0.
  void gather(const double* from, const double* less, int count) {
    constexpr int width = components * points;
    for (int c = 0; c < components; ++c)
      for (int g = 0; g < points; ++g) {
        Lane lane = {};
        for (int l = 0; l < count; ++l) {
          const int at = l * width + c * points + g;
          lane[l] = less == nullptr ? from[at] : from[at] - less[at];
        }
        value[c][g] = lane;
      }
  }
};

// Elements are ascending with x fastest: as in Stiffness, runs end at ends of rows and at changes
// of solid or partition.
void Plasticity::make_runs() {
  for (std::size_t z = 0; z < mesh_.element.size(); ++z) {
    if (!laws_[static_cast<std::size_t>(mesh_.solid[z])]) continue;
    const bool row_begins = mesh_.lattice.element_index(mesh_.element[z])[0] == 0;
    const bool goes_on = z > 0 && !row_begins && mesh_.element[z] == mesh_.element[z - 1] + 1 &&
                         mesh_.solid[z] == mesh_.solid[z - 1];
    if (goes_on)
      ++runs_.back().elements;
    else
      runs_.push_back({1, mesh_.solid[z], mesh_.line[z], element_.size()});
    number_[z] = static_cast<std::int64_t>(element_.size());
    element_.push_back(z);
  }
}

Plasticity::Plasticity(const Mesh& mesh, const Tetrahedra* tetrahedra)
    : mesh_(mesh), tetrahedra_(tetrahedra), number_(mesh.element.size(), -1) {
  const Dimension dimension = mesh.lattice.plane ? Dimension::plane : Dimension::space;
  const int corners = mesh.lattice.corners(), components = mesh.lattice.components();
  for (std::size_t s = 0; s < mesh.solids.solid.size(); ++s) {
    auto& law = laws_.emplace_back();
    if (mesh.solids.strength[s].yield == Yield::none) continue;
    if (tetrahedra != nullptr) {
      law = std::make_unique<Law>(
          Law{{mesh.solids.solid[s], mesh.solids.strength[s]}, {}, {}, {}, {}});
      continue;
    }
    const ElementPoints points =
        element_points(mesh.solids.size[s], mesh.solids.solid[s], dimension);
    const int parts = points.components;
    // The matrix of forces from strain is the transpose of that of stress from displacement, by
    // reciprocity.
    const Eigen::MatrixXd force = points.weighted(points.recovery).transpose();
    law = std::make_unique<Law>(Law{{mesh.solids.solid[s], mesh.solids.strength[s]},
                                    points,
                                    {points.recovery, parts, components, corners},
                                    {points.relief, parts, parts, corners},
                                    {force, components, parts, corners}});
  }
  tetrahedra != nullptr ? make_groups() : make_runs();
  width_ = static_cast<std::size_t>(tetrahedra != nullptr ? tetrahedron_points : corners) *
           (mesh.lattice.plane ? 4 : 6);
  strain_.assign(width_ * element_.size(), 0.0);
  static_strain_ = strain_;
  work_.assign(element_.size(), 0.0);
  flowed_.assign(element_.size(), 0);
}

// The static plastic strain is set to zero, so that `act_on` yields the forces of all plastic
// strain.
void Plasticity::begin_static() {
  std::fill(static_strain_.begin(), static_strain_.end(), 0.0);
  std::fill(opened_.begin(), opened_.end(), 0.0);
  in_static_ = true;
}

void Plasticity::end_static() {
  static_strain_ = strain_;
  in_static_ = false;
}

// Flags follow from the strain and are not stored.
void Plasticity::loaded() {
  for (std::size_t z = 0; z < element_.size(); ++z) {
    const auto begin = strain_.begin() + static_cast<std::ptrdiff_t>(z * width_);
    flowed_[z] = std::any_of(begin, begin + static_cast<std::ptrdiff_t>(width_),
                             [](double e) { return e != 0; })
                     ? 1
                     : 0;
  }
}

// Element by element, point by point: only few elements yield.
template <int D>
void Plasticity::bring_back(const Law& law, std::size_t element, int lane, const Batch<D>& batch) {
  using B = Batch<D>;
  for (int g = 0; g < B::points; ++g) {
    Vec6 stress = Vec6::Zero(), plastic;
    for (int c = 0; c < B::components; ++c) stress(law.points.voigt(c)) = batch.value[c][g][lane];
    if (!law.surface.bring_back(stress, plastic)) continue;
    for (int c = 0; c < B::components; ++c)
      strain_[element * width_ + static_cast<std::size_t>(c * B::points + g)] +=
          plastic(law.points.voigt(c));
    work_[element] += stress.dot(plastic) * law.points.volume[g];
    flowed_[element] = 1;
  }
}

// Stress of the present motion with the plastic strain of the previous step: enhanced strains
// follow the plastic strain increment one step later.
template <int D, class Beyond>
void Plasticity::test_runs(const Nodal& u0, const Nodal& u, const Beyond& beyond) {
  constexpr int corners = 1 << D;
  Lane motion[D][corners];
  Batch<D> stress, strain, relief;
  for (const Run& run : runs_) {
    const Law& law = *laws_[static_cast<std::size_t>(run.solid)];
    for (std::int32_t at = 0; at < run.elements; at += lanes) {
      const int count = std::min(lanes, run.elements - at);
      const std::size_t first = run.first + static_cast<std::size_t>(at);
      for (int c = 0; c < D; ++c) {
        for (int k = 0; k < corners; ++k) {
          const std::int32_t node = run.line[static_cast<std::size_t>(k >> 1)] + at + (k & 1);
          motion[c][k] = load(u0[c] + node) + load(u[c] + node);
        }
        to_patterns<D>(motion[c]);
      }
      // Both parts are summed as patterns: one transformation back to the points serves both.
      law.stress.apply(&motion[0][0], &stress.value[0][0]);
      if (std::any_of(&flowed_[first], &flowed_[first] + count, [](auto f) { return f != 0; })) {
        strain.gather(&strain_[first * width_], nullptr, count);
        strain.to_patterns();
        law.relief.apply(&strain.value[0][0], &relief.value[0][0]);
        for (int c = 0; c < Batch<D>::components; ++c)
          for (int g = 0; g < corners; ++g) stress.value[c][g] += relief.value[c][g];
      }
      stress.to_corners();
      const Lane margin = yield_margin(stress.value, law.surface.cones());
      for (int l = 0; l < count; ++l)
        if (margin[l] < 0) beyond(law, first + static_cast<std::size_t>(l), l, stress);
    }
  }
}

void Plasticity::flow(const Nodal& u0, const Nodal& u) {
  if (tetrahedra_ != nullptr) return flow_groups(u0, u);
  const auto run = [&]<int D>(std::integral_constant<int, D>) {
    test_runs<D>(u0, u, [this](const Law& law, std::size_t element, int lane, const Batch<D>& b) {
      bring_back<D>(law, element, lane, b);
    });
  };
  mesh_.lattice.plane ? run(std::integral_constant<int, 2>())
                      : run(std::integral_constant<int, 3>());
}

void Plasticity::beyond(const Nodal& u0, const Nodal& u, const Take& take) {
  if (tetrahedra_ != nullptr) return beyond_groups(u0, u, take);
  const auto run = [&]<int D>(std::integral_constant<int, D>) {
    test_runs<D>(u0, u, [&](const Law&, std::size_t element, int lane, const Batch<D>& b) {
      double stress[Batch<D>::components * Batch<D>::points];
      for (int c = 0; c < Batch<D>::components; ++c)
        for (int g = 0; g < Batch<D>::points; ++g)
          stress[c * Batch<D>::points + g] = b.value[c][g][lane];
      take(element, stress);
    });
  };
  mesh_.lattice.plane ? run(std::integral_constant<int, 2>())
                      : run(std::integral_constant<int, 3>());
}

// Strain is computed in lanes, forces are added element by element: neighbours share nodes.
template <int D>
void Plasticity::act_runs(Nodal& internal) const {
  constexpr int corners = 1 << D;
  Lane force[D][corners];
  Batch<D> strain;
  for (const Run& run : runs_) {
    const Law& law = *laws_[static_cast<std::size_t>(run.solid)];
    for (std::int32_t at = 0; at < run.elements; at += lanes) {
      const int count = std::min(lanes, run.elements - at);
      const std::size_t first = run.first + static_cast<std::size_t>(at);
      if (std::none_of(&flowed_[first], &flowed_[first] + count, [](auto f) { return f != 0; }))
        continue;
      strain.gather(&strain_[first * width_], &static_strain_[first * width_], count);
      strain.to_patterns();
      law.force.apply(&strain.value[0][0], &force[0][0]);
      for (int c = 0; c < D; ++c) to_corners<D>(force[c]);
      for (int l = 0; l < count; ++l) {
        if (flowed_[first + static_cast<std::size_t>(l)] == 0) continue;
        for (int c = 0; c < D; ++c)
          for (int k = 0; k < corners; ++k)
            internal[c][run.line[static_cast<std::size_t>(k >> 1)] + at + l + (k & 1)] -=
                force[c][k][l];
      }
    }
  }
}

void Plasticity::act_on(Nodal& internal) const {
  if (tetrahedra_ != nullptr) return act_groups(internal);
  mesh_.lattice.plane ? act_runs<2>(internal) : act_runs<3>(internal);
  fold(mesh_.images, internal);
}

std::size_t Plasticity::bytes() const {
  std::size_t laws = 0;
  for (const auto& law : laws_)
    if (law) laws += law->stress.bytes() + law->relief.bytes() + law->force.bytes();
  return laws + opened_.capacity() * 8 + to_mass_.capacity() * 80 +
         (strain_.capacity() + static_strain_.capacity() + work_.capacity()) * sizeof(double) +
         number_.capacity() * 8 + element_.capacity() * 8 + flowed_.capacity() +
         runs_.capacity() * sizeof(Run) + groups_.capacity() * sizeof(Group);
}

}  // namespace trackbed::fem
