// The parts of the model and the surfaces between them; the order of the step is in
// model/scheme/staged.cpp.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/coupling/solid_sleepers.hpp"
#include "model/scene/placement.hpp"
#include "trackbed/couple/coupler.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/model/pressures.hpp"
#include "trackbed/observe/results.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::model {

// A surface that stones can touch, whichever others stages have added or removed.
struct SurfaceId {
  enum class Part { ground, wall, placed, sleeper, platen, tine };
  static constexpr std::size_t parts = 6;
  Part part;
  std::size_t index = 0;  // among the surfaces of this part
};

// Owns all parts. Stones and ground are distributed over ranks; sleepers, platen and walls are the
// same on all.
struct World {
  World(const par::Comm& comm, const Model& model);
  World(const World&) = delete;  // surfaces are identified by address
  World& operator=(const World&) = delete;

  // Registers the present surfaces with stones and coupler; mean forces of existing ones are kept.
  // To be called whenever a surface is added or removed. Collective.
  void register_surfaces();
  // A new partition of the stones if their work is unbalanced over ranks. Changes no results.
  // Collective.
  void rebalance();
  void place_platen(double z);
  void take_platen_away();
  // Places tines above the stones, beside the present positions of the sleepers. Collective.
  void place_tines();
  void take_tines_away();
  double top_of_stones() const;      // m, highest point of any stone. Collective.
  double mean_ground_level() const;  // m above z = 0, its initial level. Collective.

  // Places the stones of the deck and computes their initial forces. Collective.
  void place_stones();
  // The range of the exact sums of loads grows with the loads (Particles::expect_load). The load of
  // a poured bed grows slowly, but the weight of a bed laid from copies acts at once, may oscillate
  // with twice its value, and its floor may have one node for a thousand stones. Collective.
  void expect_weight(int substeps);

  // Mean force of the stones in the last window, N. On each node of a surface (of the ground valid
  // on own nodes) until surfaces are registered again, or its sum; none, or zero, on a surface that
  // is not there.
  std::span<const Vec3> nodal_force_on(SurfaceId id) const;
  Vec3 force_on(SurfaceId id) const;
  // Of all surfaces of a part.
  std::vector<std::span<const Vec3>> nodal_forces_on(SurfaceId::Part part) const;
  std::vector<Vec3> forces_on(SurfaceId::Part part) const;
  SurfaceId wall(const std::string& name) const;  // may be removed, or not built yet

  // Collects the loads on surfaces of a window of `dt` s that the stones have just advanced by, and
  // compares them with their action; the range of the next window's sums follows from the largest
  // load. Collective.
  void collect_loads(double dt, int substeps);

  observe::Scene scene();
  std::vector<observe::WallState> wall_states() const;  // tines count as walls
  observe::PlatenState platen_state() const;            // zero without one
  std::size_t memory() const;                           // bytes of this rank's state

  bed::Tines make_tines() const;  // as in the deck, without target depth
  // Mean force on every node of a surface, for the checkpoint. By name, since numbers of surfaces
  // change with stages.
  struct Means {
    std::string surface;
    std::vector<Vec3> force;  // N, all nodes on all ranks
  };
  std::vector<Means> means() const;  // collective
  void set_means(const std::vector<Means>& means);

  const par::Comm& comm;
  const Model& model;
  dem::Particles particles;
  std::optional<fem::Ground> ground;
  std::optional<Pressures> pressures;  // of a ground alone
  std::vector<std::int32_t> watched;   // nodes of its top in the histories, by initial position
  std::unique_ptr<track::Sleepers> sleepers;
  SolidSleepers* solids = nullptr;     // the same, if they are solids
  std::optional<bed::Platen> platen;   // while it loads the bed
  std::optional<bed::Tines> tines;     // while they tamp
  bed::Walls walls;                    // with a floor at z = 0 if there is no ground
  std::optional<Placement> placement;  // of model = "stones"
  couple::Coupler coupler;
  // Load of the bed on the ground, averaged over settle_average, N per top node, own nodes only:
  // the ground is in static equilibrium with it when it starts to move.
  std::vector<Vec3> support;
  bool ground_settled = false;

 private:
  void share_out();  // a new partition in any case; collective
  void connect();
  struct Registered {
    Surface* surface;
    std::size_t number;  // in the coupler
  };
  const std::vector<Registered>& registered(SurfaceId::Part part) const {
    return registered_[static_cast<std::size_t>(part)];
  }
  std::array<std::vector<Registered>, SurfaceId::parts> registered_;
};

// Those that are made at the begin of this stage of the model. Collective.
void make_bonds(World& world, const Stage& stage);

}  // namespace trackbed::model
