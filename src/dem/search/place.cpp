// Pieces in space, from the poses of their particles.
#include <cmath>

#include "dem/lanes/rows.hpp"
#include "dem/search/pairs.hpp"

namespace trackbed::dem {

// Once for each rebuild, own particles and ghosts alike. `begin` has one more entry at the end, so
// that every range is given by two neighbouring entries.
void lay_out(const State& state, const Shapes& shapes, Pieces& pieces) {
  pieces = {};
  pieces.begin.assign(1, 0);
  const bool stones = shapes.any_stones();
  for (std::size_t b = 0; b < state.size(); ++b) {
    for (std::size_t k = shapes.begin(state.shape[b]); k < shapes.end(state.shape[b]); ++k) {
      pieces.body.push_back(static_cast<std::int32_t>(b));
      pieces.x.push_back({0, 0, 0, shapes.piece(k).w * state.scale_now(b)});
      if (!stones) continue;
      pieces.core.push_back(static_cast<std::uint32_t>(k));
      pieces.rounding.push_back(shapes.core(k).radius * state.scale_now(b));
    }
    pieces.begin.push_back(pieces.body.size());
  }
  if (!stones) return;
  pieces.turns.resize(3 * state.size());
  pieces.last_x = state.x, pieces.last_q = state.q;
  pieces.path.assign(state.size(), 0), pieces.pace.assign(state.size(), 0);
  pieces.last_path.assign(state.size(), 0);
}

namespace {

// The columns of scale times rotation, to rotate a row at once.
struct Turn {
  Four x, y, z;
  explicit Turn(const Vec4* columns)
      : x(four(columns[0])), y(four(columns[1])), z(four(columns[2])) {}
  Turn(const Vec4& q, double scale) {
    const Mat3 m = scale * quat(q).toRotationMatrix();
    x = Four{m(0, 0), m(1, 0), m(2, 0), 0};
    y = Four{m(0, 1), m(1, 1), m(2, 1), 0};
    z = Four{m(0, 2), m(1, 2), m(2, 2), 0};
  }
  [[gnu::always_inline]] Four operator()(const Vec4& o) const {
    return x * o.x + y * o.y + z * o.z;
  }
};

// Bound of the displacement of a surface point since the last pose, m: displacement of the centre
// and arc of the farthest point, |q - q0| = 2 sin(angle/4); 2.1 covers angles up to 1 rad. An upper
// bound for every point: kept features remain valid until such paths have used up their margin.
double displacement(const Vec4& x, const Vec4& q, const Vec4& x0, const Vec4& q0) {
  const double dx = x.x - x0.x, dy = x.y - x0.y, dz = x.z - x0.z;
  const double a = q.x - q0.x, b = q.y - q0.y, c = q.z - q0.z, d = q.w - q0.w;
  return std::sqrt(dx * dx + dy * dy + dz * dz) +
         2.1 * x.w * std::sqrt(a * a + b * b + c * c + d * d);
}

// A piece of a particle at its centre; `in_template` relative to that in the template.
[[gnu::always_inline]] inline void place_piece(const Turn& turn, const Vec4& centre,
                                               const Vec4& in_template, Vec4& x) {
  const Four o = turn(in_template);
  x.x = centre.x + o[0], x.y = centre.y + o[1], x.z = centre.z + o[2];
}

}  // namespace

// From the pose alone and not from the previous position, so that no error grows and ghosts are
// bitwise identical to their owners. Corners are not placed here but rotated where they are needed:
// a stone in a bed uses a fourth of its corners, and data written for all of them leave the caches
// before they are read.
void place(const State& state, const Shapes& shapes, Pieces& pieces) {
  const bool stones = shapes.any_stones();
  for (std::size_t b = 0; b < state.size(); ++b) {
    const Vec4& centre = state.x[b];
    const Turn turn(state.q[b], state.scale_now(b));
    const std::size_t first = shapes.begin(state.shape[b]) - pieces.begin[b];
    for (std::size_t p = pieces.begin[b]; p < pieces.begin[b + 1]; ++p)
      place_piece(turn, centre, shapes.piece(first + p), pieces.x[p]);
    if (!stones) continue;
    Vec4* columns = pieces.turns.data() + 3 * b;
    put(columns[0], turn.x), put(columns[1], turn.y), put(columns[2], turn.z);
    // Lengths of paths are added up, not the distance from the start: the sum of two of them bounds
    // the approach of a pair without considering directions.
    pieces.path[b] += displacement(centre, state.q[b], pieces.last_x[b], pieces.last_q[b]);
    pieces.pace[b] = pieces.path[b] - pieces.last_path[b];  // including growth
    pieces.last_path[b] = pieces.path[b];
    pieces.last_x[b] = centre, pieces.last_q[b] = state.q[b];
  }
}

void place(const State& state, const Shapes& shapes, std::span<const std::int32_t> wanted,
           Pieces& pieces) {
  for (auto piece = wanted.begin(); piece != wanted.end();) {
    const std::int32_t body = pieces.body[static_cast<std::size_t>(*piece)];
    const auto b = static_cast<std::size_t>(body);
    const Turn turn(state.q[b], state.scale_now(b));
    const Vec4 centre = state.x[b];
    const std::size_t first = shapes.begin(state.shape[b]) - pieces.begin[b];
    for (; piece != wanted.end() && pieces.body[static_cast<std::size_t>(*piece)] == body;
         ++piece) {
      const auto p = static_cast<std::size_t>(*piece);
      place_piece(turn, centre, shapes.piece(first + p), pieces.x[p]);
    }
  }
}

// Relative to the centre of mass: their digits do not depend on the position along the track. In
// the order of operations of `BlockPoints` (stone_blocks.cpp), hence bitwise identical.
void append_corners(const Shapes& shapes, const Pieces& pieces, std::size_t piece,
                    std::vector<Vec4>& corners) {
  const Turn turn(pieces.turns.data() + 3 * static_cast<std::size_t>(pieces.body[piece]));
  for (const Vec4& c : shapes.core(pieces.core[piece]).corners)
    put(corners.emplace_back(), turn(c));
}

}  // namespace trackbed::dem
