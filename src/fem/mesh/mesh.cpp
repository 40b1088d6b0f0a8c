// The part of the lattice that one rank holds: partition, own nodes, held elements, ghosts.
//
// Few elements are computed twice: one layer of 40 between two halves of 40^3 elements. Rejected:
// sending forces back to owners, which needs a second message per step and a fixed order of sums;
// METIS, which needs the whole mesh on every rank (docs/decisions/ground_elements.md).
#include "fem/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "fem/mesh/boxes.hpp"
#include "fem/mesh/solid_mesh.hpp"
#include "fem/mesh/split.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/par/memory.hpp"

namespace trackbed::fem {

namespace {

// Held and computed elements are those of the rank's box and one layer around it; across periodic
// ends the layer continues at the other end. Ascending.
std::vector<Id> elements_around(const Lattice& lattice, const IndexBox& box) {
  std::array<std::vector<std::int64_t>, 3> along;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t count = lattice.elements[a];
    for (std::int64_t k = box.begin[a] - 1; k <= box.end[a]; ++k)
      if (k >= 0 && k < count)
        along[a].push_back(k);
      else if (a < 2 && lattice.periodic[a])
        along[a].push_back((k + count) % count);
    std::sort(along[a].begin(), along[a].end());
    along[a].erase(std::unique(along[a].begin(), along[a].end()), along[a].end());
  }
  std::vector<Id> found;
  for (const std::int64_t z : along[2])
    for (const std::int64_t y : along[1])
      for (const std::int64_t x : along[0]) found.push_back(lattice.element({x, y, z}));
  return found;
}

Boxes boxes_of(const par::Comm& comm, const Lattice& lattice, const Solids& solids,
               const GroundParameters& parameters) {
  return {comm, lattice.elements, [&](const Index3& at) {
            const auto solid =
                static_cast<std::size_t>(solids.of(parameters, lattice, lattice.element(at)));
            return brick_cost.of(solids.strength[solid], at[2] + 1 == lattice.elements[2]);
          }};
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

namespace {

// Elements of a rank, and nodes of the top, which every rank has: a fifth below what was measured
// in space (docs/scaling.md), so that nothing that fits is refused.
constexpr double bytes_of_element = 300, bytes_of_top_node = 400;

void require_memory(const par::Comm& comm, const Lattice& lattice) {
  const auto along = [&](std::size_t axis) { return static_cast<double>(lattice.elements[axis]); };
  const double elements = along(0) * along(1) * along(2), top = (along(0) + 1) * (along(1) + 1);
  const double space = lattice.plane ? 0.5 : 1;
  par::require_memory(comm,
                      space * (bytes_of_element * elements / comm.size() + bytes_of_top_node * top),
                      fmt::format("the ground has {:.3g} elements", elements),
                      "is its size in m? Otherwise use fewer elements or more nodes");
}

Lattice lattice_in_memory(const par::Comm& comm, const GroundParameters& parameters,
                          Dimension dimension, double thickness) {
  Lattice lattice = make_lattice(parameters, dimension, thickness);
  require_memory(comm, lattice);
  return lattice;
}

}  // namespace

Mesh::Mesh(const par::Comm& communicator, const GroundParameters& parameters, Dimension dimension,
           double thickness)
    : comm(communicator),
      lattice(parameters.mesh.empty() ? lattice_in_memory(comm, parameters, dimension, thickness)
                                      : Lattice{}),
      solids(parameters, lattice) {
  if (parameters.of_tetrahedra()) {
    import(make_solid_mesh(parameters));
    return;
  }
  const Boxes boxes = boxes_of(comm, lattice, solids, parameters);
  // The lowest rank among those of the elements around it, a rule that every rank applies alone. An
  // image and its home have the same owner, which holds the elements around both.
  const IndexBox& mine = boxes.box_of(comm.rank());
  const auto owner = [&](Id id) {
    const Index3 at = lattice.node_index(id);
    bool inside = true;  // the rank's box, as most nodes are
    for (std::size_t a = 0; a < 3 && inside; ++a)
      inside = (lattice.plane && a == 1) || (mine.begin[a] < at[a] && at[a] < mine.end[a]);
    if (inside) return comm.rank();
    std::array<Id, 8> around;
    const int count = lattice.elements_at(lattice.home(id), around);
    int lowest = comm.size();
    for (int k = 0; k < count; ++k)
      lowest = std::min(lowest,
                        boxes.rank_of(lattice.element_index(around[static_cast<std::size_t>(k)])));
    return lowest;
  };
  hold(elements_around(lattice, mine), owner, parameters);
  connect(owner);
  // The coupler needs the owners of all top nodes on every rank; both faces of a plane model belong
  // to the owner of the plane node.
  const Index3 points = lattice.points();
  const std::int64_t across = lattice.plane ? 2 : points[1];
  for (std::int64_t j = 0; j < across; ++j)
    for (std::int64_t i = 0; i < points[0]; ++i) {
      const Id id = lattice.node({i, lattice.plane ? 0 : j, lattice.elements[2]});
      top_owner.push_back(owner(id));
    }
  first_own = comm.exclusive_scan(static_cast<std::int64_t>(own.size()));
}

// Of the candidates, the elements with a node of this rank.
void Mesh::hold(const std::vector<Id>& candidates, const Owner& owner,
                const GroundParameters& parameters) {
  for (const Id z : candidates) {
    const Index3 at = lattice.element_index(z);
    bool touches = false;
    for (int k = 0; k < lattice.corners() && !touches; ++k)
      touches = owner(lattice.corner(at, k)) == comm.rank();
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
void Mesh::number(const Owner& owner) {
  // Local numbers are ordered as global ones. Along a row of elements all nodes are held, so
  // neighbours along x are neighbours in memory too, as the kernel requires.
  std::sort(node.begin(), node.end());
  node.erase(std::unique(node.begin(), node.end()), node.end());
  node.shrink_to_fit();
  for (std::size_t n = 0; n < node.size(); ++n) {
    const bool mine = owner(node[n]) == comm.rank();
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
void Mesh::connect(const Owner& owner) {
  // Ascending by owner, then by number: the order in which the halo delivers.
  std::vector<std::vector<Id>> wanted(static_cast<std::size_t>(comm.size()));
  for (std::size_t n = 0; n < node.size(); ++n)
    if (const int rank = owner(node[n]); rank != comm.rank())
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
