// A ground of elements below the ballast springs of a track. Both sides feel each other at the same
// instants (docs/decisions/track_on_ground.md). The track is computed by every rank alike, the
// ground is spread over ranks.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/parameters.hpp"
#include "trackbed/core/fine_sum.hpp"
#include "trackbed/couple/footprints.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::app {

class GroundBelow {
 public:
  // Collective; a model of kind track_on_ground.
  GroundBelow(const par::Comm& comm, const Model& model);

  // s: a whole part of passage.step that is stable; `limit` says what limits it if that is less.
  double step() const { return step_; }
  const std::string& limit() const { return limit_; }
  std::size_t footprints() const { return footprints_.count(); }
  // One step of both. Collective; throws as Passage::advance.
  void advance(track::Passage& passage);
  std::string trouble() const { return ground_.trouble(); }  // of this rank, or empty

  double seconds() const;  // of this rank in the ground, since built
  // For summary.json. Collective.
  nlohmann::ordered_json figures() const;  // of the ground itself
  nlohmann::ordered_json balance() const;  // largest relative imbalance of any step; of all work
  // J, of the ground and of all the rails above it, the springs between them counted with these.
  nlohmann::ordered_json energies(const track::Passage& passage) const;
  std::uint64_t state_hash() const;  // of the motion of the top; on any number of ranks

  void save(io::File& file) const;
  void load(const io::File& file);

 private:
  std::size_t sleeper(std::size_t footprint) const { return first_ + footprint / sides_; }
  bool implicit() const { return ground_.is_implicit(); }
  double stable_step(const Model& model);
  double largest_coupling(const std::vector<double>& mass) const;
  void found(track::Passage& passage);
  void begin_step();
  std::vector<double> sense(track::Passage& passage);
  void press(const track::Passage& passage);
  std::vector<double> heights_below() const;
  void follow(const std::vector<double>& mean);
  void compare(const track::Passage& passage);
  void account(const std::vector<Vec3>& load_before);

  par::Comm comm_;
  fem::Ground ground_;
  std::vector<std::int32_t> own_;  // nodes of the top that this rank moves
  couple::Footprints footprints_;
  std::vector<std::array<double, 2>> centre_;  // m, x and y of each ballast spring
  std::vector<Vec3> home_;                     // m, nodes of the top at rest
  std::size_t first_;                          // sleeper of the track
  std::size_t sides_;                          // footprints of each, left before right
  double rails_;                               // of the ground for one of the track
  double step_;
  std::string limit_;
  std::int64_t steps_here_ = 0;  // since built; for the speed alone
  // Of an implicit ground: whether the track knows how it gives way; N on each footprint, what was
  // expected at the end of this step, and the end of the step before the last.
  bool founded_ = false;
  std::vector<double> expected_, force_before_;
  // At the end of the last step: N on each footprint, on each node of the top; m, of each footprint
  // and of own nodes, and how far they went in it.
  std::vector<double> force_;
  std::vector<Vec3> load_;
  std::vector<double> mean_, height_, mean_way_, way_;
  // What the ballast has given to the ground so far, J: by nodes (of this rank), by footprints, and
  // the sum of magnitudes of these.
  FineSum node_work_;
  double work_ = 0, all_work_ = 0;
  // Largest relative imbalance of a step: of force, of moments about y (pitch) and x (roll).
  double force_off_ = 0;
  std::array<double, 2> moment_off_{};
  // m, of an implicit ground: largest difference of where the track found it and where it came to;
  // largest height.
  double height_off_ = 0, most_height_ = 0;
};

// The line of a model of kind track_on_ground: which of its sleepers stand on what moves.
track::LineParameters line_on_ground(const Model& model);

}  // namespace trackbed::app
