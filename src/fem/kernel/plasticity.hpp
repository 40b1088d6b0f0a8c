// Yielding elements: plastic strain at their Gauss points, and the nodal forces of it.
//
// Separate from the elastic kernel: f = K u minus the forces of plastic strain, over elements of
// yielding solids only (docs/decisions/plasticity.md). An element at a rank border is held on each
// rank that needs it and yields identically there, so nothing of it is ever sent.
//
// Tetrahedra have the same law and state, but forces and stresses of their own, without enhanced
// strains (plasticity_tetrahedra.cpp).
//
// Cost per step and element that does not yield: stress of eight elements at once, some 300 flops
// each in space; one that has yielded costs twice that plus its return mappings.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "fem/kernel/pattern_map.hpp"
#include "fem/kernel/tetrahedra.hpp"
#include "fem/material/mohr_coulomb.hpp"
#include "fem/mesh/mesh.hpp"

namespace trackbed::fem {

class Plasticity {
 public:
  // For tetrahedra their operators, which must outlive it.
  explicit Plasticity(const Mesh& mesh, const Tetrahedra* tetrahedra = nullptr);

  // Returns the stress of the motion u0 + u to the yield surface, once, and keeps the plastic
  // strain. Ghosts of both must be current. Local.
  void flow(const Nodal& u0, const Nodal& u);
  // Calls take(number in elements(), Pa) for each element with a stress beyond the yield surface
  // under the motion u0 + u with its present plastic strain; stress in the order of strain in
  // Element. Ascending.
  using Take = std::function<void(std::size_t, const double*)>;
  void beyond(const Nodal& u0, const Nodal& u, const Take& take);
  // Access to one element for callers that update it themselves (plastic_step.hpp). Order component
  // * points + point.
  struct Element {
    double *strain, *work;  // -, J
    std::uint8_t* flowed;
    std::int32_t solid;
  };
  Element element(std::size_t number) {
    return {&strain_[number * width_], &work_[number], &flowed_[number],
            mesh_.solid[element_[number]]};
  }
  std::size_t width() const { return width_; }  // strain values per element
  // Marks a tetrahedron in `elements()` as opened under the motion u: from now on `act_on`
  // distributes its weight as its mass. No effect if it is open already, or for boxes.
  void open(std::size_t number, const Nodal& u);
  // Subtracts the forces of the plastic strain since static equilibrium from `internal` (N),
  // complete on own nodes; elements in ascending order. Local.
  void act_on(Nodal& internal) const;
  // During the static solve all plastic strain acts; after `end_static` only the increment since
  // then.
  void begin_static();
  void end_static();

  // For output, of a local element; zero for one that does not yield. Pa: contribution of plastic
  // strain to the stress, at the centre or at the middle of the top face, static or since then.
  enum class Where { centre, top };
  enum class When { static_, since };
  Vec6 stress(std::size_t element, Where where, When when) const;
  Vec6 stress_at(std::size_t element, const Vec3& xi, When when) const;  // within a tetrahedron
  double equivalent_strain(
      std::size_t element) const;                      // sqrt(2/3 e : e) of the mean plastic strain
  double dissipated(std::size_t element) const;        // J
  ElementPoints points_of(std::size_t element) const;  // of a yielding element
  // J of the deviation from static equilibrium beyond 1/2 u K u, terms of the elements written
  // here.
  std::vector<double> stored(const Nodal& u0, const Nodal& u) const;
  std::vector<double> dissipated() const;  // J, of each element written here

  // State, listed once: values per element, elements as in `elements()`.
  using Visit =
      std::function<void(const char*, const char*, const char*, std::size_t, std::vector<double>&)>;
  void list(const Visit& visit);
  const std::vector<std::size_t>& elements() const { return element_; }  // local numbers, ascending
  std::int64_t number(std::size_t element) const {
    return number_[element];
  }               // in elements(); -1: none
  void loaded();  // after the state came from a file
  std::size_t bytes() const;

 private:
  struct Law {
    MohrCoulomb surface;
    ElementPoints points;
    PatternMap stress, relief, force;
  };
  struct Run {  // neighbours along x of the same solid
    std::int32_t elements, solid;
    std::array<std::int32_t, 4> line;
    std::size_t first;  // in element_
  };
  struct Cone {
    Lane limit, slope, factor;  // as MohrCoulomb::Cone
  };
  struct Group {  // of tetrahedra, eight consecutive ones of a rank
    std::size_t number;
    std::array<Cone, 2> cones;
  };
  template <int D>
  struct Batch;
  template <int D, class Beyond>
  void test_runs(const Nodal& u0, const Nodal& u, const Beyond& beyond);
  template <int D>
  void act_runs(Nodal& internal) const;
  template <int D>
  void bring_back(const Law& law, std::size_t element, int lane, const Batch<D>& batch);
  const Law& law_of(std::size_t element) const {
    return *laws_[static_cast<std::size_t>(mesh_.solid[element])];
  }
  Eigen::VectorXd strain(std::size_t number, When when) const;
  void make_runs();
  void make_groups();
  // Calls take(number in elements(), lane) for each yielding element of a group. Ascending.
  template <class Take>
  void for_lanes(const Group& group, const Take& take) const {
    const std::size_t first = group.number * lanes;
    for (int lane = 0; lane < lanes; ++lane) {
      const std::size_t element = first + static_cast<std::size_t>(lane);
      if (element < number_.size() && number_[element] >= 0)
        take(static_cast<std::size_t>(number_[element]), lane);
    }
  }
  enum class Part { all, since_static };
  bool gather(const Group& group, Part part, Tetrahedra::Points& strain) const;
  template <class Beyond>
  void test_groups(const Nodal& u0, const Nodal& u, const Beyond& beyond);
  void flow_groups(const Nodal& u0, const Nodal& u);
  void beyond_groups(const Nodal& u0, const Nodal& u, const Take& take);
  void act_groups(Nodal& internal) const;
  double weight_work(std::size_t number, const Nodal& u) const;

  const Mesh& mesh_;
  const Tetrahedra* tetrahedra_;
  std::vector<std::unique_ptr<Law>> laws_;  // of each solid; none if it does not yield
  std::vector<Run> runs_;
  std::vector<Group> groups_;
  std::vector<std::size_t> element_;
  std::vector<std::int64_t> number_;  // of each local element
  std::size_t width_ = 0;             // strain values per element: component * points + point
  std::vector<double> strain_, static_strain_;  // all plastic strain; that in static equilibrium
  std::vector<double> work_;                    // J dissipated, of each element
  std::vector<std::uint8_t> flowed_;            // 1: has plastic strain
  // Of tetrahedra: 1 if opened since static equilibrium; N, along z, forces that redistribute its
  // weight as its mass.
  std::vector<double> opened_;
  std::vector<std::array<double, 10>> to_mass_;
  bool in_static_ = false;
};

}  // namespace trackbed::fem
