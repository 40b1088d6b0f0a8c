// Sums over stones and contacts in cells, bitwise identical for any distribution over ranks: terms
// are kept, their range is agreed on, then they are added as integers (observe/sums.hpp).
// Cost: one pass over stones and contacts; points are used only for stones that a border cuts.
#include "trackbed/observe/regions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "observe/sums.hpp"

namespace trackbed::observe {

namespace {

// Sums of a cell; a tensor has six consecutive ones.
enum Quantity : std::size_t {
  solid,
  mass,
  stones,
  partners,
  contacts,
  force,
  speed,
  speed_squared,
  stone_force,
  stone_force_squared,
  stress,
  fabric = stress + 6,
  quantities = fabric + 6
};

Tensor symmetric(const Vec3& a, const Vec3& b) {
  return {a.x() * b.x(),
          a.y() * b.y(),
          a.z() * b.z(),
          (a.x() * b.y() + a.y() * b.x()) / 2,
          (a.x() * b.z() + a.z() * b.x()) / 2,
          (a.y() * b.z() + a.z() * b.y()) / 2};
}

// The interval [first, second] of a segment (0 to 1) within a part of space; first > second: none.
using Interval = std::pair<double, double>;

// The region's cells: the cell of a point, and the fraction of a segment in each cell.
class Cells {
 public:
  Cells(const Region& region, const dem::Domain& domain) : region_(region) {
    const bool plane = domain.dimension == Dimension::plane;
    if (region.kind == RegionKind::sphere) {
      centre_ = {region.centre[0], plane ? 0 : region.centre[1], region.centre[2]};
      const Vec3 reach = Vec3::Constant(region.radius);
      low_ = centre_ - reach, high_ = centre_ + reach;
      volume_ = plane ? std::numbers::pi * region.radius * region.radius * domain.thickness
                      : 4.0 / 3 * std::numbers::pi * std::pow(region.radius, 3);
    } else {
      low_ = {region.x[0], region.y[0], region.z[0]};
      high_ = {region.x[1], region.y[1], region.z[1]};
      if (plane) low_.y() = -domain.thickness / 2, high_.y() = domain.thickness / 2;
      for (int a = 0; a < 3; ++a)
        number_[static_cast<std::size_t>(a)] =
            std::llround(region.cells[static_cast<std::size_t>(a)]);
      if (plane) number_[1] = 1;
      for (int a = 0; a < 3; ++a)
        size_[a] = (high_[a] - low_[a]) / static_cast<double>(number_[static_cast<std::size_t>(a)]);
      volume_ = size_.prod();
    }
  }
  double volume() const { return volume_; }  // m^3, of a cell
  const Vec3& low() const { return low_; }
  const Vec3& high() const { return high_; }
  std::size_t count() const {
    return static_cast<std::size_t>(number_[0] * number_[1] * number_[2]);
  }

  // A point on a border belongs to the cell above it.
  std::optional<std::size_t> at(const Vec3& p) const {
    if (region_.kind == RegionKind::sphere)
      return (p - centre_).squaredNorm() < region_.radius * region_.radius
                 ? std::optional<std::size_t>(0)
                 : std::nullopt;
    if ((p.array() < low_.array()).any() || (p.array() >= high_.array()).any()) return {};
    return number({index(p, 0), index(p, 1), index(p, 2)});
  }
  // The cell that contains the whole sphere, if any.
  std::optional<std::size_t> around(const Vec3& p, double r) const {
    const auto cell = at(p);
    if (!cell) return {};
    if (region_.kind == RegionKind::sphere)
      return (p - centre_).norm() + r <= region_.radius ? cell : std::nullopt;
    for (int a = 0; a < 3; ++a) {
      const double from = low_[a] + static_cast<double>(index(p, a)) * size_[a];
      if (p[a] - r < from || p[a] + r > from + size_[a]) return {};
    }
    return cell;
  }
  // Calls visit(cell, fraction of the segment from a to b within it).
  void along(const Vec3& a, const Vec3& b, const auto& visit) const {
    if (region_.kind == RegionKind::sphere) {
      const auto [first, second] = in_sphere(a, b);
      if (first < second) visit(std::size_t{0}, second - first);
      return;
    }
    std::array<std::int64_t, 3> from{}, to{};
    for (int k = 0; k < 3; ++k) {
      const auto axis = static_cast<std::size_t>(k);
      from[axis] = clamped(std::min(a[k], b[k]), k), to[axis] = clamped(std::max(a[k], b[k]), k);
    }
    for (std::int64_t i = from[0]; i <= to[0]; ++i)
      for (std::int64_t j = from[1]; j <= to[1]; ++j)
        for (std::int64_t k = from[2]; k <= to[2]; ++k) {
          const auto [first, second] = in_cell(a, b, {i, j, k});
          if (first < second) visit(number({i, j, k}), second - first);
        }
  }

