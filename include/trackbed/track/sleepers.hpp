// Rigid sleepers and the loads on their rail seats. Small (a few numbers per sleeper), so every
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

struct SleeperParameters {
  std::int64_t count = 9;
  double first = 0.6, spacing = 0.6;                 // m, x of the first centre, between centres
  double y = 0;                                      // m, of the centres, space models
  double width = 0.29, height = 0.22, length = 1.3;  // m along x, z, y (plane: model thickness)
  std::string material = "sleeper";                  // gives density and contact laws
  double density = 2441;  // kg/m^3, of the material: who knows it sets it, decks do not
  std::vector<std::string> free = {"x", "z", "ry"};  // degrees of freedom: x y z rx ry rz
  double bevel = 0;                                  // m, cut of the lower edges; 0: sharp
  // m, x of the last centre.
  double last() const { return first + static_cast<double>(count - 1) * spacing; }
  void declare(input::Section& s);
};

struct SleeperState {
  Vec3 displacement, velocity, acceleration;  // of the centre, from where it was placed
  Vec3 rotation, spin;                        // rad (vector), rad/s
};

class Sleepers {
 public:
  Sleepers(const SleeperParameters& parameters, Dimension dimension, double thickness,
           int material);
  ~Sleepers();
  Sleepers(Sleepers&&) noexcept;
  Sleepers& operator=(Sleepers&&) noexcept;

  std::size_t count() const;
  double x(std::size_t i) const;  // m, centre
  double mass() const;            // kg each
  // Puts them with their lower face at height z, at rest.
  void place(double z);
  bool placed() const;
  double bottom() const;  // z given to place
  // Whether the sphere overlaps any sleeper (for taking away stones in the way).
  bool overlaps(const Vec3& centre, double radius) const;

  std::vector<Surface>& surfaces();  // one per sleeper, closed box, normals outwards
  // Surfaces where the sleepers stand now, without motion, until the next `advance`.
  void show_at_rest();
  // One window: seat_force N downwards through each centre; node_force: mean node forces per
  // sleeper (surfaces()[i].nodes() each; empty: none). Leapfrog: v += a (dt + last dt)/2, x += v
  // dt, where the last dt is 0 after `place`, so that the order is two from rest. Velocity is that
  // of mid-window. Fills position and motion of the surfaces.
  void advance(double dt, std::span<const double> seat_force,
               const std::vector<std::span<const Vec3>>& node_force, double gravity);
  // One window in which they are held and go up by `up`, m, whatever presses on them.
  void carry(double dt, double up, const std::vector<std::span<const Vec3>>& node_force);
  SleeperState state(std::size_t i) const;
  // m/s, of the centre at the end of the last window, to second order in the window.
  Vec3 velocity_now(std::size_t i) const;
  Vec3 reaction(std::size_t i) const;  // N, from stones in the last window
  double kinetic() const;

  std::string trouble() const;  // a sleeper that is not a number any more, or empty

  // All ranks hold the same state; rank 0 of `comm` writes it, all read it. Collective.
  void save(io::File& file, const std::string& group, const par::Comm& comm) const;
  void load(const io::File& file, const std::string& group);

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace trackbed::track
