// Exchange of surfaces between the ranks that own their nodes and the ranks whose stones may touch
// them. It contains no physics: positions and motions are sent out, sums of node loads are
// returned, both bitwise exact.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::couple {

// The particles' side of the balance, per window (sums over sub-steps, over all ranks).
struct Action {
  Vec3 force, moment;  // N, Nm about the origin
  double work;         // J
};

// Largest relative imbalance of any window up to now, between the action of the stones on surfaces
// and the loads that the owners of the nodes received. Scales (see src/couple/balance.hpp): sums of
// magnitudes over nodes, so that rounding is not amplified where forces cancel. A window without
// contact counts 0. `impulse` accumulates over the run (since the last resume), so that a drift is
// detected.
struct Balance {
  double force = 0, moment = 0, impulse = 0, work = 0;
};

class Coupler {
 public:
  explicit Coupler(const par::Comm& comm);
  ~Coupler();
  Coupler(Coupler&&) noexcept;

  // `owner[n]`: rank that moves node n. Empty: every rank moves all nodes identically (sleeper,
  // platen, wall), and each receives the whole load. Returns the number of the surface.
  std::size_t add(Surface& surface, std::vector<int> owner = {});
  void clear();
  // Determines which ranks need which nodes: those of triangles for which `reaches(low, high)`
  // holds. To be called after add and whenever the particles' partition changed. Collective.
  // A box spans the triangle over the window; one more ring of triangles is sent, because a contact
  // at an edge also needs the triangle beyond it.
  void connect(const std::function<bool(const Vec3& low, const Vec3& high)>& reaches);

  void publish();  // owners' position and motion -> ranks that need them
  // Sums the loads of all ranks on the owners, forms window means over `steps` sub-steps of the
  // window of length dt, checks them against the action of the particles, and clears the loads.
  void collect(int steps, double dt, const Action& action);
  // Mean force on each node in the last window, N; valid on own nodes.
  std::span<const Vec3> mean_force(std::size_t surface) const;
  // Largest component of any node's load in the last window, summed over its sub-steps, N; equal on
  // all ranks.
  double largest_load() const;
  // Message if the loads received in the last window differ from the action of the stones, or
  // empty.
  std::string trouble() const;
  const Balance& balance() const;
  void set_balance(const Balance& balance);  // when a run resumes
  // Mean force of own nodes, others zero (shared surfaces: on rank 0); the ranks' values are to be
  // summed.
  std::vector<Vec3> save_mean(std::size_t surface) const;
  void load_mean(std::size_t surface, std::span<const Vec3> mean);  // all nodes
  std::size_t received(std::size_t surface) const;  // nodes that `publish` brings to this rank

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trackbed::couple