 private:
  std::int64_t index(const Vec3& p, int axis) const { return clamped(p[axis], axis); }
  std::int64_t clamped(double value, int a) const {
    const std::int64_t last = number_[static_cast<std::size_t>(a)] - 1;
    if (last == 0) return 0;  // most regions have one cell: no division
    const double cell = std::floor((value - low_[a]) / size_[a]);
    return static_cast<std::int64_t>(std::clamp(cell, 0.0, static_cast<double>(last)));
  }
  std::size_t number(const std::array<std::int64_t, 3>& c) const {
    return static_cast<std::size_t>((c[2] * number_[1] + c[1]) * number_[0] + c[0]);
  }
  // A segment along a border counts for the cell above it, as points do.
  Interval in_cell(const Vec3& a, const Vec3& b, const std::array<std::int64_t, 3>& c) const {
    Interval interval{0, 1};
    for (int k = 0; k < 3; ++k) {
      const double from = low_[k] + static_cast<double>(c[static_cast<std::size_t>(k)]) * size_[k];
      const double length = b[k] - a[k], in = from - a[k], out = from + size_[k] - a[k];
      if (length == 0) {
        if (in > 0 || out <= 0) return {1, 0};
        continue;
      }
      interval.first = std::max(interval.first, std::min(in / length, out / length));
      interval.second = std::min(interval.second, std::max(in / length, out / length));
    }
    return interval;
  }
  // |a + s (b - a) - centre|^2 = r^2.
  Interval in_sphere(const Vec3& a, const Vec3& b) const {
    const Vec3 segment = b - a, from = a - centre_;
    const double square = segment.squaredNorm(), middle = segment.dot(from);
    const double root =
        middle * middle - square * (from.squaredNorm() - region_.radius * region_.radius);
    if (root <= 0 || square == 0) return {1, 0};
    return {std::max(0.0, (-middle - std::sqrt(root)) / square),
            std::min(1.0, (-middle + std::sqrt(root)) / square)};
  }

