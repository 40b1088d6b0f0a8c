// The arithmetic of features.hpp, eight features at a time and without branches: the case of a
// feature differs from lane to lane, so all cases are computed and one is selected. Distances are
// never negative here; points behind a face are handled elsewhere (stone_surface.cpp, deep.hpp).
// Used by two loops: over features of one kind (features.cpp) and over pairs (stone_blocks.cpp).
#pragma once

#include "dem/shape/features.hpp"

namespace trackbed::dem {

[[gnu::always_inline]] inline Lanes clamped(Lanes t, Lanes least = all(0)) {
  return smaller(larger(t, least), all(1) - least);
}

// Lengths of degenerate features are zero: the bound keeps the quotient finite.
[[gnu::always_inline]] inline Lanes over(Lanes length) {
  return all(1) / larger(length, all(1e-300));
}

// Distance and weighted sums from the closest point of i, the vector w from it to the closest point
// of j, and the value used as distance.
[[gnu::always_inline]] inline void finish(FeatureGroup& g, const Lanes3& on_i, const Lanes3& w,
                                          Lanes d) {
  // The point of contact is in the middle of the overlap, r_i - delta/2 from the core of i:
  //   half + d/2 = (r_i - r_j + d)/2 = r_i - (r_i + r_j - d)/2.
  g.d = d;
  g.n = over(d) * w, g.x = on_i + (g.half + 0.5 * d) * g.n;
  // Without overlap all weights are zero, and so are the added terms.
  const Lanes delta = larger(g.reach - d, all(0));
  const Lanes p2 = delta * delta, p4 = p2 * p2;
  g.power = p4 * p2;
  g.weight = p4 * delta;
  g.normal = g.weight * g.n;
  g.moment = cross(g.x, g.normal);
  g.point = g.weight * g.x;
  g.square = dot(g.x, g.point);
}

// Corner p0 and triangle p1 p2 p3: the projection onto the plane if it is inside, else the closest
// of the closest points of the three sides.
[[gnu::always_inline]] inline void corner_and_triangle(FeatureGroup& g) {
  const Lanes3 ap = g.p[0] - g.p[1], ab = g.p[2] - g.p[1], ac = g.p[3] - g.p[1], bc = ac - ab;
  const Lanes d1 = dot(ab, ap), d2 = dot(ac, ap);
  const Lanes b2 = dot(ab, ab), c2 = dot(ac, ac), mixed = dot(ab, ac), bc2 = dot(bc, bc);
  // 4 area^2 of the triangle (Gram's determinant); v and u are the weights of p2 and p3 times that.
  const Lanes area = b2 * c2 - mixed * mixed;
  const Lanes v = c2 * d1 - mixed * d2, u = b2 * d2 - mixed * d1;
  // A triangle without area (segment, spare lane) has no inside: its sides decide.
  const Mask inside = (v > all(0)) & (u > all(0)) & (v + u < area);
  const Lanes t_ab = clamped(d1 * over(b2)), t_ac = clamped(d2 * over(c2));
  const Lanes t_bc = clamped(dot(bc, ap - ab) * over(bc2));
  const Lanes3 e_ab = ap - t_ab * ab, e_ac = ap - t_ac * ac, e_bc = ap - ab - t_bc * bc;
  const Lanes l_ab = dot(e_ab, e_ab), l_ac = dot(e_ac, e_ac), l_bc = dot(e_bc, e_bc);
  // Of equally close sides the first.
  const Mask first = (l_ab <= l_ac) & (l_ab <= l_bc), second = l_ac <= l_bc;
  // The closest point is p1 + x ab + y ac.
  const Lanes x_side = select(first, t_ab, select(second, all(0), all(1) - t_bc));
  const Lanes y_side = select(first, all(0), select(second, t_ac, t_bc));
  const Lanes scale = over(area);
  const Lanes x = select(inside, v * scale, x_side), y = select(inside, u * scale, y_side);
  const Lanes3 q = x * ab + y * ac;
  const Lanes3 w = g.side * (q - ap);
  finish(g, select(g.side > all(0), g.p[0], g.p[1] + q), w, root(dot(w, w)));
}

// Edges p0 p1 of i and p2 p3 of j (Ericson 2005, 5.1.9), without branches: the second clamping
// corrects the first. The closest points of parallel edges are undetermined and would jump from end
// to end as they tilt: a face on a face did not reach equilibrium. So the least of
//   D^2 = |w(s, t)|^2 + h ((s - 1/2)^2 + (t - 1/2)^2)
// is taken as the distance: it gives one point for any pose, D has a continuous gradient w / D, and
// D - d is below `centring`^2 / 4 of the reach. The edges end slightly before their corners: where
// two corners are in contact, all their edges were closest there as well, up to 27 features in one
// point that made it 2.3 times as stiff. The corners replace the ends: while a contact passes from
// an edge to its corner, the overlap decreases by less than (`shortened` / 2)^2 / 2 of the reach.
[[gnu::always_inline]] inline void edge_and_edge(FeatureGroup& g) {
  constexpr double centring = 0.01;   // root of h over the reach
  constexpr double shortened = 0.05;  // at each end, over the reach
  const Lanes3 d1 = g.p[1] - g.p[0], d2 = g.p[3] - g.p[2], r = g.p[0] - g.p[2];
  const Lanes h = (centring * centring) * g.reach * g.reach;
  const Lanes a = dot(d1, d1) + h, e = dot(d2, d2) + h, b = dot(d1, d2);
  const Lanes c = 0.5 * h - dot(d1, r), f = 0.5 * h + dot(d2, r);
  const auto short_by = [&](const Lanes3& edge) {  // over its length; at most to its middle
    return smaller(shortened * g.reach * over(root(dot(edge, edge))), all(0.5));
  };
  const Lanes s_end = short_by(d1), t_end = short_by(d2);
  // The minimum of D^2 without bounds solves
  //   a s - b t = c,  e t - b s = f;
  // s is clamped, t follows and is clamped, then s follows from t once more. With h > 0 the
  // determinant a e - b^2 is positive for parallel edges too.
  const Lanes s0 = clamped((c * e + b * f) * over(a * e - b * b), s_end);
  const Lanes t = clamped((b * s0 + f) * over(e), t_end);
  const Lanes s = clamped((b * t + c) * over(a), s_end);
  const Lanes3 on_i = g.p[0] + s * d1, w = g.p[2] + t * d2 - on_i;
  const Lanes u = s - all(0.5), v = t - all(0.5);
  finish(g, on_i, w, root(dot(w, w) + h * (u * u + v * v)));
}

}  // namespace trackbed::dem
