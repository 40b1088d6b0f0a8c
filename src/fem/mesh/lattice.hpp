// The regular block of elements of the ground: pure index arithmetic, no ranks.
//
// Elements and nodes are numbered with x fastest, then y, then z from the bottom up. A plane model
// has one element and one line of nodes across y. These numbers identify elements and nodes on
// every rank. In a periodic ground the nodes of both ends keep their numbers; those at the high end
// are images of those at the low end, their homes.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

using Index3 = std::array<std::int64_t, 3>;

// Cost: a few integer divisions per call; nothing is stored per element or node.
struct Lattice {
  bool plane = false;
  Index3 elements{};                         // in x, y, z
  Vec3 low, size;                            // m: lower corner, size of elements if equal
  std::array<std::vector<double>, 3> edges;  // m, along axes with unequal elements; else empty
  std::array<bool, 2> periodic{};            // along x, y

  int components() const { return plane ? 2 : 3; }
  int corners() const { return plane ? 4 : 8; }
  // Axis in space of a component: a plane model has x and z only.
  int axis(int component) const { return plane ? 2 * component : component; }
  // Nodes per direction.
  Index3 points() const { return {elements[0] + 1, plane ? 1 : elements[1] + 1, elements[2] + 1}; }
  std::int64_t element_count() const { return elements[0] * elements[1] * elements[2]; }
  std::int64_t node_count() const { return points()[0] * points()[1] * points()[2]; }
  std::int64_t home_count() const;  // of nodes that are not images
  Id home(Id node) const;           // of an image; otherwise the node itself
  int shown(Id home) const;         // number of its surface nodes: faces of a plane, images

  Id node(const Index3& p) const { return p[0] + points()[0] * (p[1] + points()[1] * p[2]); }
  Index3 node_index(Id id) const {
    const Index3 n = points();
    return {id % n[0], id / n[0] % n[1], id / (n[0] * n[1])};
  }
  Id element(const Index3& z) const { return z[0] + elements[0] * (z[1] + elements[1] * z[2]); }
  Index3 element_index(Id id) const {
    return {id % elements[0], id / elements[0] % elements[1], id / (elements[0] * elements[1])};
  }
  // Node at a corner: bits of `corner` are x, y, z in space and x, z in a plane.
  Id corner(const Index3& z, int corner) const {
    const int up = plane ? corner >> 1 : corner >> 2, across = plane ? 0 : corner >> 1 & 1;
    return node({z[0] + (corner & 1), z[1] + across, z[2] + up});
  }
  bool graded() const { return !edges[0].empty() || !edges[1].empty() || !edges[2].empty(); }
  double depth() const;  // m
  // m; a plane node is at mid-thickness.
  Vec3 position(Id node) const;
  Vec3 size_of(Id element) const;
  Vec3 centre(Id element) const;

  // Elements around a node that is not an image, at most 8: ascending, except that those across a
  // periodic end come first. Returns their number.
  int elements_at(Id node, std::array<Id, 8>& found) const;
};

Lattice make_lattice(const GroundParameters& parameters, Dimension dimension, double thickness);

bool contains(const Block& block, const Vec3& point);  // never if the block is not present

// Number of the layer or, after all layers, of the block that contains a point.
int region_at(const GroundParameters& parameters, const Vec3& point);
int block_at(const GroundParameters& parameters, const Vec3& point);  // -1: in none

// Solids of the ground: those of a mesh file in the order of the deck, or layers in turn, then
// blocks in turn; and the solid of each element. A layer whose modulus varies along x has one solid
// for each column of elements, or for several equal ones. Damping is that of the solid or of the
// ground. If elements differ in size, each solid occurs once for each size: all that follows from a
// solid and a size (stiffness, mass, yielding) follows from the number of a solid.
struct Solids {
  Solids(const GroundParameters& parameters, const Lattice& lattice);
  // Local: any rank may call it for any element.
  int of(const GroundParameters& parameters, const Lattice& lattice, Id element) const;
  // Solid of a layer or, after all layers, block in a column of elements; for tetrahedra, which are
  // not distinguished by size.
  int in(int region, std::int64_t column) const;

  std::vector<Elastic> solid;
  std::vector<Strength> strength;  // of each solid
  std::vector<std::string> name;
  std::vector<Vec3> size;            // m, of its elements
  std::vector<std::int32_t> region;  // layer or, after all layers, block; of a mesh its solid
  // For each solid the first one that differs from it only by a factor of Young's modulus, as the
  // columns of one layer and size do; mostly itself.
  std::vector<std::int32_t> alike;

 private:
  int kind_of(const GroundParameters& parameters, const Lattice& lattice, Id element) const;
  void separate_sizes(const GroundParameters& parameters, const Lattice& lattice);
  void find_alike(const GroundParameters& parameters);
  using KindAndSize = std::array<double, 4>;
  static KindAndSize key_of(int kind, const Vec3& size);

  std::map<KindAndSize, int> sized_;       // if elements differ in size
  std::vector<std::vector<int>> columns_;  // of each layer or block: one solid, or one per column
};

}  // namespace trackbed::fem
