// A ground of elements below the ballast springs of a track. Both sides are coupled at the same
// instants (docs/decisions/track_on_ground.md). The track is computed identically on every rank,
// the ground is distributed over ranks.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "trackbed/core/fine_sum.hpp"
#include "trackbed/core/timers.hpp"
#include "trackbed/couple/footprints.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/io/archive.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/observe/passage.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::model {

class GroundBelow {
 public:
  // Collective; a model of kind track_on_ground.
  GroundBelow(const par::Comm& comm, const Model& model);

  // s: passage.step divided by a whole number so that it is stable; `limit` describes what limits
  // it.
  double step() const { return step_; }
  const std::string& limit() const { return limit_; }
  std::size_t footprints() const { return footprints_.count(); }
  // One step of both. Collective; throws as Passage::advance.
  void advance(track::Passage& passage);
  fem::Ground& ground() { return ground_; }
  const fem::Ground& ground() const { return ground_; }
  std::string trouble() const { return ground_.trouble(); }  // of this rank, or empty

  // Wall time in track, ground and coupling is added to `timers` from now on.
  void time_with(Timers& timers) { timers_ = &timers, ground_.time_with(timers); }
  // For summary.json. Collective.
  nlohmann::ordered_json figures() const;  // of the ground itself
  nlohmann::ordered_json balance() const;  // largest relative imbalance of any step; of all work
  observe::PassageEnergies energies(const track::Passage& passage) const;  // collective
  std::uint64_t state_hash() const;  // of the motion of the top; the same on any number of ranks

  void archive(io::Archive& a);

 private:
  std::size_t sleeper(std::size_t footprint) const { return first_ + footprint / sides_; }
  bool implicit() const { return ground_.is_implicit(); }
  double stable_step(const Model& model);
  double largest_coupling(const std::vector<double>& mass) const;
  void compute_compliance(track::Passage& passage);
  void begin_step();
  std::vector<double> set_seat_motion(track::Passage& passage);
  void apply_ballast_forces(const track::Passage& passage);
  std::vector<double> heights_below() const;
  void update_increments(const std::vector<double>& mean);
  void compare_heights(const track::Passage& passage);
  void update_balance(const std::vector<Vec3>& load_before);
  FineSum work_of_nodes() const;  // J; collective

  par::Comm comm_;
  Timers own_timers_;  // without others
  Timers* timers_ = &own_timers_;
  fem::Ground ground_;
  std::vector<std::int32_t> own_;  // nodes of the top that this rank moves
  couple::Footprints footprints_;
  std::vector<std::array<double, 2>> centre_;  // m, x and y of each ballast spring
  std::vector<Vec3> home_;                     // m, initial positions of the nodes of the top
  std::size_t first_;                          // first sleeper of the track on the ground
  std::size_t sides_;                          // footprints per sleeper, left before right
  double rails_;  // rails that the ground carries per rail of the track
  double step_;
  std::string limit_;
  std::int64_t steps_here_ = 0;  // since construction; only for the speed
  // For an implicit ground: whether the track has its compliance; N on each footprint, predicted
  // for the end of this step, and at the end of the step before the last.
  bool has_compliance_ = false;
  std::vector<double> expected_, force_before_;
  // At the end of the last step: N on each footprint and on each node of the top; m, heights of
  // footprints and of own nodes, and their increments in it.
  std::vector<double> force_;
  std::vector<Vec3> load_;
  std::vector<double> mean_, height_, mean_increment_, increment_;
  // Work of the ballast on the ground up to now, J: by nodes (of this rank), by footprints, and the
  // sum of magnitudes of the latter.
  FineSum node_work_;
  double work_ = 0, all_work_ = 0;
  // Largest relative imbalance of a step: of force, of moments about y (pitch) and x (roll).
  double force_off_ = 0;
  std::array<double, 2> moment_off_{};
  // m, of an implicit ground: largest difference between its heights in the track's solution and in
  // its own; largest height.
  double height_off_ = 0, most_height_ = 0;
};

// The line of a model of kind track_on_ground, with the sleepers that are on the moving ground.
track::LineParameters line_on_ground(const Model& model);

}  // namespace trackbed::model