  const Region& region_;
  Vec3 centre_ = Vec3::Zero(), low_, high_;
  std::array<std::int64_t, 3> number_{1, 1, 1};
  Vec3 size_ = Vec3::Ones();
  double volume_ = 0;
};

// Calls visit(shift) for each periodic image of the box [low, high] that intersects the cells.
void images(const dem::Domain& domain, const Cells& cells, const Vec3& low, const Vec3& high,
            const auto& visit) {
  std::array<std::int64_t, 3> from{}, to{};
  Vec3 period = Vec3::Zero();
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    if (!domain.periodic[axis]) {
      if (low[a] > cells.high()[a] || high[a] < cells.low()[a]) return;
      continue;
    }
    period[a] = domain.high[a] - domain.low[a];
    from[axis] = std::llround(std::ceil((cells.low()[a] - high[a]) / period[a]));
    to[axis] = std::llround(std::floor((cells.high()[a] - low[a]) / period[a]));
  }
  for (std::int64_t i = from[0]; i <= to[0]; ++i)
    for (std::int64_t j = from[1]; j <= to[1]; ++j)
      for (std::int64_t k = from[2]; k <= to[2]; ++k)
        visit(Vec3(static_cast<double>(i) * period.x(), static_cast<double>(j) * period.y(),
                   static_cast<double>(k) * period.z()));
}

// Number of points of a stone in a cell.
using Points = std::pair<std::size_t, int>;

void count_in(std::size_t cell, std::vector<Points>& within) {
  const auto known = std::find_if(within.begin(), within.end(),
                                  [&](const Points& points) { return points.first == cell; });
  if (known == within.end())
    within.emplace_back(cell, 1);
  else
    ++known->second;
}

void add_stones(const dem::Particles& particles, const Cells& cells, Sums& sums) {
  constexpr double fraction = 1.0 / dem::Particles::points_of_particle;
  std::vector<Points> within;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView stone = particles[i];
    double reach = 0;  // m
    particles.pieces(i, [&](const Vec3& centre, double radius) {
      reach = std::max(reach, (centre - stone.position).norm() + radius);
    });
    const Vec3 around = Vec3::Constant(reach);
    images(particles.domain(), cells, stone.position - around, stone.position + around,
           [&](const Vec3& shift) {
             const Vec3 centre = stone.position + shift;
             if (const auto cell = cells.at(centre)) {
               sums.add(*cell, stones, 1);
               sums.add(*cell, speed, stone.velocity.norm());
               sums.add(*cell, speed_squared, stone.velocity.squaredNorm());
               sums.add(*cell, stone_force, stone.force.norm());
               sums.add(*cell, stone_force_squared, stone.force.squaredNorm());
             }
             if (const auto whole = cells.around(centre, reach)) {
               sums.add(*whole, solid, stone.volume), sums.add(*whole, mass, stone.mass);
               return;
             }
             within.clear();
             particles.points(i, [&](const Vec3& point) {
               if (const auto cell = cells.at(point + shift)) count_in(*cell, within);
             });
             for (const auto& [cell, points] : within) {
               sums.add(cell, solid, fraction * points * stone.volume);
               sums.add(cell, mass, fraction * points * stone.mass);
             }
           });
  }
}

// Two stones may touch with several pieces: they count once as partners. All contacts of a pair are
// counted on one rank.
void add_contacts(const dem::Particles& particles, const Cells& cells, Sums& sums) {
  struct Partner {
    Id one, other;
    std::size_t cell;
    auto operator<=>(const Partner&) const = default;
  };
  std::vector<Partner> found;
  const auto partner = [&](Id one, Id other, const Vec3& centre) {
    images(particles.domain(), cells, centre, centre, [&](const Vec3& shift) {
      if (const auto cell = cells.at(centre + shift)) found.push_back({one, other, *cell});
    });
  };
  particles.contacts([&](const dem::ContactView& c) {
    const Vec3 &a = c.first_centre, &b = c.second_centre, middle = (a + b) / 2;
    partner(c.first, c.second, a);
    if (c.second >= 0) partner(c.second, c.first, b);
    images(particles.domain(), cells, a.cwiseMin(b), a.cwiseMax(b), [&](const Vec3& shift) {
      cells.along(a + shift, b + shift, [&](std::size_t cell, double fraction) {
        sums.add(cell, stress, symmetric(fraction * c.force, b - a));
      });
      const auto cell = cells.at(middle + shift);
      if (!cell) return;
      sums.add(*cell, contacts, 1), sums.add(*cell, force, c.force.norm());
      sums.add(*cell, fabric, symmetric(c.normal, c.normal));
    });
  });
  particles.bonds([&](const dem::BondView& bond) {
    const Vec3 &a = bond.first_centre, &b = bond.second_centre;
    images(particles.domain(), cells, a.cwiseMin(b), a.cwiseMax(b), [&](const Vec3& shift) {
      cells.along(a + shift, b + shift, [&](std::size_t cell, double fraction) {
        sums.add(cell, stress, symmetric(fraction * bond.force, b - a));
      });
    });
  });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  for (const Partner& p : found) sums.add(p.cell, partners, 1);
}

