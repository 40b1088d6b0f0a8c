// Mass properties of unions of spheres, of disks and of rounded convex pieces.
//
// Along a line parallel to x the union is a set of intervals, over which 1, x and x^2 are
// integrated exactly; lines are spaced evenly in y and z (midpoint rule). Cells in x as well would
// cost `cells` times more and be less accurate; the exact union of balls (alpha shapes) or of
// polyhedra is far more code.
//
// The midpoint rule errs by O(h^(3/2)), not h^2, because the length of a chord behaves like a
// square root at the border of a ball's projection. Cost: lines x shapes; no tree over the shapes,
// of which a stone has a few dozen at most.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "geom/convex/mass.hpp"
#include "trackbed/core/rotation.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

using Interval = std::pair<double, double>;

constexpr double far = std::numeric_limits<double>::infinity();
constexpr Interval nothing{far, -far};

// Empty as long as low is above high.
struct Box {
  Vec3 low = Vec3::Constant(far), high = Vec3::Constant(-far);
  void hold(const Vec3& centre, double radius) {
    low = low.cwiseMin(centre - Vec3::Constant(radius));
    high = high.cwiseMax(centre + Vec3::Constant(radius));
  }
};

Box box_of(const std::vector<Sphere>& spheres) {
  Box box;
  for (const Sphere& s : spheres) box.hold(s.centre, s.radius);
  return box;
}

Box box_of(const std::vector<Piece>& pieces) {
  Box box;
  for (const Piece& piece : pieces)
    for (const Vec3& corner : piece.core.vertices) box.hold(corner, piece.radius);
  return box;
}

// Intersection of the line through (y, z) with a sphere; first > second: none. A line that only
// touches has none: it adds no volume.
Interval chord(const Sphere& s, double y, double z) {
  const double dy = y - s.centre.y(), dz = z - s.centre.z();
  const double square = s.radius * s.radius - dy * dy - dz * dz;
  if (square <= 0) return nothing;
  return {s.centre.x() - std::sqrt(square), s.centre.x() + std::sqrt(square)};
}

// Part of a chord where normal . (x, y, z) <= offset. Clips the interval by one half space (Liang,
// Barsky). A line parallel to the plane is kept or removed as a whole.
void cut(Interval& chord, const Vec3& normal, double offset, double y, double z) {
  const double slope = normal.x(), rest = offset - normal.y() * y - normal.z() * z;
  if (slope > 0)
    chord.second = std::min(chord.second, rest / slope);
  else if (slope < 0)
    chord.first = std::max(chord.first, rest / slope);
  else if (rest < 0)
    chord = nothing;
}

// Intersection with the cylinder of radius r about the edge, between its ends. The distance of the
// point p + x d from the axis, both taken perpendicular to it, is r:
//   dd x^2 + 2 pd x + pp - r^2 = 0.
Interval chord(const Vec3& a, const Vec3& b, double r, double y, double z) {
  const Vec3 along = (b - a).normalized(), from = Vec3(0, y, z) - a;
  const Vec3 p = from - along.dot(from) * along, d = Vec3::UnitX() - along.x() * along;
  const double dd = d.squaredNorm(), pd = p.dot(d), root = pd * pd - dd * (p.squaredNorm() - r * r);
  if (root <= 0 || dd == 0) return nothing;  // an edge along the line adds nothing to its ends
  Interval part{(-pd - std::sqrt(root)) / dd, (-pd + std::sqrt(root)) / dd};
  cut(part, along, along.dot(b), y, z);
  cut(part, -along, -along.dot(a), y, z);
  return part;
}

// Intersection with the prism of height r on a face: half spaces of its lid, its base and its
// sides; the cross product of edge and normal points outward, as corners are counter-clockwise seen
// from the tip of the normal.
Interval chord(const Convex& core, const Face& face, double r, double y, double z) {
  Interval part{-far, far};
  cut(part, face.normal, face.offset + r, y, z);
  cut(part, -face.normal, -face.offset, y, z);
  const std::size_t n = face.vertices.size();
  for (std::size_t k = 0; k < n && part.first <= part.second; ++k) {
    const Vec3& a = core.vertices[static_cast<std::size_t>(face.vertices[k])];
    const Vec3& b = core.vertices[static_cast<std::size_t>(face.vertices[(k + 1) % n])];
    const Vec3 outward = (b - a).cross(face.normal);
    cut(part, outward, outward.dot(a), y, z);
  }
  return part;
}

