// Communication of surfaces between ranks. Per window and surface with owners there is one message
// in each direction to every rank that shares nodes with this one, and one integer reduction for
// all other surfaces together: they are small (tens of nodes), and all ranks need their whole load.
#include "trackbed/couple/coupler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "balance.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/par/halo.hpp"

namespace trackbed::couple {

namespace {

// Position of a node at the start of the window and its displacement in it: all that contacts need.
using NodeMotion = std::array<double, 6>;  // position, motion in m: trivially copyable for halos

NodeMotion pack(const Surface& surface, std::size_t node) {
  const Vec3 &x = surface.position[node], &u = surface.motion[node];
  return {x[0], x[1], x[2], u[0], u[1], u[2]};
}

void unpack(const NodeMotion& values, Surface& surface, std::size_t node) {
  surface.position[node] = Vec3(values[0], values[1], values[2]);
  surface.motion[node] = Vec3(values[3], values[4], values[5]);
}

// Integers, see core/exact_sum.hpp: the order of summation does not change the result.
void add_to(NodeLoad& sum, const NodeLoad& term) {
  for (std::size_t k = 0; k < 3; ++k) {
    sum.force[k] += term.force[k];
    sum.first[k] += term.first[k];
  }
}

using Reaches = std::function<bool(const Vec3& low, const Vec3& high)>;

// Nodes of the triangles within reach and of those that share a node with one of them.
std::vector<bool> needed_nodes(const Surface& surface, const Reaches& reaches) {
  std::vector<bool> near(surface.nodes(), false), needed(surface.nodes(), false);
  for (const auto& triangle : surface.triangles) {
    const Vec3& corner = surface.position[static_cast<std::size_t>(triangle[0])];
    Vec3 low = corner, high = corner;
    // Nodes move on straight lines, so that the box of both ends contains the triangle at any time
    // in between.
    for (const std::int32_t n : triangle) {
      const auto node = static_cast<std::size_t>(n);
      const Vec3 end = surface.position[node] + surface.motion[node];
      low = low.cwiseMin(surface.position[node]).cwiseMin(end);
      high = high.cwiseMax(surface.position[node]).cwiseMax(end);
    }
    if (!reaches(low, high)) continue;
    for (const std::int32_t n : triangle) near[static_cast<std::size_t>(n)] = true;
  }
  for (const auto& triangle : surface.triangles) {
    const bool touched = std::any_of(triangle.begin(), triangle.end(), [&](std::int32_t n) {
      return near[static_cast<std::size_t>(n)];
    });
    if (touched)
      for (const std::int32_t n : triangle) needed[static_cast<std::size_t>(n)] = true;
  }
  return needed;
}

// A surface and its communication. Buffers are kept with the connection: no allocation per window.
struct Link {
  Surface* surface;
  std::vector<int> owner;            // empty: every rank moves all nodes
  std::vector<Vec3> mean;            // N
  std::vector<std::int32_t> mine;    // own nodes, ascending
  std::vector<std::int32_t> ghosts;  // nodes received, in the order of the halo
  par::Halo halo;                    // owners -> ranks in need
  std::vector<NodeMotion> motion_out, motion_in;
  std::vector<NodeLoad> load_out, load_in;

