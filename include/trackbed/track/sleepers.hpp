// Interface of all sleepers, and the rigid sleepers of this module, with the loads on their rail
// seats. Every rank keeps all sleepers and moves them identically, from sums that do not depend on
// the number of ranks.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/io/archive.hpp"
#include "trackbed/track/seat_load.hpp"

namespace trackbed::track {

// rigid: RigidSleepers; solid: bodies of elements (module fem).
enum class SleeperBody { rigid, solid };

struct SleeperParameters {
  SleeperBody model = SleeperBody::rigid;
  std::int64_t count = 9;
  double first = 0.6, spacing = 0.6;                 // m, x of the first centre, between centres
  double y = 0;                                      // m, of the centres, space models
  double width = 0.29, height = 0.22, length = 1.3;  // m along x, z, y (plane: model thickness)
  std::string material = "sleeper";                  // gives density and contact laws
  double density = 2441;  // kg/m^3, set by the caller from the material, not in decks
  std::vector<std::string> free = {"x", "z", "ry"};  // degrees of freedom: x y z rx ry rz
  double bevel = 0;                                  // m, of the lower edges; 0: sharp
  // m, between the seats of two rails, set by the caller. 0: one rail.
  double gauge = 0;
  // m, x of the last centre.
  double last() const { return first + static_cast<double>(count - 1) * spacing; }
  void declare(input::Section& s);
};

struct SleeperState {
  Vec3 displacement, velocity, acceleration;  // of the centre, relative to the placed position
  Vec3 rotation, spin;                        // rad (vector), rad/s
};

struct Seat;  // line.hpp

// A row of sleepers, rigid or solid. All ranks hold the same state and move it identically.
class Sleepers {
 public:
  virtual ~Sleepers() = default;

  virtual std::size_t count() const = 0;
  virtual double x(std::size_t i) const = 0;  // m, centre
  virtual double mass() const = 0;            // kg each
  // Places them with their lower face at height z, at rest.
  virtual void place(double z) = 0;
  virtual bool placed() const = 0;
  virtual double bottom() const = 0;  // z given to place
  // Whether the sphere overlaps any sleeper (for the removal of stones).
  virtual bool overlaps(const Vec3& centre, double radius) const = 0;

  virtual std::vector<Surface>& surfaces() = 0;  // one per sleeper, closed, normals outwards
  // Sets the surfaces to the present position of the sleepers, without motion.
  virtual void show_at_rest() = 0;
  // One window: seat_force, N, downwards on each sleeper, or on both seats of each, left before
  // right; node_force: mean node forces per sleeper (surfaces()[i].nodes() each; empty: none). Sets
  // position and motion of the surfaces.
  virtual void advance(double dt, std::span<const double> seat_force,
                       const std::vector<std::span<const Vec3>>& node_force, double gravity) = 0;
  // One window with a prescribed upward displacement `up`, m; forces do not change it.
  virtual void carry(double dt, double up,
                     const std::vector<std::span<const Vec3>>& node_force) = 0;
  virtual SleeperState state(std::size_t i) const = 0;
  // m/s, of the centre at the end of the last window, to second order in the window.
  virtual Vec3 velocity_now(std::size_t i) const = 0;
  virtual Vec3 spin_now(std::size_t i) const = 0;  // rad/s, likewise
  virtual Vec3 reaction(std::size_t i) const = 0;  // N, from stones in the last window
  virtual double kinetic() const = 0;              // J

  virtual std::string trouble() const = 0;  // message if a value is not a number, or empty

  virtual void archive(io::Archive& a) = 0;
};

// Height and velocity of the seat `aside` m to the left of a sleeper's centre, relative to the
// placed position, at the end of the last window; of second order in the window.
Seat seat_of(const Sleepers& sleepers, std::size_t i, double aside);

// Rigid sleepers; one seat force acts at the centre, two seat forces at its height. Leapfrog: v +=
// a (dt + last dt)/2, x += v dt, where the last dt is 0 after `place`, so that the scheme is of
// second order from rest. The velocity of `state` is that at mid-window.
class RigidSleepers final : public Sleepers {
 public:
  RigidSleepers(const SleeperParameters& parameters, Dimension dimension, double thickness,
                int material);
  ~RigidSleepers() override;
  RigidSleepers(RigidSleepers&&) noexcept;
  RigidSleepers& operator=(RigidSleepers&&) noexcept;

  std::size_t count() const override;
  double x(std::size_t i) const override;
  double mass() const override;
  void place(double z) override;
  bool placed() const override;
  double bottom() const override;
  bool overlaps(const Vec3& centre, double radius) const override;
  std::vector<Surface>& surfaces() override;
  void show_at_rest() override;
  void advance(double dt, std::span<const double> seat_force,
               const std::vector<std::span<const Vec3>>& node_force, double gravity) override;
  void carry(double dt, double up, const std::vector<std::span<const Vec3>>& node_force) override;
  SleeperState state(std::size_t i) const override;
  Vec3 velocity_now(std::size_t i) const override;
  Vec3 spin_now(std::size_t i) const override;
  Vec3 reaction(std::size_t i) const override;
  double kinetic() const override;
  std::string trouble() const override;
  void archive(io::Archive& a) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trackbed::track