// The piece is convex, so its chord spans those of its parts: core, a ball per corner, a cylinder
// per edge, a prism per face. Together they are the swept core; each chord is exact, so the span is
// too.
Interval chord(const Piece& piece, double y, double z) {
  Interval whole = nothing;
  const auto join = [&](const Interval& part) {
    if (part.first > part.second) return;
    whole = {std::min(whole.first, part.first), std::max(whole.second, part.second)};
  };
  const auto& [vertices, edges, faces] = piece.core;
  Interval inside{-far, far};
  for (const Face& face : faces) cut(inside, face.normal, face.offset, y, z);
  if (!faces.empty()) join(inside);
  if (piece.radius == 0) return whole;
  for (const Vec3& corner : vertices) join(chord(Sphere{corner, piece.radius}, y, z));
  for (const Edge& edge : edges)
    join(chord(vertices[static_cast<std::size_t>(edge.vertices[0])],
               vertices[static_cast<std::size_t>(edge.vertices[1])], piece.radius, y, z));
  for (const Face& face : faces) join(chord(piece.core, face, piece.radius, y, z));
  return whole;
}

// Exact in x; y and z are taken as constant over the cell, whose own extent about its line is
// neglected: that is part of the error of the rule.
void add_interval(const Interval& part, double y, double z, double area, Integrals& sums) {
  const auto [a, b] = part;
  const double one = b - a, x = (b * b - a * a) / 2, xx = (b * b * b - a * a * a) / 3;
  sums.volume += area * one;
  sums.first += area * Vec3(x, y * one, z * one);
  Mat3 second;
  second << xx, x * y, x * z, x * y, one * y * y, one * y * z, x * z, one * y * z, one * z * z;
  sums.second += area * second;
}

// Parts of the line through (y, z) within the union, in order, none touching the next. They are
// sorted by their begin, so one pass merges overlaps.
template <class Shapes>
void merge(const Shapes& shapes, double y, double z, std::vector<Interval>& parts) {
  parts.clear();
  for (const auto& shape : shapes) {
    const Interval part = chord(shape, y, z);
    if (part.first < part.second) parts.push_back(part);
  }
  std::sort(parts.begin(), parts.end());
  std::size_t last = 0;
  for (std::size_t k = 1; k < parts.size(); ++k)
    if (parts[k].first > parts[last].second)
      parts[++last] = parts[k];
    else
      parts[last].second = std::max(parts[last].second, parts[k].second);
  if (!parts.empty()) parts.resize(last + 1);
}

// Lines along x through the middles of cells of the box's projection, cells of about equal sides, a
// whole number in both directions: along y and z.
std::array<int, 2> number_of_lines(const Box& box, int cells) {
  const Vec3 size = box.high - box.low;
  const double wanted = std::max(size.y(), size.z()) / cells;
  return {std::max(1, static_cast<int>(std::ceil(size.y() / wanted))),
          std::max(1, static_cast<int>(std::ceil(size.z() / wanted)))};
}

// `visit(y, z, area)` of each.
void along_lines(const Box& box, int cells, const auto& visit) {
  const auto [rows, layers] = number_of_lines(box, cells);
  const double dy = (box.high - box.low).y() / rows, dz = (box.high - box.low).z() / layers;
  for (int j = 0; j < rows; ++j)
    for (int k = 0; k < layers; ++k)
      visit(box.low.y() + (j + 0.5) * dy, box.low.z() + (k + 0.5) * dz, dy * dz);
}

template <class Shapes>
Solid solid_by_lines(const Shapes& shapes, int cells) {
  Integrals sums;
  std::vector<Interval> parts;
  along_lines(box_of(shapes), cells, [&](double y, double z, double area) {
    merge(shapes, y, z, parts);
    for (const Interval& part : parts) add_interval(part, y, z, area, sums);
  });
  return solid_of(sums);
}

}  // namespace

