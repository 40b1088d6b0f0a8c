// Zones that yield: plastic strain at their Gauss points, and the forces it makes.
//
// Beside the elastic kernel, not in it: f = K u less what plastic strain takes off, over zones of
// yielding solids alone (docs/decisions/plasticity.md). A zone at a rank border is held on each
// rank that needs it and flows there alike, so nothing of it is ever sent.
//
// Tetrahedra have the same law and state, but forces and stresses of their own, without enhanced
// strains (plasticity_tetrahedra.cpp).
//
// Cost per step and zone that does not yield: stress of eight zones at once, some 300 flops each in
// space; one that has yielded costs twice that and its returns.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "mesh.hpp"
#include "mohr_coulomb.hpp"
#include "pattern_map.hpp"
#include "tetrahedra.hpp"

namespace trackbed::fem {

class Plasticity {
 public:
  // Of tetrahedra theirs, which must outlive it.
  explicit Plasticity(const Mesh& mesh, const Tetrahedra* tetrahedra = nullptr);

  // Returns the stress of the motion rest + u to the surface, once, and keeps the plastic strain.
  // Ghosts of both must be current. Local.
  void flow(const Nodal& rest, const Nodal& u);
  // Calls take(number in zones(), Pa) for each zone that goes beyond the surface somewhere under
  // the motion rest + u with the plastic strain it has; stress as the strain in Zone. Ascending.
  using Take = std::function<void(std::size_t, const double*)>;
  void beyond(const Nodal& rest, const Nodal& u, const Take& take);
  // One zone for those who let it flow themselves (plastic_step.hpp). Component * points + point.
  struct Zone {
    double *strain, *work;  // -, J
    std::uint8_t* flowed;
    std::int32_t solid;
  };
  Zone zone(std::size_t number) {
    return {&strain_[number * width_], &work_[number], &flowed_[number],
            mesh_.solid[zone_[number]]};
  }
  std::size_t width() const { return width_; }  // numbers of strain per zone
  // A tetrahedron in `zones()` has opened under the motion u: from now on `act_on` moves its weight
  // to its mass. Nothing happens to one that is open already, or to boxes.
  void open(std::size_t number, const Nodal& u);
  // Takes the forces of the plastic strain since rest off `internal` (N), complete on own nodes;
  // zones in ascending order. Local.
  void act_on(Nodal& internal) const;
  // While a rest is sought all plastic strain acts; from `found_rest` on what comes later.
  void seek_rest();
  void found_rest();

  // For output, of a local zone; zero for one that does not yield. Pa: what plastic strain adds to
  // the elastic stress, at the centre or amid the top face, up to rest or since.
  enum class Where { centre, top };
  enum class When { rest, since };
  Vec6 stress(std::size_t zone, Where where, When when) const;
  Vec6 stress_at(std::size_t zone, const Vec3& xi, When when) const;  // within a tetrahedron
  double sheared(std::size_t zone) const;        // sqrt(2/3 e : e) of the mean plastic strain
  double lost(std::size_t zone) const;           // J
  ZonePoints points_of(std::size_t zone) const;  // of a zone that yields
  // J of the deviation from rest beyond 1/2 u K u, terms of the zones written here.
  std::vector<double> stored(const Nodal& rest, const Nodal& u) const;
  std::vector<double> lost() const;  // J, of each zone written here

  // State, listed once: numbers per zone, zones as in `zones()`.
  using Visit =
      std::function<void(const char*, const char*, const char*, std::size_t, std::vector<double>&)>;
  void list(const Visit& visit);
  const std::vector<std::size_t>& zones() const { return zone_; }        // local numbers, ascending
  std::int64_t number(std::size_t zone) const { return number_[zone]; }  // in zones(); -1: none
  void loaded();  // after the state came from a file
  std::size_t bytes() const;

 private:
  struct Law {
    MohrCoulomb surface;
    ZonePoints points;
    PatternMap stress, relief, force;
  };
  struct Run {  // neighbours along x of one solid
    std::int32_t zones, solid;
    std::array<std::int32_t, 4> line;
    std::size_t first;  // in zone_
  };
  struct Cone {
    Lane limit, slope, factor;  // as MohrCoulomb::Cone
  };
  struct Group {  // of tetrahedra, eight of a rank's in turn
    std::size_t number;
    std::array<Cone, 2> cones;
  };
  template <int D>
  struct Batch;
  template <int D, class Beyond>
  void test_runs(const Nodal& rest, const Nodal& u, const Beyond& beyond);
  template <int D>
  void act_runs(Nodal& internal) const;
  template <int D>
  void bring_back(const Law& law, std::size_t zone, int lane, const Batch<D>& batch);
  const Law& law_of(std::size_t zone) const {
    return *laws_[static_cast<std::size_t>(mesh_.solid[zone])];
  }
  Eigen::VectorXd strain(std::size_t number, When when) const;
  void make_runs();
  void make_groups();
  // Calls take(number in zones(), lane) for each of a group that yields. Ascending.
  template <class Take>
  void for_lanes(const Group& group, const Take& take) const {
    const std::size_t first = group.number * lanes;
    for (int lane = 0; lane < lanes; ++lane) {
      const std::size_t zone = first + static_cast<std::size_t>(lane);
      if (zone < number_.size() && number_[zone] >= 0)
        take(static_cast<std::size_t>(number_[zone]), lane);
    }
  }
  enum class Part { all, since_rest };
  bool gather(const Group& group, Part part, Tetrahedra::Points& strain) const;
  template <class Beyond>
  void test_groups(const Nodal& rest, const Nodal& u, const Beyond& beyond);
  void flow_groups(const Nodal& rest, const Nodal& u);
  void beyond_groups(const Nodal& rest, const Nodal& u, const Take& take);
  void act_groups(Nodal& internal) const;
  double sag(std::size_t number, const Nodal& u) const;

  const Mesh& mesh_;
  const Tetrahedra* tetrahedra_;
  std::vector<std::unique_ptr<Law>> laws_;  // of each solid; none if it does not yield
  std::vector<Run> runs_;
  std::vector<Group> groups_;
  std::vector<std::size_t> zone_;
  std::vector<std::int64_t> number_;   // of each local zone
  std::size_t width_ = 0;              // numbers of strain per zone: component * points + point
  std::vector<double> strain_, rest_;  // all plastic strain; that at rest
  std::vector<double> work_;           // J lost, of each zone
  std::vector<std::uint8_t> flowed_;   // 1: has plastic strain
  // Of tetrahedra: 1 if opened since rest; N, along z, what moves its weight to its mass.
  std::vector<double> opened_;
  std::vector<std::array<double, 10>> to_mass_;
  bool seeks_rest_ = false;
};

}  // namespace trackbed::fem
