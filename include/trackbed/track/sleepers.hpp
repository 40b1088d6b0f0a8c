// Sleepers, rigid ones of this room among them, and the loads on their rail seats. Small, so every
// rank keeps all of them and moves them alike from sums that do not depend on the rank count.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/track/seat_load.hpp"

namespace trackbed::track {

// rigid: RigidSleepers; solid: bodies of elements, which another room moves.
enum class SleeperBody { rigid, solid };

struct SleeperParameters {
  SleeperBody model = SleeperBody::rigid;
  std::int64_t count = 9;
  double first = 0.6, spacing = 0.6;                 // m, x of the first centre, between centres
  double y = 0;                                      // m, of the centres, space models
  double width = 0.29, height = 0.22, length = 1.3;  // m along x, z, y (plane: model thickness)
  std::string material = "sleeper";                  // gives density and contact laws
  double density = 2441;  // kg/m^3, of the material: who knows it sets it, decks do not
  std::vector<std::string> free = {"x", "z", "ry"};  // degrees of freedom: x y z rx ry rz
  double bevel = 0;                                  // m, cut of the lower edges; 0: sharp
  // m, between the seats of two rails; as the density of who knows it. 0: one rail.
  double gauge = 0;
  // m, x of the last centre.
  double last() const { return first + static_cast<double>(count - 1) * spacing; }
  void declare(input::Section& s);
};

struct SleeperState {
  Vec3 displacement, velocity, acceleration;  // of the centre, from where it was placed
  Vec3 rotation, spin;                        // rad (vector), rad/s
};

struct Seat;  // line.hpp

// A row of sleepers, whatever they are made of. All ranks hold the same state and move it alike.
class Sleepers {
 public:
  virtual ~Sleepers() = default;

  virtual std::size_t count() const = 0;
  virtual double x(std::size_t i) const = 0;  // m, centre
  virtual double mass() const = 0;            // kg each
  // Puts them with their lower face at height z, at rest.
  virtual void place(double z) = 0;
  virtual bool placed() const = 0;
  virtual double bottom() const = 0;  // z given to place
  // Whether the sphere overlaps any sleeper (for taking away stones in the way).
  virtual bool overlaps(const Vec3& centre, double radius) const = 0;

  virtual std::vector<Surface>& surfaces() = 0;  // one per sleeper, closed, normals outwards
  // Surfaces where the sleepers stand now, without motion, until the next `advance`.
  virtual void show_at_rest() = 0;
  // One window: seat_force N downwards on each, or on both seats of each, left before right;
  // node_force: mean node forces per sleeper (surfaces()[i].nodes() each; empty: none). Fills
  // position and motion of the surfaces.
  virtual void advance(double dt, std::span<const double> seat_force,
                       const std::vector<std::span<const Vec3>>& node_force, double gravity) = 0;
  // One window in which they are held and go up by `up`, m, whatever presses on them.
  virtual void carry(double dt, double up,
                     const std::vector<std::span<const Vec3>>& node_force) = 0;
  virtual SleeperState state(std::size_t i) const = 0;
  // m/s, of the centre at the end of the last window, to second order in the window.
  virtual Vec3 velocity_now(std::size_t i) const = 0;
  virtual Vec3 spin_now(std::size_t i) const = 0;  // rad/s, likewise
  virtual Vec3 reaction(std::size_t i) const = 0;  // N, from stones in the last window
  virtual double kinetic() const = 0;              // J

  virtual std::string trouble() const = 0;  // what is not a number any more, or empty

  // Rank 0 of `comm` writes, all read. Collective.
  virtual void save(io::File& file, const std::string& group, const par::Comm& comm) const = 0;
  virtual void load(const io::File& file, const std::string& group) = 0;
};

// How the seat of a rail `aside` m to the left of a sleeper's centre stands: since the sleeper was
// placed, at the end of the last window, to second order in it.
Seat seat_of(const Sleepers& sleepers, std::size_t i, double aside);

// Rigid ones, the seat force through the centre, those of two seats at its height. Leapfrog: v += a
// (dt + last dt)/2, x += v dt, where the last dt is 0 after `place`, so that the order is two from
// rest. The velocity of `state` is that of mid-window.
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
  void save(io::File& file, const std::string& group, const par::Comm& comm) const override;
  void load(const io::File& file, const std::string& group) override;

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace trackbed::track