Measurement measured_of(const double* sum, double volume) {
  const auto mean = [](double total, double count) { return count > 0 ? total / count : 0; };
  const auto deviation = [&](double total, double squares) {
    const double middle = mean(total, sum[stones]);
    const double square = mean(squares, sum[stones]) - middle * middle;
    return square < 0 ? 0 : std::sqrt(square);  // by rounding; what is not finite remains so
  };
  Measurement m;
  m.porosity = 1 - sum[solid] / volume;
  m.bulk_density = sum[mass] / volume;
  m.stones = sum[stones];
  m.coordination = mean(sum[partners], sum[stones]);
  m.contacts = sum[contacts];
  m.contact_force = mean(sum[force], sum[contacts]);
  m.speed = mean(sum[speed], sum[stones]);
  m.speed_deviation = deviation(sum[speed], sum[speed_squared]);
  m.stone_force = mean(sum[stone_force], sum[stones]);
  m.stone_force_deviation = deviation(sum[stone_force], sum[stone_force_squared]);
  for (std::size_t k = 0; k < 6; ++k) {
    m.stress[k] = sum[stress + k] / volume;
    m.fabric[k] = mean(sum[fabric + k], sum[contacts]);
  }
  return m;
}

}  // namespace

void Region::declare(input::Section& s) {
  s.text("name", name, "Name of the region in the results.", {}, true);
  s.choice("kind", kind, {"box", "sphere"}, "Shape of the region.");
  s.numbers("x", x, {.unit = "m"}, "Ends of the box along the track.", 2);
  s.numbers("y", y, {.unit = "m"},
            "Sides of the box; a plane model is measured over its whole thickness.", 2);
  s.numbers("z", z, {.unit = "m"}, "Lower and upper end of the box.", 2);
  s.numbers("cells", cells, {.at_least = 1, .at_most = 1000},
            "Number of equal cells along x, y and z, each with its own values (box).", 3);
  s.numbers("centre", centre, {.unit = "m"}, "Centre of the sphere (x, y, z).", 3);
  s.number("radius", radius, {.unit = "m", .above = 0, .usually_from = 1e-3, .usually_to = 10},
           "Radius of the sphere.");
  for (const auto& [key, ends] : {std::pair{"x", &x}, {"y", &y}, {"z", &z}})
    s.rule(key, ends->size() != 2 || (*ends)[0] < (*ends)[1], "must be two increasing numbers");
  const bool whole =
      std::all_of(cells.begin(), cells.end(), [](double n) { return n == std::floor(n); });
  s.rule("cells", whole, "must be whole numbers");
  // Each cell has numbers_of_cell numbers in every row of the histories.
  constexpr double most = 1e4;
  const double all = std::accumulate(cells.begin(), cells.end(), 1.0, std::multiplies<>());
  s.rule("cells", all <= most,
         fmt::format("must be at most {:g} cells in total, not {:g}", most, all));
}

std::vector<Measurement> measure(const par::Comm& comm, const dem::Particles& particles,
                                 const Region& region) {
  const Cells cells(region, particles.domain());
  Sums sums(quantities);
  add_stones(particles, cells, sums);
  add_contacts(particles, cells, sums);
  const std::vector<double> all = sums.over_ranks(comm, cells.count());
  const std::vector<double> fastest = sums.largest(comm, cells.count(), speed);
  const std::vector<double> strongest = sums.largest(comm, cells.count(), stone_force);
  std::vector<Measurement> measured;
  for (std::size_t cell = 0; cell < cells.count(); ++cell) {
    measured.push_back(measured_of(&all[cell * quantities], cells.volume()));
    measured.back().largest_speed = fastest[cell];
    measured.back().largest_stone_force = strongest[cell];
  }
  return measured;
}

}  // namespace trackbed::observe
