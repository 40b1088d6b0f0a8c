// The parts of the model and the surfaces between them. Knows what exists and who touches what;
// the order of the step is in simulation.cpp.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/parameters.hpp"
#include "app/placement.hpp"
#include "app/solid_sleepers.hpp"
#include "trackbed/couple/coupler.hpp"
#include "trackbed/couple/pressures.hpp"
#include "trackbed/observe/results.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// Owns all parts. Ranks: stones and ground are spread, sleepers, platen and walls are the same on
// all.
struct World {
  World(const par::Comm& comm, const Model& model);
  World(const World&) = delete;  // surfaces are known by address
  World& operator=(const World&) = delete;

  // Tells stones and coupler which surfaces there are now; mean forces of those that stay are kept.
  // To be called whenever a surface appears or goes. Collective.
  void meet();
  // A new split of the stones over ranks if their work is uneven. Changes no results. Collective.
  void rebalance();
  void place_platen(double z);
  // One window of lifting: it was lifted by `before` in the last window and goes up by `motion`, m.
  void lift_platen(double before, double motion);
  void take_platen_away();
  // Tines above the stones, to go in beside the sleepers as they lie now. Collective.
  void place_tines();
  void take_tines_away();
  double top_of_stones() const;      // m, highest point of any stone. Collective.
  double mean_ground_level() const;  // m above z = 0, where it began. Collective.

  // The stones of a deck that places them, and the forces on them where they begin. Collective.
  void place_stones();

  // Mean force of the last window, N.
  std::vector<std::span<const Vec3>> on_sleepers() const;
  std::span<const Vec3> on_ground() const;                // per top node, valid on own nodes
  double on_platen() const;                               // vertical
  std::array<std::span<const Vec3>, 2> on_tines() const;  // per node
  Vec3 on(const std::string& surface) const;  // all of it; zero if there is no such surface
  std::vector<Vec3> on_placed() const;        // each plate and box

  observe::Scene scene();
  std::vector<observe::WallState> wall_states() const;  // tines count as walls
  observe::PlatenState platen_state() const;            // zero without one
  std::size_t memory() const;                           // bytes of this rank's state

  // Mean force on every node of every surface, by surface name: for the checkpoint.
  // By name, since numbers of surfaces change with stages.
  bed::Tines make_tines() const;  // as the deck has them, aimed at nothing
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
  std::optional<couple::Pressures> pressures;  // of a ground alone
  std::vector<std::int32_t> watched;  // nodes of its top in the histories: from where it began
  std::unique_ptr<track::Sleepers> sleepers;
  SolidSleepers* solids = nullptr;     // the same, if they are solids
  std::optional<bed::Platen> platen;   // while it presses
  std::optional<bed::Tines> tines;     // while they tamp
  bed::Walls walls;                    // with a floor at z = 0 if there is no ground
  std::optional<Placement> placement;  // of model = "stones"
  couple::Coupler coupler;
  // Load of the bed on the ground, averaged over settle_average, N per top node, own nodes only:
  // the ground is in equilibrium with it when it is let go.
  std::vector<Vec3> support;
  bool ground_settled = false;

 private:
  void share_out();  // a new split in any case; collective
  void connect();
  struct Touched {
    Surface* surface;
    std::size_t number;  // in the coupler
  };
  std::vector<Touched> touched_;  // ground (if any), walls, sleepers (if placed), platen
  std::size_t first_sleeper_ = 0, platen_number_ = 0, first_tine_ = 0;
};

}  // namespace trackbed::app
