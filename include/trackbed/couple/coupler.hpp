// Moves surfaces between the ranks that own their nodes and the ranks whose stones may touch them.
// Knows no physics: positions and motions go out, sums of node loads come back, both to the bit.
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

// Largest relative imbalance of any window so far, between what stones did to surfaces and what the
// owners of the nodes received. Scales (see balance.hpp in the room): sums of magnitudes over
// nodes, so that forces which cancel do not turn rounding into a large number. A window without
// contact counts 0. `impulse` accumulates over the run (since the last resume), so that a drift
// shows.
struct Balance {
  double force = 0, moment = 0, impulse = 0, work = 0;
};

class Coupler {
 public:
  explicit Coupler(const par::Comm& comm);
  ~Coupler();
  Coupler(Coupler&&) noexcept;

  // `owner[n]`: rank that moves node n. Empty: every rank moves all nodes alike (sleeper, platen,
  // wall), and each gets the whole load back. Returns the number of the surface.
  std::size_t add(Surface& surface, std::vector<int> owner = {});
  void clear();
  // Works out who needs which node: those of triangles for which `reaches(low, high)` holds.
  // To be called after add and whenever the particles' partition changed. Collective.
  // A box spans the triangle over the window; one ring of triangles more is sent, because a contact
  // at an edge looks at the triangle beyond it.
  void connect(const std::function<bool(const Vec3& low, const Vec3& high)>& reaches);

  void publish();  // owners' position and motion -> ranks that need them
  // Sums the loads of all ranks on the owners, forms window means over `steps` sub-steps of the
  // window of length dt, checks them against what the particles felt, and clears the loads.
  void collect(int steps, double dt, const Action& action);
  // Mean force on each node in the last window, N; valid on own nodes.
  std::span<const Vec3> mean_force(std::size_t surface) const;
  // Largest component of any node's load in the last window, summed over its sub-steps, N; the same
  // on all ranks.
  double largest_load() const;
  // A sentence if surfaces did not get in the last window what stones gave them; else empty.
  std::string trouble() const;
  const Balance& balance() const;
  void set_balance(const Balance& balance);  // when a run resumes
  // Mean of own nodes, others zero (unowned surfaces: on rank 0): the sum over ranks is the whole.
  std::vector<Vec3> save_mean(std::size_t surface) const;
  void load_mean(std::size_t surface, std::span<const Vec3> mean);  // all nodes
  std::size_t received(std::size_t surface) const;  // nodes that `publish` brings to this rank

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace trackbed::couple
