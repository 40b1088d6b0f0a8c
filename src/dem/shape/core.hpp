// Corners, edges and triangles of a piece with more than one vertex, as the contact kernels read
// them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "dem/lanes/vec4.hpp"
#include "trackbed/geom/convex.hpp"

namespace trackbed::dem {

// Corner numbers fit in a byte, so that a pair of features is one word of four.
inline constexpr std::size_t most_corners = 255;

// Contact geometry of a piece. Made once for each template and never changed; a particle scales and
// rotates it.
struct Core {
  using Edge = std::array<std::uint8_t, 2>;
  using Triangle = std::array<std::uint8_t, 3>;  // counter-clockwise seen from outside

  std::vector<Vec4> corners;  // m at unit scale, from the particle's centre of mass
  std::vector<Edge> edges;
  // Faces cut into fans; the distance to a face is the least to its triangles, however it is cut. A
  // segment has one triangle without area; a flat core has one of its two sides only.
  std::vector<Triangle> triangles;
  double radius = 0;  // m at unit scale
  bool flat = false;  // in a plane: its edges are the border of its triangles
};

// Throws std::invalid_argument if it has no vertex, more than `most_corners` or no radius.
Core core_of(const geom::Piece& piece);

// Ball around the piece, rounding included: centre and, in w, radius (m at unit scale).
Vec4 ball_around(const Core& core);

}  // namespace trackbed::dem
