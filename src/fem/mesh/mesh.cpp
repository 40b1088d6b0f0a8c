// The part of the lattice that one rank holds: partition, own nodes, held elements, ghosts.
//
// METIS cuts few faces, so few elements are computed twice: one layer of 40 between two halves of
// 40^3 elements. During set-up every rank visits every element, without messages, and the lists of
// the whole mesh are freed before the state is allocated. Rejected: sending forces back to owners,
// which needs a second message per step and a fixed order of sums.
#include "fem/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "fem/mesh/solid_mesh.hpp"
#include "fem/mesh/split.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Every rank computes all owners, which temporarily needs 56 bytes per element and no message.
std::vector<int> node_owners(const Lattice& lattice, const Solids& solids,
                             const GroundParameters& parameters, int ranks) {
  const auto nodes = static_cast<std::size_t>(lattice.node_count());
  if (ranks == 1) return std::vector<int>(nodes, 0);
  if (lattice.node_count() >= std::numeric_limits<std::int32_t>::max())
    throw InputError(
        {fmt::format("the ground has {} nodes; on several ranks it must have less than {}; use "
                     "fewer elements",
                     lattice.node_count(), std::numeric_limits<std::int32_t>::max())});
  std::vector<std::int32_t> corners;
  std::vector<double> cost;
  corners.reserve(static_cast<std::size_t>(lattice.element_count() * lattice.corners()));
  cost.reserve(static_cast<std::size_t>(lattice.element_count()));
  for (Id z = 0; z < lattice.element_count(); ++z) {
    const Index3 at = lattice.element_index(z);
    for (int k = 0; k < lattice.corners(); ++k)
      corners.push_back(static_cast<std::int32_t>(lattice.corner(at, k)));
    const auto solid = static_cast<std::size_t>(solids.of(parameters, lattice, z));
    cost.push_back(brick_cost.of(solids.strength[solid], at[2] + 1 == lattice.elements[2]));
  }
  // Elements are neighbours if they share a face: 4 nodes in space, 2 in a plane.
  std::vector<int> owner =
      split_nodes({corners, lattice.corners(), lattice.corners() / 2}, cost, corners, nodes, ranks);
  // An image and its home have the same owner, which holds the elements around both.
  const auto at_home = [&](Id id) -> int& {
    return owner[static_cast<std::size_t>(lattice.home(id))];
  };
  for (Id id = 0; id < lattice.node_count(); ++id)
    at_home(id) = std::min(at_home(id), owner[static_cast<std::size_t>(id)]);
  for (Id id = 0; id < lattice.node_count(); ++id)
    owner[static_cast<std::size_t>(id)] = at_home(id);
  return owner;
}

}  // namespace

void fold(const std::vector<Image>& images, Nodal& force) {
  for (std::vector<double>& numbers : force.of) {
    if (numbers.empty()) continue;  // a plane model has two
    for (const Image& image : images) {
      numbers[static_cast<std::size_t>(image.home)] +=
          numbers[static_cast<std::size_t>(image.node)];
      numbers[static_cast<std::size_t>(image.node)] = 0;
    }
  }
}

Mesh::Mesh(const par::Comm& communicator, const GroundParameters& parameters, Dimension dimension,
           double thickness)
    : comm(communicator),
      lattice(parameters.mesh.empty() ? make_lattice(parameters, dimension, thickness) : Lattice{}),
      solids(parameters, lattice) {
  if (parameters.of_tetrahedra()) {
    import(make_solid_mesh(parameters));
    return;
  }
  const std::vector<int> owner = node_owners(lattice, solids, parameters, comm.size());
  hold(owner, parameters);
  connect(owner);
  // The coupler needs the owners of all top nodes on every rank; both faces of a plane model belong
  // to the owner of the plane node.
  const Index3 points = lattice.points();
  const std::int64_t across = lattice.plane ? 2 : points[1];
  for (std::int64_t j = 0; j < across; ++j)
    for (std::int64_t i = 0; i < points[0]; ++i) {
      const Id id = lattice.node({i, lattice.plane ? 0 : j, lattice.elements[2]});
      top_owner.push_back(owner[static_cast<std::size_t>(id)]);
    }
  first_own = comm.exclusive_scan(static_cast<std::int64_t>(own.size()));
}

// Local: every rank has all owners.
void Mesh::hold(const std::vector<int>& owner, const GroundParameters& parameters) {
  for (Id z = 0; z < lattice.element_count(); ++z) {
    const Index3 at = lattice.element_index(z);
    bool touches = false;
    for (int k = 0; k < lattice.corners() && !touches; ++k)
      touches = owner[static_cast<std::size_t>(lattice.corner(at, k))] == comm.rank();
    if (!touches) continue;
    element.push_back(z);
    solid.push_back(solids.of(parameters, lattice, z));
    for (int k = 0; k < lattice.corners(); ++k) node.push_back(lattice.corner(at, k));
  }
  number(owner);
  line.resize(element.size());
  for (std::size_t z = 0; z < element.size(); ++z)
    for (int l = 0; l < lines(); ++l)
      line[z][static_cast<std::size_t>(l)] =
          local_node(lattice.corner(lattice.element_index(element[z]), 2 * l));
}

