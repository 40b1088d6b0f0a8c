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
#include <memory>
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

// A node at the high end of a periodic ground and the own node at the low end it stands for.
struct Image {
  std::int32_t node, home;  // local
};
// Forces on images go to their homes, in ascending order of images, and leave nothing behind.
void fold(const std::vector<Image>& images, Nodal& force);

// What a rank holds beside it of a ground whose zones are ten-node tetrahedra.
struct Imported {
  Id zones = 0, nodes = 0;                           // of all ranks
  double depth = 0;                                  // m, of the lowest node
  std::vector<Vec3> place;                           // m, of nodes known here
  std::vector<std::array<std::int32_t, 10>> corner;  // local nodes of zones held here
  // Outer faces of zones held here, ascending by zone.
  struct Face {
    std::int32_t zone, side;  // local; of tetrahedron_faces
    BorderKind holds;         // of the top: free
    int axis;                 // along which the normal points, -1: none
    bool low;                 // against it
  };
  std::vector<Face> borders, top;
  // The top as a surface of triangles: the same on every rank.
  std::vector<Id> top_node;  // ascending
  std::vector<Vec3> top_place;
  std::vector<std::array<std::int32_t, 3>> top_triangles;
  std::vector<double> top_around;       // m^2, of the triangles at each corner; 0 amid an edge
  double area_around(Id corner) const;  // of these, m^2
};

struct SolidMesh;

// Building is collective; afterwards only `exchange` is.
struct Mesh {
  Mesh(const par::Comm& comm, const GroundParameters& parameters, Dimension dimension,
       double thickness);

  par::Comm comm;
  Lattice lattice;  // of tetrahedra only its number of components means something
  Solids solids;
  std::unique_ptr<const Imported> imported;       // if the ground is of tetrahedra
  std::vector<Id> node;                           // known here, ascending
  std::vector<std::uint8_t> owned;                // of each node: 1 if this rank's, and no image
  std::vector<Image> images;                      // of own nodes, ascending
  std::vector<std::int32_t> own;                  // local numbers of own nodes, ascending
  std::vector<Id> zone;                           // held here, ascending
  std::vector<std::int32_t> solid;                // of each zone, index into solids
  std::vector<std::array<std::int32_t, 4>> line;  // of each zone: its corners at low x
  std::vector<int> top_owner;                     // of every top node, on every rank
  Id first_own = 0;                               // own nodes of lower ranks

  std::size_t nodes() const { return node.size(); }
  int lines() const { return lattice.corners() / 2; }
  int corners() const { return imported ? 10 : lattice.corners(); }
  std::int32_t corner(std::size_t zone, int k) const {
    if (imported) return imported->corner[zone][static_cast<std::size_t>(k)];
    return line[zone][static_cast<std::size_t>(k >> 1)] + (k & 1);
  }
  Vec3 position(std::int32_t node) const {  // m; a plane node lies amid the thickness
    const auto n = static_cast<std::size_t>(node);
    return imported ? imported->place[n] : lattice.position(this->node[n]);
  }
  Id zone_count() const { return imported ? imported->zones : lattice.zone_count(); }
  Id node_count() const { return imported ? imported->nodes : lattice.home_count(); }
  // The own node that an image stands for; any other node is its own home.
  std::int32_t home(std::int32_t node) const;
  std::int32_t local_node(Id id) const;  // -1 if not held
  std::int64_t local_zone(Id id) const;  // -1 if not held
  // A zone is written out by the owner of its first corner, which holds it in any case.
  bool writes(std::size_t z) const { return owned[static_cast<std::size_t>(corner(z, 0))] != 0; }

  // Values of ghosts from their owners, of images from their homes. Collective.
  void exchange(Nodal& values);
  std::vector<std::int64_t> exchange(const std::vector<std::int64_t>& values);
  std::size_t bytes() const;

 private:
  void hold(const std::vector<int>& owner_of_node, const GroundParameters& parameters);
  void number(const std::vector<int>& owner_of_node);
  void import(const SolidMesh& whole);
  void connect(const std::vector<int>& owner_of_node);
  template <int D>
  void exchange_packed(Nodal& values);

  par::Halo halo_;
  std::vector<std::int32_t> shared_, ghost_;  // local numbers in the order of the messages
  std::vector<double> packed_, received_;
};

}  // namespace trackbed::fem
