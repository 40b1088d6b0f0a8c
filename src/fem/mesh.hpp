// What one rank holds of the ground: its own nodes, every zone that touches one of them, and the
// ghost nodes these zones need.
//
// A zone at a rank border is held, and computed, on each rank that owns one of its nodes. So the
// force on a node is summed entirely by its owner, over its zones in ascending order: the same bits
// on any number of ranks, and one forward exchange of ghost displacement per step, nothing back.
// The price is the zones of the border layer computed twice.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lattice.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/par/halo.hpp"

namespace trackbed::fem {

// One number per component (x, y, z; in a plane x, z) and local node, components apart so that
// neighbours along x lie side by side; padded for loads of a whole vector beyond the last node.
struct Nodal {
  static constexpr std::size_t padding = 64;
  std::array<std::vector<double>, 3> of;

  Nodal() = default;
  Nodal(int components, std::size_t nodes) {
    for (int c = 0; c < components; ++c) of[static_cast<std::size_t>(c)].resize(nodes + padding);
  }
  double* operator[](int component) { return of[static_cast<std::size_t>(component)].data(); }
  const double* operator[](int component) const {
    return of[static_cast<std::size_t>(component)].data();
  }
  void fill(double value) {
    for (auto& numbers : of) std::fill(numbers.begin(), numbers.end(), value);
  }
  std::size_t bytes() const {
    return sizeof(double) * (of[0].capacity() + of[1].capacity() + of[2].capacity());
  }
};

// Building is collective; afterwards only `exchange` is.
struct Mesh {
  Mesh(const par::Comm& comm, const GroundParameters& parameters, Dimension dimension,
       double thickness);

  par::Comm comm;
  Lattice lattice;
  Solids solids;
  std::vector<Id> node;                           // known here, ascending
  std::vector<std::uint8_t> owned;                // of each node: 1 if this rank's
  std::vector<std::int32_t> own;                  // local numbers of own nodes, ascending
  std::vector<Id> zone;                           // held here, ascending
  std::vector<std::int32_t> solid;                // of each zone, index into solids
  std::vector<std::array<std::int32_t, 4>> line;  // of each zone: its corners at low x
  std::vector<int> top_owner;                     // of every top node, on every rank
  Id first_own = 0;                               // own nodes of lower ranks

  std::size_t nodes() const { return node.size(); }
  int lines() const { return lattice.corners() / 2; }
  std::int32_t corner(std::size_t zone, int k) const {
    return line[zone][static_cast<std::size_t>(k >> 1)] + (k & 1);
  }
  std::int32_t local_node(Id id) const;  // -1 if not held
  std::int64_t local_zone(Id id) const;  // -1 if not held
  // A zone is written out by the owner of its first corner, which holds it in any case.
  bool writes(std::size_t z) const { return owned[static_cast<std::size_t>(line[z][0])] != 0; }

  // Ghost values from their owners. Collective.
  void exchange(Nodal& values);
  std::vector<std::int64_t> exchange(const std::vector<std::int64_t>& values);
  std::size_t bytes() const;

 private:
  void hold(const std::vector<int>& owner_of_node, const GroundParameters& parameters);
  void connect(const std::vector<int>& owner_of_node);
  template <int D>
  void exchange_packed(Nodal& values);

  par::Halo halo_;
  std::vector<std::int32_t> shared_, ghost_;  // local numbers in the order of the messages
  std::vector<double> packed_, received_;
};

}  // namespace trackbed::fem