// From all nodes of the held elements, in any order and with repetitions.
void Mesh::number(const std::vector<int>& owner) {
  // Local numbers are ordered as global ones. Along a row of elements all nodes are held, so
  // neighbours along x are neighbours in memory too, as the kernel requires.
  std::sort(node.begin(), node.end());
  node.erase(std::unique(node.begin(), node.end()), node.end());
  node.shrink_to_fit();
  for (std::size_t n = 0; n < node.size(); ++n) {
    const bool mine = owner[static_cast<std::size_t>(node[n])] == comm.rank();
    const Id home = lattice.home(node[n]);
    owned.push_back(mine && home == node[n]);
    if (owned.back() != 0) own.push_back(static_cast<std::int32_t>(n));
    if (mine && home != node[n]) images.push_back({static_cast<std::int32_t>(n), local_node(home)});
  }
}

std::int32_t Mesh::home(std::int32_t n) const {
  const auto found =
      std::lower_bound(images.begin(), images.end(), n,
                       [](const Image& image, std::int32_t node) { return image.node < node; });
  return found == images.end() || found->node != n ? n : found->home;
}

// Each rank requests its ghosts from the owners; the requests determine what is sent in every step.
void Mesh::connect(const std::vector<int>& owner) {
  // Ascending by owner, then by number: the order in which the halo delivers.
  std::vector<std::vector<Id>> wanted(static_cast<std::size_t>(comm.size()));
  for (std::size_t n = 0; n < node.size(); ++n)
    if (const int rank = owner[static_cast<std::size_t>(node[n])]; rank != comm.rank())
      wanted[static_cast<std::size_t>(rank)].push_back(node[n]);
  for (const auto& from : wanted)
    for (const Id id : from) ghost_.push_back(local_node(id));
  // Nodes requested by other ranks, in their order; the halo sends them from a compact list.
  std::vector<std::vector<std::int32_t>> send(static_cast<std::size_t>(comm.size()));
  const auto asked = comm.exchange(wanted);
  for (std::size_t rank = 0; rank < asked.size(); ++rank)
    for (const Id id : asked[rank]) {
      send[rank].push_back(static_cast<std::int32_t>(shared_.size()));
      shared_.push_back(home(local_node(id)));
    }
  halo_.connect(comm, send);
  packed_.resize(3 * shared_.size());
  received_.resize(3 * ghost_.size());
}

// Binary search in a sorted list; used in set-up and for output, never in a step.
std::int32_t Mesh::local_node(Id id) const {
  const auto found = std::lower_bound(node.begin(), node.end(), id);
  if (found == node.end() || *found != id) return -1;
  return static_cast<std::int32_t>(found - node.begin());
}

std::int64_t Mesh::local_element(Id id) const {
  const auto found = std::lower_bound(element.begin(), element.end(), id);
  return found == element.end() || *found != id ? -1 : found - element.begin();
}

// All components of a node are in one item: one message per neighbour.
template <int D>
void Mesh::exchange_packed(Nodal& values) {
  using Item = std::array<double, D>;
  auto* packed = reinterpret_cast<Item*>(packed_.data());
  auto* received = reinterpret_cast<Item*>(received_.data());
  for (int c = 0; c < D; ++c)
    for (std::size_t s = 0; s < shared_.size(); ++s)
      packed[s][static_cast<std::size_t>(c)] = values[c][shared_[s]];
  halo_.forward(packed, received);
  for (int c = 0; c < D; ++c)
    for (std::size_t g = 0; g < ghost_.size(); ++g)
      values[c][ghost_[g]] = received[g][static_cast<std::size_t>(c)];
  for (int c = 0; c < D; ++c)
    for (const Image& image : images) values[c][image.node] = values[c][image.home];
}

void Mesh::exchange(Nodal& values) {
  lattice.plane ? exchange_packed<2>(values) : exchange_packed<3>(values);
}

// For numbers of unknowns: rarely called, so it may allocate.
std::vector<std::int64_t> Mesh::exchange(const std::vector<std::int64_t>& values) {
  std::vector<std::int64_t> sent(shared_.size()), received(ghost_.size()), result = values;
  for (std::size_t s = 0; s < shared_.size(); ++s)
    sent[s] = values[static_cast<std::size_t>(shared_[s])];
  halo_.forward(sent.data(), received.data());
  for (std::size_t g = 0; g < ghost_.size(); ++g)
    result[static_cast<std::size_t>(ghost_[g])] = received[g];
  for (const Image& image : images)
    result[static_cast<std::size_t>(image.node)] = result[static_cast<std::size_t>(image.home)];
  return result;
}

std::size_t Mesh::bytes() const {
  const std::size_t shape = !imported ? 0
                                      : imported->place.capacity() * sizeof(Vec3) +
                                            imported->corner.capacity() * 40 +
                                            imported->top_place.capacity() * 56;
  return shape + node.capacity() * sizeof(Id) + owned.capacity() + own.capacity() * 4 +
         images.capacity() * sizeof(Image) + element.capacity() * sizeof(Id) +
         solid.capacity() * 4 + line.capacity() * 16 + top_owner.capacity() * 4 +
         (packed_.capacity() + received_.capacity()) * 8;
}

}  // namespace trackbed::fem
