// The stones and surfaces of model = "stones": placed at the begin, watched in every window.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "app/parameters.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/observe/results.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// All ranks hold the same: what is known of stones is gathered from their owners. Stone i of the
// deck has the id i.
class Placement {
 public:
  Placement(const par::Comm& comm, const Model& model);

  // Makes the shapes of the stones in the order of the deck, if they are not yet given. Throws
  // InputError with all that cannot be made, each sentence beginning with the key of its parameter.
  // Collective.
  const std::vector<bed::PlacedShape>& make_shapes();
  void give_shapes(std::vector<bed::PlacedShape> shapes) { shapes_ = std::move(shapes); }
  void place(dem::Particles& particles);  // with these shapes; collective
  std::vector<Surface>& surfaces() { return surfaces_.surfaces(); }
  const std::vector<Surface>& surfaces() const { return surfaces_.surfaces(); }
  // Surfaces where `show` put them last.
  std::optional<bed::Reached> reached_first(const std::vector<geom::Piece>& pieces,
                                            const bed::Flight& flight, double until) const {
    return bed::reached_first(pieces, flight, surfaces_, until);
  }
  // Where the surfaces are at `time` s, and their way in a window of length dt from there.
  void show(double time, double dt) { surfaces_.show(time, dt); }

  // Once forces of the stones where they begin are known; `on_surfaces`: N, on each surface.
  // Collective, as all below.
  void begin(const dem::Particles& particles, std::span<const Vec3> on_surfaces);
  // After each window of length dt: impulses, peaks and the work of what is driven.
  void watch(const dem::Particles& particles, std::span<const Vec3> on_surfaces, double dt);
  // What a history row shows at `time` s.
  observe::PlacedInstant instant(const dem::Particles& particles, double time) const;

  void save(io::File& file) const;
  void load(const io::File& file);

 private:
  // What contacts did so far: N s, N, and the force at the end of the last window, N.
  struct Felt {
    Vec3 impulse = Vec3::Zero();
    double peak = 0;
    Vec3 force = Vec3::Zero();
    void add(const Vec3& now, double dt);
  };
  std::vector<dem::ParticleView> stones_of(const dem::Particles& particles) const;
  double power(const std::vector<dem::ParticleView>& stones,
               std::span<const Vec3> on_surfaces) const;  // W, that drives supply
  double energy(const dem::Particles& particles) const;   // J

  const par::Comm& comm_;
  const Model& model_;
  bed::PlacedSurfaces surfaces_;
  std::vector<bed::PlacedShape> shapes_;
  std::vector<Quat> axes_;  // of each stone, from principal axes to those of its description
  std::vector<Felt> on_stones_, on_surfaces_;
  double energy_at_begin_ = 0, supplied_ = 0;  // J
  double power_ = 0;                           // W, at the end of the last window
};

}  // namespace trackbed::app
