// Sleepers that are solids, with or without rails, with the same interface as rigid ones.
#pragma once

#include <vector>

#include "trackbed/fem/bodies.hpp"
#include "trackbed/model/solid.hpp"
#include "trackbed/observe/results.hpp"
#include "trackbed/track/line.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::model {

// Displacement and rotation of a sleeper are means over its mass; velocities are those at the end
// of the window.
class SolidSleepers final : public track::Sleepers {
 public:
  explicit SolidSleepers(const Model& model);  // which must outlive it

  std::size_t count() const override;
  double x(std::size_t i) const override;
  double mass() const override { return bodies_.mass(0); }
  void place(double z) override;
  bool placed() const override { return placed_; }
  double bottom() const override { return bodies_.origin().z(); }
  bool overlaps(const Vec3& centre, double radius) const override;
  std::vector<Surface>& surfaces() override { return bodies_.surfaces(); }
  void show_at_rest() override { bodies_.show_at_rest(); }
  // Seat forces and wheels are those at the end of the window.
  void advance(double dt, std::span<const double> seat_force,
               const std::vector<std::span<const Vec3>>& node_force, double gravity) override;
  // Not supported: decks with given motions of sleepers are refused.
  void carry(double dt, double up, const std::vector<std::span<const Vec3>>& node_force) override;
  track::SleeperState state(std::size_t i) const override;
  Vec3 velocity_now(std::size_t i) const override { return bodies_.motion(i).velocity; }
  Vec3 spin_now(std::size_t i) const override { return bodies_.motion(i).spin; }
  Vec3 reaction(std::size_t i) const override { return reaction_.at(i); }
  double kinetic() const override { return bodies_.totals().kinetic; }
  std::string trouble() const override { return bodies_.trouble(); }
  void archive(io::Archive& a) override;

  // Wheels of the next window; their force is distributed equally to all rails.
  void roll(std::vector<track::AxleLoad> axles) { axles_ = std::move(axles); }
  // N, downwards on each sleeper: present forces of its pads, or without rails those applied in the
  // last window.
  std::vector<double> seat_forces() const;
  // For the pads of rails that are beams: m, m/s and m/s per N, see fem::Bodies::trapezoidal and
  // mobility. One rail uses the mean of a sleeper's seats, two have one seat each, left before
  // right.
  std::vector<double> seat_levels(double dt) const;
  std::vector<double> seat_rates() const;
  std::vector<track::Matrix2> seat_mobility(double dt);  // of each sleeper
  // Adds forces to those at the end of the window that `advance` computed last: N downwards below
  // each of these pads; those of one rail are distributed equally to the seats.
  void add_pad_forces(std::span<const double> force);
  const fem::Bodies& bodies() const { return bodies_; }
  observe::SolidState observed() const;

 private:
  void add_wheels(std::vector<fem::Bodies::PatchLoad>& pushes) const;
  std::size_t seats() const;  // of a sleeper
  std::size_t pads() const;   // of a sleeper, for rails that are beams

  const Model& model_;
  fem::Bodies bodies_;
  std::vector<fem::NodeWeights> loaded_;       // where the load of each seat acts
  std::vector<fem::NodeWeights> seat_, rail_;  // nodes of each seat, and of the rail above it
  std::vector<fem::NodeWeights> below_;        // nodes below each pad of rails that are beams
  std::vector<fem::Body> rails_;               // as built
  std::vector<Vec3> reaction_;                 // N
  std::vector<double> given_;                  // N, seat forces applied in the last window
  std::vector<track::AxleLoad> axles_;
  bool placed_ = false;
};

}  // namespace trackbed::model
