// The stones and surfaces of model = "stones": placed at the start, observed in every window.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "trackbed/io/archive.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/observe/results.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::model {

// The same on all ranks: data of stones are gathered from their owners. Stone i of the deck has the
// id i.
class Placement {
 public:
  Placement(const par::Comm& comm, const Model& model);

  // Makes the shapes of the stones in the order of the deck, unless they were given before. Throws
  // InputError with a sentence for each that cannot be made, beginning with the key of its
  // parameter. Collective.
  const std::vector<bed::PlacedShape>& make_shapes();
  void give_shapes(std::vector<bed::PlacedShape> shapes) { shapes_ = std::move(shapes); }
  void place(dem::Particles& particles);  // with these shapes; collective
  std::vector<Surface>& surfaces() { return surfaces_.surfaces(); }
  const std::vector<Surface>& surfaces() const { return surfaces_.surfaces(); }
  // With the surfaces at the positions of the last call of `update`.
  std::optional<bed::Impact> first_impact(const std::vector<geom::Piece>& pieces,
                                          const bed::Flight& flight, double until) const {
    return bed::first_impact(pieces, flight, surfaces_, until);
  }
  // Sets positions of the surfaces at `time` s and their displacement in a window of length dt.
  void update(double time, double dt) { surfaces_.update(time, dt); }

  // To be called with the initial forces of the stones; `on_surfaces`: N, on each surface.
  // Collective, as all below.
  void begin(const dem::Particles& particles, std::span<const Vec3> on_surfaces);
  // After each window of length dt: adds impulses, peaks and the work of driven bodies.
  void watch(const dem::Particles& particles, std::span<const Vec3> on_surfaces, double dt);
  // The values of a history row at `time` s.
  observe::PlacedInstant instant(const dem::Particles& particles, double time) const;

  void archive(io::Archive& a);

 private:
  // Impulse and peak force of contacts up to now, N s and N, and the force at the end of the last
  // window, N.
  struct ContactImpulse {
    Vec3 impulse = Vec3::Zero();
    double peak = 0;
    Vec3 force = Vec3::Zero();
    void add(const Vec3& now, double dt);
  };
  std::vector<dem::ParticleView> stones_of(const dem::Particles& particles) const;
  double power(const std::vector<dem::ParticleView>& stones,
               std::span<const Vec3> on_surfaces) const;  // W, supplied by drives
  double energy(const dem::Particles& particles) const;   // J

  const par::Comm& comm_;
  const Model& model_;
  bed::PlacedSurfaces surfaces_;
  std::vector<bed::PlacedShape> shapes_;
  std::vector<Quat> axes_;  // of each stone, from principal axes to those of its description
  std::vector<ContactImpulse> on_stones_, on_surfaces_;
  double energy_at_begin_ = 0, supplied_ = 0;  // J
  double power_ = 0;                           // W, at the end of the last window
};

}  // namespace trackbed::model