Solid union_solid(const std::vector<Sphere>& spheres, int cells) {
  return solid_by_lines(spheres, cells);
}

double union_volume(const std::vector<Sphere>& spheres, int cells) {
  double volume = 0;
  std::vector<Interval> parts;
  along_lines(box_of(spheres), cells, [&](double y, double z, double area) {
    merge(spheres, y, z, parts);
    for (const auto& [from, to] : parts) volume += area * (to - from);
  });
  return volume;
}

Solid union_solid(const std::vector<Piece>& pieces, int cells) {
  return solid_by_lines(pieces, cells);
}

Integrals own_part(const std::vector<Sphere>& balls, std::size_t which, int cells) {
  const Sphere& own = balls[which];
  std::vector<Sphere> others;
  for (std::size_t k = 0; k < balls.size(); ++k)
    if (k != which && (balls[k].centre - own.centre).norm() < balls[k].radius + own.radius)
      others.push_back(balls[k]);
  Integrals sums;
  std::vector<Interval> covered;
  along_lines(box_of({own}), cells, [&](double y, double z, double area) {
    Interval left = chord(own, y, z);
    if (left.first > left.second) return;
    merge(others, y, z, covered);
    for (const auto& [from, to] : covered) {
      if (from > left.first)
        add_interval({left.first, std::min(from, left.second)}, y, z, area, sums);
      left.first = std::max(left.first, to);
      if (left.first >= left.second) return;
    }
    add_interval(left, y, z, area, sums);
  });
  return sums;
}

// Cauchy, Crofton: the surface of a convex body is four times the mean area of its projections. A
// line enters a body that is not convex several times and counts each. Directions over half a
// sphere, as the projection from behind is the same.
double union_area(const std::vector<Piece>& pieces, int directions, int cells) {
  double shadows = 0;  // m^2, each part of each line counted
  std::vector<Interval> parts;
  for (int k = 0; k < directions; ++k) {
    const double z = (k + 0.5) / directions, r = std::sqrt(1 - z * z);
    const double turn = 2 * std::numbers::pi * k / std::numbers::phi;
    const Quat to_x = rotation_onto(Vec3(r * std::cos(turn), r * std::sin(turn), z), Vec3::UnitX());
    std::vector<Piece> turned;
    for (const Piece& piece : pieces)
      turned.push_back({moved(piece.core, to_x, Vec3::Zero()), piece.radius});
    along_lines(box_of(turned), cells, [&](double y, double w, double area) {
      merge(turned, y, w, parts);
      shadows += area * static_cast<double>(parts.size());
    });
  }
  return 4 * shadows / directions;
}

// One row of lines: the disks are in one plane, y = 0, and lines need no thickness.
Solid union_lamina(const std::vector<Sphere>& disks, int cells) {
  std::vector<Sphere> flat = disks;
  for (Sphere& disk : flat) disk.centre.y() = 0;
  const auto [low, high] = box_of(flat);
  const double dz = (high.z() - low.z()) / cells;
  Integrals sums;
  std::vector<Interval> parts;
  for (int k = 0; k < cells; ++k) {
    const double z = low.z() + (k + 0.5) * dz;
    merge(flat, 0, z, parts);
    for (const Interval& part : parts) add_interval(part, 0, z, dz, sums);
  }
  return lamina_of(sums);
}

