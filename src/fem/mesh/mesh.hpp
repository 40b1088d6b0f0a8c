// The part of the ground that one rank holds: its own nodes, every element that contains one of
// them, and the ghost nodes of these elements.
//
// An element at a rank border is held, and computed, on each rank that owns one of its nodes. So
// the force on a node is summed entirely by its owner, over its elements in ascending order:
// bitwise identical on any number of ranks, with one forward exchange of ghost displacement per
// step and no reverse one. The price is that elements of the border layer are computed twice.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "fem/mesh/lattice.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/par/halo.hpp"

namespace trackbed::fem {

// One value per component (x, y, z; in a plane x, z) and local node, components separate so that
// neighbours along x are adjacent; padded for loads of a whole vector beyond the last node.
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

// A node at the high end of a periodic ground and the own node at the low end that it represents.
struct Image {
  std::int32_t node, home;  // local
};
// Adds forces on images to their homes, in ascending order of images, and sets those of images to
// 0.
void fold(const std::vector<Image>& images, Nodal& force);

// Additional data of a rank for a ground of ten-node tetrahedra.
struct Imported {
  Id elements = 0, nodes = 0;                        // of all ranks
  double depth = 0;                                  // m, of the lowest node
  std::vector<Vec3> place;                           // m, of local nodes
  std::vector<std::array<std::int32_t, 10>> corner;  // local nodes of held elements
  // Boundary faces of held elements, ascending by element.
  struct Face {
    std::int32_t element, side;  // local; index into tetrahedron_faces
    BorderKind holds;            // of the top: free
    int axis;                    // of the normal, -1: oblique
    bool low;                    // normal against the axis
  };
  std::vector<Face> borders, top;
  // The top as a surface of triangles: the same on every rank.
  std::vector<Id> top_node;  // ascending
  std::vector<Vec3> top_place;
  std::vector<std::array<std::int32_t, 3>> top_triangles;
  std::vector<double> top_around;       // m^2, of the triangles at each corner; 0 at mid-edge
  double area_around(Id corner) const;  // of these, m^2
};

struct SolidMesh;

// Construction is collective; afterwards only `exchange` is.
struct Mesh {
  Mesh(const par::Comm& comm, const GroundParameters& parameters, Dimension dimension,
       double thickness);

  par::Comm comm;
  Lattice lattice;  // for tetrahedra only its number of components is used
  Solids solids;
  std::unique_ptr<const Imported> imported;       // for a ground of tetrahedra
  std::vector<Id> node;                           // local nodes, ascending
  std::vector<std::uint8_t> owned;                // of each node: 1 if owned here and not an image
  std::vector<Image> images;                      // of own nodes, ascending
  std::vector<std::int32_t> own;                  // local numbers of own nodes, ascending
  std::vector<Id> element;                        // held elements, ascending
  std::vector<std::int32_t> solid;                // of each element, index into solids
  std::vector<std::array<std::int32_t, 4>> line;  // of each element: its corners at low x
  std::vector<int> top_owner;                     // of every top node, on every rank
  Id first_own = 0;                               // number of own nodes of lower ranks

  std::size_t nodes() const { return node.size(); }
  int lines() const { return lattice.corners() / 2; }
  int corners() const { return imported ? 10 : lattice.corners(); }
  std::int32_t corner(std::size_t element, int k) const {
    if (imported) return imported->corner[element][static_cast<std::size_t>(k)];
    return line[element][static_cast<std::size_t>(k >> 1)] + (k & 1);
  }
  Vec3 position(std::int32_t node) const {  // m; a plane node is at mid-thickness
    const auto n = static_cast<std::size_t>(node);
    return imported ? imported->place[n] : lattice.position(this->node[n]);
  }
  Id element_count() const { return imported ? imported->elements : lattice.element_count(); }
  Id node_count() const { return imported ? imported->nodes : lattice.home_count(); }
  // The own node that an image represents; any other node is its own home.
  std::int32_t home(std::int32_t node) const;
  std::int32_t local_node(Id id) const;     // -1 if not held
  std::int64_t local_element(Id id) const;  // -1 if not held
  // An element is written by the owner of its first corner, which always holds it.
  bool writes(std::size_t z) const { return owned[static_cast<std::size_t>(corner(z, 0))] != 0; }

  // Sets ghosts from their owners and images from their homes. Collective.
  void exchange(Nodal& values);
  std::vector<std::int64_t> exchange(const std::vector<std::int64_t>& values);
  std::size_t bytes() const;

 private:
  using Owner = std::function<int(Id node)>;  // rank
  void hold(const std::vector<Id>& candidates, const Owner& owner,
            const GroundParameters& parameters);
  void number(const Owner& owner);
  void import(const SolidMesh& whole);
  void connect(const Owner& owner);
  template <int D>
  void exchange_packed(Nodal& values);

  par::Halo halo_;
  std::vector<std::int32_t> shared_, ghost_;  // local numbers in the order of messages
  std::vector<double> packed_, received_;
};

}  // namespace trackbed::fem