  // Shared surfaces (sleepers, walls, platen) move identically on all ranks and send no motion.
  bool shared() const { return owner.empty(); }
  void refresh(const par::Comm& comm);
  void connect(const par::Comm& comm, const Reaches& reaches);
  void publish();
  void gather();
};

// Updates the position of every node on every rank, so that each rank can determine the nodes
// within reach. Cost: all nodes of the surface on every rank, 48 bytes each; only at a rebuild, not
// per window. For tops of many millions of nodes boxes of the owners could be exchanged instead.
void Link::refresh(const par::Comm& comm) {
  std::vector<NodeMotion> own;
  for (const std::int32_t n : mine) own.push_back(pack(*surface, static_cast<std::size_t>(n)));
  const auto nodes = comm.all_gather<std::int32_t>(mine);
  const auto values = comm.all_gather<NodeMotion>(own);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    unpack(values[k], *surface, static_cast<std::size_t>(nodes[k]));
}

// Each rank requests the nodes it needs, and the owners receive the lists of what to send: no rank
// needs the positions of other ranks' stones. The order of `ghosts` (by owner, then by node) is
// that in which the halo delivers.
void Link::connect(const par::Comm& comm, const Reaches& reaches) {
  refresh(comm);
  const std::vector<bool> needed = needed_nodes(*surface, reaches);
  std::vector<std::vector<std::int32_t>> wanted(static_cast<std::size_t>(comm.size()));
  for (std::size_t n = 0; n < surface->nodes(); ++n) {
    if (owner[n] == comm.rank()) continue;
    if (needed[n])
      wanted[static_cast<std::size_t>(owner[n])].push_back(static_cast<std::int32_t>(n));
    else
      surface->motion[n].setZero();  // not used here; an old motion would displace it further
  }
  ghosts.clear();
  for (const auto& list : wanted) ghosts.insert(ghosts.end(), list.begin(), list.end());
  halo.connect(comm, comm.exchange(wanted));
  motion_out.resize(surface->nodes());
  motion_in.resize(ghosts.size());
  load_out.resize(ghosts.size());
  load_in.resize(halo.sent());
  publish();
}

// motion_out is as long as the surface, and only the items of the halo are filled: the halo selects
// by node number, so that no second numbering is needed.
void Link::publish() {
  for (const std::int32_t n : halo.items())
    motion_out[static_cast<std::size_t>(n)] = pack(*surface, static_cast<std::size_t>(n));
  halo.forward(motion_out.data(), motion_in.data());
  for (std::size_t k = 0; k < ghosts.size(); ++k)
    unpack(motion_in[k], *surface, static_cast<std::size_t>(ghosts[k]));
}

// Adds the loads of other ranks' stones on own nodes. Integers: any order gives the same sum.
void Link::gather() {
  for (std::size_t k = 0; k < ghosts.size(); ++k)
    load_out[k] = surface->load[static_cast<std::size_t>(ghosts[k])];
  halo.backward(load_out.data(), load_in.data());
  for (std::size_t k = 0; k < load_in.size(); ++k)
    add_to(surface->load[static_cast<std::size_t>(halo.items()[k])], load_in[k]);
}

}  // namespace

// Surfaces are not owned here: they belong to track, fem and bed. Their addresses must not change
// until `clear`, and their number of nodes is constant.
struct Coupler::Impl {
  explicit Impl(const par::Comm& world) : comm(world) {}
  void sum_shared();
  Received received(int steps) const;
  double largest_load() const;

