// The regular block of zones the ground is meshed with: pure index arithmetic, no ranks.
//
// Zones and nodes are counted with x fastest, then y, then z from the bottom up. A plane model has
// one zone and one line of nodes across y. These numbers name zones and nodes on every rank. Where
// the ground is periodic the nodes of both ends keep their numbers; those at the high end are
// images of those at the low end, their homes.
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

// Cost: a few integer divisions per question; nothing is stored per zone or node.
struct Lattice {
  bool plane = false;
  Index3 zones{};                            // in x, y, z
  Vec3 low, size;                            // m: lower corner, size of a zone where all are alike
  std::array<std::vector<double>, 3> edges;  // m, along axes on which zones differ; empty: alike
  std::array<bool, 2> periodic{};            // along x, y

  int components() const { return plane ? 2 : 3; }
  int corners() const { return plane ? 4 : 8; }
  // Axis in space of a component: a plane model has x and z alone.
  int axis(int component) const { return plane ? 2 * component : component; }
  // Nodes per direction.
  Index3 points() const { return {zones[0] + 1, plane ? 1 : zones[1] + 1, zones[2] + 1}; }
  std::int64_t zone_count() const { return zones[0] * zones[1] * zones[2]; }
  std::int64_t node_count() const { return points()[0] * points()[1] * points()[2]; }
  std::int64_t home_count() const;  // of nodes that are no images
  Id home(Id node) const;           // of an image; otherwise the node itself
  int shown(Id home) const;         // by how many nodes of the surface: faces of a plane and images

  Id node(const Index3& p) const { return p[0] + points()[0] * (p[1] + points()[1] * p[2]); }
  Index3 node_index(Id id) const {
    const Index3 n = points();
    return {id % n[0], id / n[0] % n[1], id / (n[0] * n[1])};
  }
  Id zone(const Index3& z) const { return z[0] + zones[0] * (z[1] + zones[1] * z[2]); }
  Index3 zone_index(Id id) const {
    return {id % zones[0], id / zones[0] % zones[1], id / (zones[0] * zones[1])};
  }
  // Node at a corner: bits of `corner` are x, y, z in space and x, z in a plane.
  Id corner(const Index3& z, int corner) const {
    const int up = plane ? corner >> 1 : corner >> 2, across = plane ? 0 : corner >> 1 & 1;
    return node({z[0] + (corner & 1), z[1] + across, z[2] + up});
  }
  bool graded() const { return !edges[0].empty() || !edges[1].empty() || !edges[2].empty(); }
  double depth() const;  // m
  // m; a plane node lies amid the thickness.
  Vec3 position(Id node) const;
  Vec3 size_of(Id zone) const;
  Vec3 centre(Id zone) const;

  // Zones that touch a node that is no image, at most 8: ascending, but what lies across a periodic
  // end comes first. Returns how many.
  int zones_at(Id node, std::array<Id, 8>& found) const;
};

Lattice make_lattice(const GroundParameters& parameters, Dimension dimension, double thickness);

// Number of the layer or, after all layers, block that a point lies in.
int region_at(const GroundParameters& parameters, const Vec3& point);
int block_at(const GroundParameters& parameters, const Vec3& point);  // -1: in none

// Solids of the ground: those of a mesh file in the order of the deck, or layers in turn, then
// blocks in turn, and which one a zone has. A layer whose modulus changes along x has one for each
// column of zones, or several if they are equal. Damping is the solid's own or the ground's. Where
// zones differ in size, each of these is there once for each size: what follows from a solid and a
// size (stiffness, mass, yielding) follows from the number of a solid.
struct Solids {
  Solids(const GroundParameters& parameters, const Lattice& lattice);
  // Local: any rank may ask for any zone.
  int of(const GroundParameters& parameters, const Lattice& lattice, Id zone) const;
  // Of a layer or, after all layers, block in a column of zones; of tetrahedra, which no size tells
  // apart.
  int in(int region, std::int64_t column) const;

  std::vector<Elastic> solid;
  std::vector<Strength> strength;  // of each solid
  std::vector<std::string> name;
  std::vector<Vec3> size;            // m, of its zones
  std::vector<std::int32_t> region;  // layer or, after all layers, block; of a mesh its solid
  // Of each solid the first one that differs from it by a factor of Young's modulus alone, as the
  // columns of one layer and size do; mostly itself.
  std::vector<std::int32_t> alike;

 private:
  int kind_of(const GroundParameters& parameters, const Lattice& lattice, Id zone) const;
  void tell_sizes_apart(const GroundParameters& parameters, const Lattice& lattice);
  void find_alike(const GroundParameters& parameters);
  using KindAndSize = std::array<double, 4>;
  static KindAndSize key_of(int kind, const Vec3& size);

  std::map<KindAndSize, int> sized_;       // of zones that are not all alike
  std::vector<std::vector<int>> columns_;  // of each layer or block: one solid, or one per column
};

}  // namespace trackbed::fem
