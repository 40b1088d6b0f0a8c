// Mass properties of unions of spheres and of disks.
//
// Along a line parallel to x the union is a set of intervals, over which 1, x and x^2 are
// integrated exactly; lines are spaced evenly in y and z (midpoint rule). Cells in x as well would
// cost `cells` times more and be less accurate; the exact union of balls (alpha shapes) is far more
// code.
#include <algorithm>
#include <cmath>
#include <limits>

#include "mass.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

using Interval = std::pair<double, double>;

struct Box {
  Vec3 low, high;
};

Box box_of(const std::vector<Sphere>& spheres) {
  constexpr double far = std::numeric_limits<double>::infinity();
  Box box{Vec3::Constant(far), Vec3::Constant(-far)};
  for (const Sphere& s : spheres) {
    box.low = box.low.cwiseMin(s.centre - Vec3::Constant(s.radius));
    box.high = box.high.cwiseMax(s.centre + Vec3::Constant(s.radius));
  }
  return box;
}

void add_interval(const Interval& part, double y, double z, double area, Integrals& sums) {
  const auto [a, b] = part;
  const double one = b - a, x = (b * b - a * a) / 2, xx = (b * b * b - a * a * a) / 3;
  sums.volume += area * one;
  sums.first += area * Vec3(x, y * one, z * one);
  Mat3 second;
  second << xx, x * y, x * z, x * y, one * y * y, one * y * z, x * z, one * y * z, one * z * z;
  sums.second += area * second;
}

// Adds the union along the line through (y, z); `parts` is a buffer.
void add_line(const std::vector<Sphere>& spheres, double y, double z, double area,
              std::vector<Interval>& parts, Integrals& sums) {
  parts.clear();
  for (const Sphere& s : spheres) {
    const double dy = y - s.centre.y(), dz = z - s.centre.z();
    const double square = s.radius * s.radius - dy * dy - dz * dz;
    if (square <= 0) continue;
    parts.emplace_back(s.centre.x() - std::sqrt(square), s.centre.x() + std::sqrt(square));
  }
  if (parts.empty()) return;
  std::sort(parts.begin(), parts.end());
  Interval merged = parts.front();
  for (const Interval& part : parts) {
    if (part.first > merged.second) {
      add_interval(merged, y, z, area, sums);
      merged = part;
    }
    merged.second = std::max(merged.second, part.second);
  }
  add_interval(merged, y, z, area, sums);
}

}  // namespace

Solid union_solid(const std::vector<Sphere>& spheres, int cells) {
  const auto [low, high] = box_of(spheres);
  const Vec3 size = high - low;
  const double wanted = std::max(size.y(), size.z()) / cells;
  const int rows = std::max(1, static_cast<int>(std::ceil(size.y() / wanted)));
  const int layers = std::max(1, static_cast<int>(std::ceil(size.z() / wanted)));
  const double dy = size.y() / rows, dz = size.z() / layers;
  Integrals sums;
  std::vector<Interval> parts;
  for (int j = 0; j < rows; ++j)
    for (int k = 0; k < layers; ++k)
      add_line(spheres, low.y() + (j + 0.5) * dy, low.z() + (k + 0.5) * dz, dy * dz, parts, sums);
  return solid_of(sums);
}

Solid union_lamina(const std::vector<Sphere>& disks, int cells) {
  std::vector<Sphere> flat = disks;
  for (Sphere& disk : flat) disk.centre.y() = 0;
  const auto [low, high] = box_of(flat);
  const double dz = (high.z() - low.z()) / cells;
  Integrals sums;
  std::vector<Interval> parts;
  for (int k = 0; k < cells; ++k) add_line(flat, 0, low.z() + (k + 0.5) * dz, dz, parts, sums);
  return lamina_of(sums);
}

}  // namespace trackbed::geom