  par::Comm comm;
  std::vector<Link> links;
  Ledger ledger;
  std::vector<std::int64_t> counts;  // of all unowned surfaces in turn, for one reduction
  double largest = 0;                // N, see `Coupler::largest_load`
};

// Every rank receives the whole load, because every rank moves the body. One reduction for all is
// faster than one for each: they are short, and latency dominates. Fixed walls are included, so
// that the balance covers them.
void Coupler::Impl::sum_shared() {
  counts.clear();
  for (const Link& link : links)
    if (link.shared())
      for (const NodeLoad& load : link.surface->load) {
        counts.insert(counts.end(), load.force.begin(), load.force.end());
        counts.insert(counts.end(), load.first.begin(), load.first.end());
      }
  if (counts.empty()) return;
  comm.sum(std::span(counts));
  auto next = counts.cbegin();
  for (Link& link : links)
    if (link.shared())
      for (NodeLoad& load : link.surface->load) {
        std::copy_n(next, 3, load.force.begin());
        std::copy_n(next + 3, 3, load.first.begin());
        next += 6;
      }
}

// Sums over the nodes after all communication, so that a lost load is detected.
Received Coupler::Impl::received(int steps) const {
  Received owned, total;
  bool any_owned = false;
  for (const Link& link : links) {
    any_owned = any_owned || !link.shared();
    if (link.shared())
      for (std::size_t n = 0; n < link.surface->nodes(); ++n) total.add(*link.surface, n, steps);
    else
      for (const std::int32_t n : link.mine)
        owned.add(*link.surface, static_cast<std::size_t>(n), steps);
  }
  // Owned nodes are summed over ranks; shared surfaces are already complete on each rank and must
  // not be summed.
  auto values = owned.pack();
  if (any_owned) comm.sum(std::span<double>(values));
  total.unpack_add(values);
  return total;
}

// Loads are exact and the maximum does not depend on the order: equal on any number of ranks.
double Coupler::Impl::largest_load() const {
  double most = 0;
  bool any_owned = false;
  const auto look = [&most](const Surface& surface, std::size_t n) {
    for (const std::int64_t count : surface.load[n].force)
      most = std::max(most, std::abs(static_cast<double>(count)) * surface.load_quantum);
  };
  for (const Link& link : links) {
    any_owned = any_owned || !link.shared();
    for (std::size_t n = 0; link.shared() && n < link.surface->nodes(); ++n) look(*link.surface, n);
    for (const std::int32_t n : link.mine) look(*link.surface, static_cast<std::size_t>(n));
  }
  return any_owned ? comm.max(most) : most;
}

Coupler::Coupler(const par::Comm& comm) : impl_(std::make_unique<Impl>(comm)) {}
Coupler::~Coupler() = default;
Coupler::Coupler(Coupler&&) noexcept = default;

// The mean of a surface that was just added is zero: the next window has no load, as the staggered
// scheme requires.
std::size_t Coupler::add(Surface& surface, std::vector<int> owner) {
  require(owner.empty() || owner.size() == surface.nodes(),
          "a surface has as many owners as nodes");
  Link link{.surface = &surface,
            .owner = std::move(owner),
            .mean = {},
            .mine = {},
            .ghosts = {},
            .halo = {},
            .motion_out = {},
            .motion_in = {},
            .load_out = {},
            .load_in = {}};
  link.mean.assign(surface.nodes(), Vec3::Zero());
  for (std::size_t n = 0; n < link.owner.size(); ++n)
    if (link.owner[n] == impl_->comm.rank()) link.mine.push_back(static_cast<std::int32_t>(n));
  surface.clear_load();
  impl_->links.push_back(std::move(link));
  return impl_->links.size() - 1;
}

void Coupler::clear() { impl_->links.clear(); }

void Coupler::connect(const Reaches& reaches) {
  for (Link& link : impl_->links)
    if (!link.shared()) link.connect(impl_->comm, reaches);
}

void Coupler::publish() {
  for (Link& link : impl_->links)
    if (!link.shared()) link.publish();
}

// Serial staggered scheme (Farhat, Lesoinne 2000, doi:10.1016/S0045-7825(99)00206-6): the owners
// use the mean over this window as the load of their next window. A mean conserves the impulse, sum
// F_k dt/n = mean dt, and with nodes that move linearly also the work. Order: communication,
// balance, mean, clear, so that the balance checks exactly the loads that the owners will use.
void Coupler::collect(int steps, double dt, const Action& action) {
  require(steps >= 1, "a mean is taken over at least one sub-step");
  for (Link& link : impl_->links)
    if (!link.shared()) link.gather();
  impl_->sum_shared();
  double quantum = 0;
  for (const Link& link : impl_->links) quantum = std::max(quantum, link.surface->load_quantum);
  impl_->ledger.record(impl_->received(steps), action, quantum, steps, dt);
  impl_->largest = impl_->largest_load();
  for (Link& link : impl_->links) {
    const double scale = link.surface->load_quantum / steps;
    for (std::size_t n = 0; n < link.mean.size(); ++n) {
      const auto& force = link.surface->load[n].force;
      for (int k = 0; k < 3; ++k)
        link.mean[n][k] = static_cast<double>(force[static_cast<std::size_t>(k)]) * scale;
    }
    link.surface->clear_load();
  }
}

std::span<const Vec3> Coupler::mean_force(std::size_t surface) const {
  return impl_->links.at(surface).mean;
}

double Coupler::largest_load() const { return impl_->largest; }

// Rounding is 1e-10 of the force at very small contact forces; integer overflow causes errors of
// order 1.
std::string Coupler::trouble() const {
  constexpr double lost = 1e-3;
  if (impl_->ledger.lost() <= lost) return {};
  return fmt::format(
      "the sum of the contact forces on a surface over one window has a relative error of {:.2g} "
      "(allowed: {:g}), probably by overflow of the fixed-point sum; largest "
      "sum at a node: {:.3g} N; shorten the window (time.window, time.substeps)",
      impl_->ledger.lost(), lost, impl_->largest);
}

const Balance& Coupler::balance() const { return impl_->ledger.balance(); }
void Coupler::set_balance(const Balance& balance) { impl_->ledger.set(balance); }

// Each node's value is non-zero on one rank only, so that the writer may sum over ranks.
std::vector<Vec3> Coupler::save_mean(std::size_t surface) const {
  const Link& link = impl_->links.at(surface);
  std::vector<Vec3> result(link.mean.size(), Vec3::Zero());
  if (link.shared() && impl_->comm.root()) result = link.mean;
  for (const std::int32_t n : link.mine)
    result[static_cast<std::size_t>(n)] = link.mean[static_cast<std::size_t>(n)];
  return result;
}

void Coupler::load_mean(std::size_t surface, std::span<const Vec3> mean) {
  Link& link = impl_->links.at(surface);
  require(mean.size() == link.mean.size(), "a saved mean force has as many rows as nodes");
  link.mean.assign(mean.begin(), mean.end());
}

std::size_t Coupler::received(std::size_t surface) const {
  return impl_->links.at(surface).ghosts.size();
}

}  // namespace trackbed::couple