namespace {

// A line of a raster: its parts within a solid.
struct Line {
  double y;
  std::vector<Interval> parts;
  std::vector<double> lengths;  // m, of the parts
};

// The lines of a raster by layers of z.
struct Layer {
  double z;
  std::vector<Line> lines;
  std::vector<double> lengths;  // m, of the lines, all parts of each
};

struct Raster {
  Vec3 cell = Vec3::Zero();  // m between lines, along y and z
  std::vector<Layer> layers;
  std::vector<double> lengths;  // m, of the layers, all lines of each
  double length() const { return std::accumulate(lengths.begin(), lengths.end(), 0.0); }
};

Raster raster_of(const std::vector<Piece>& pieces, int cells, bool lamina) {
  Box box = box_of(pieces);
  if (lamina) box.low.y() = box.high.y() = 0;
  Raster raster;
  const auto [rows, layers] = number_of_lines(box, cells);
  raster.cell = (box.high - box.low).cwiseQuotient(Vec3(1, rows, layers));
  for (int k = 0; k < layers; ++k) {
    Layer layer{box.low.z() + (k + 0.5) * raster.cell.z(), {}, {}};
    for (int j = 0; j < rows; ++j) {
      Line line{box.low.y() + (j + 0.5) * raster.cell.y(), {}, {}};
      merge(pieces, line.y, layer.z, line.parts);
      for (const Interval& part : line.parts) line.lengths.push_back(part.second - part.first);
      layer.lengths.push_back(std::accumulate(line.lengths.begin(), line.lengths.end(), 0.0));
      layer.lines.push_back(std::move(line));
    }
    raster.lengths.push_back(std::accumulate(layer.lengths.begin(), layer.lengths.end(), 0.0));
    raster.layers.push_back(std::move(layer));
  }
  return raster;
}

// Position at the fraction `share` of the sum of all lengths: index, and how far into it (0 to 1).
struct Place {
  std::size_t which;
  double into;
};
Place place_of(const std::vector<double>& lengths, double share) {
  double left = share * std::accumulate(lengths.begin(), lengths.end(), 0.0);
  std::size_t last = 0;  // not empty, in case rounding leads beyond the end
  for (std::size_t k = 0; k < lengths.size(); ++k) {
    if (lengths[k] == 0) continue;
    if (left < lengths[k]) return {k, left / lengths[k]};
    left -= lengths[k], last = k;
  }
  return {last, 1};
}

// Digits of a whole number after the point, in reverse order (van der Corput): 0 to 1.
double mirrored(int number, int base) {
  double value = 0, digit = 1;
  for (int rest = number; rest > 0; rest /= base) value += (digit /= base) * (rest % base);
  return value;
}

// Disks of one radius may be the border of the area that they enclose: an outline with pebbles
// along it. Which is meant follows from the area; that of a clump is the area of its union, without
// hollows.
Raster lamina_raster(const Template& shape, int cells) {
  const double radius = shape.pieces.front().radius;
  Raster own = raster_of(shape.pieces, cells, true);
  // A prism across the plane, whose section is the hull: faces of a flat core do not bound a line.
  std::vector<Vec3> centres;
  for (const Piece& disk : shape.pieces) {
    if (disk.radius != radius) return own;
    for (const double y : {-radius, radius})
      for (const Vec3& c : disk.core.vertices) centres.emplace_back(c.x(), y, c.z());
  }
  Raster whole = raster_of({{convex_hull(centres), radius}}, cells, true);
  const auto off = [&](const Raster& raster) {
    return std::abs(raster.length() * raster.cell.z() - shape.volume);
  };
  return off(whole) < off(own) ? whole : own;
}

}  // namespace

// Points of Hammersley (1960, doi:10.1111/j.1749-6632.1960.tb42846.x), which fill a cube more
// evenly than a lattice as seen along any direction, mapped to the solid so that equal volumes stay
// equal (Rosenblatt 1952, doi:10.1214/aoms/1177729394): the first coordinate becomes a fraction of
// the volume along z, the second one of the layer there along y, the third one of the line along x.
// Points on a few dozen lines put whole rows on one side of a cut along them: 9 % of a ball.
std::vector<Vec3> points_within(const Template& shape, int count, bool lamina) {
  constexpr int cells = 64;
  const Raster raster =
      lamina ? lamina_raster(shape, cells) : raster_of(shape.pieces, cells, false);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const Place z = place_of(raster.lengths, (i + 0.5) / count);
    const Layer& layer = raster.layers[z.which];
    const Place y = place_of(layer.lengths, lamina ? 0 : mirrored(i, 3));
    const Line& line = layer.lines[y.which];
    const Place x = place_of(line.lengths, mirrored(i, 2));
    const auto& [from, to] = line.parts[x.which];
    points.emplace_back(from + x.into * (to - from), line.y + (y.into - 0.5) * raster.cell.y(),
                        layer.z + (z.into - 0.5) * raster.cell.z());
  }
  return points;
}

}  // namespace trackbed::geom
