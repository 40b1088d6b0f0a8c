// Generates the stones; each rank generates a fraction of them.
// Columns are generated independently, so the cost of a rank is that of its own stones and one
// exchange with their owners; docs/decisions/packing.md describes the lattice of cells they
// replaced.
//
// The order of ids, and so every contact's order of summation, depends only on the numbers of
// stones and columns: a bed is bitwise identical on any number of ranks.
#include <fmt/format.h>

#include <algorithm>

#include "columns.hpp"
#include "trackbed/bed/bed.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::bed {

namespace {

// A box narrower than this many largest bounds gets no stones: Columns require a little more than
// 2.
constexpr double narrowest = 2.1;

// Columns that start at a height and whose stones' ids begin with `first`.
struct Batch {
  Columns columns;
  Id first = 0;
  double foot = 0;  // m
};

// Stones of columns [begin, begin + count) of all batches; increases `top` to the height they
// reach.
// Local.
std::vector<dem::NewParticle> build(const std::vector<Batch>& batches, std::size_t begin,
                                    std::size_t count, double& top) {
  std::vector<dem::NewParticle> stones;
  std::size_t number = 0;
  for (const Batch& batch : batches)
    for (std::int64_t c = 0; c < batch.columns.count(); ++c, ++number) {
      if (number < begin || number >= begin + count) continue;
      const std::size_t old = stones.size();
      top = std::max(top, batch.foot + batch.columns.build(c, stones));
      for (std::size_t i = old; i < stones.size(); ++i) {
        stones[i].id += batch.first;
        stones[i].position.z() += batch.foot;
      }
    }
  return stones;
}

// Every rank generates an equal fraction of the columns; the particles are then sent to their
// owners. Templates are added in each call, since a resumed run may generate other stones than
// before. Collective. The height is checked before anything is added: a bed that does not fit adds
// no stones.
double pour(dem::Particles& particles, const par::Comm& comm, const Mix& mix, int material,
            const std::vector<Batch>& batches, const std::string& section) {
  // Numbered through all batches, so that small boxes are distributed over the ranks like one large
  // bed.
  std::int64_t columns = 0;
  for (const Batch& batch : batches) columns += batch.columns.count();
  const auto [begin, count] =
      io::row_range(static_cast<std::size_t>(columns), comm.rank(), comm.size());
  double top = 0;
  std::vector<dem::NewParticle> mine = build(batches, begin, count, top);
  top = comm.max(top);
  if (top > particles.domain().high.z())
    throw RunError(
        fmt::format("the loose stones would reach a height of {:.3g} m, above the top of the "
                    "domain at {:.3g} m (1 m plus ten times the height of all layers); make the "
                    "bed wider, or the stones rounder (a larger I/L: {}.elongation for pebbles, "
                    "{}.polyhedron.elongation for other generated stones)",
                    top, particles.domain().high.z(), section, section));
  std::vector<int> numbers;
  for (const dem::Template& shape : mix.templates())
    numbers.push_back(particles.add_template(shape));
  for (dem::NewParticle& stone : mine) {
    stone.shape = numbers[static_cast<std::size_t>(stone.shape)];
    stone.material = material;
  }
  particles.add(mine);
  return top;
}

// Maximum over all ranks: ids are unique among existing stones. Collective.
Id first_free_id(const dem::Particles& particles, const par::Comm& comm) {
  Id highest = -1;
  for (std::size_t i = 0; i < particles.size(); ++i) highest = std::max(highest, particles[i].id);
  return comm.max(highest) + 1;
}

// Parameters of a bed that fills `box`. The seed plus the first id makes its stones differ from
// those of the bed: cribs filled one after the other get different stones, and the same ones in a
// repeated run.
BedParameters bed_of(const BedParameters& parameters, const Box& box, Id first) {
  BedParameters bed = parameters;
  bed.container = ContainerKind::box;
  bed.x = {box.low.x(), box.high.x()};
  bed.y = {box.low.y(), box.high.y()};
  bed.height = box.high.z() - box.low.z();
  bed.seed += first;
  return bed;
}

}  // namespace

double fill(dem::Particles& particles, const par::Comm& comm, const BedParameters& parameters,
            int material, double foot) {
  const Mix mix(parameters, particles.domain().dimension, library_of(comm, parameters));
  return pour(particles, comm, mix, material,
              {{.columns = Columns(parameters, particles.domain(), mix),
                .first = first_free_id(particles, comm),
                .foot = foot}},
              parameters.section);
}

// The size factor from height ~ factor^3 (in a plane ^2), by a few iterations, since the number of
// columns changes with it too.
double fill_to_grow(dem::Particles& particles, const par::Comm& comm,
                    const BedParameters& parameters, int material, double foot,
                    double height_ratio) {
  const dem::Domain& domain = particles.domain();
  const Mix mix(parameters, domain.dimension, library_of(comm, parameters));
  const double power = domain.dimension == Dimension::plane ? 2 : 3;
  constexpr int iterations = 4;
  double size_factor = 1;
  for (int k = 0; k < iterations; ++k) {
    const double top = height_of(comm, Columns(parameters, domain, mix, size_factor));
    size_factor =
        std::min(1.0, size_factor * std::pow(height_ratio * parameters.height / top, 1 / power));
  }
  const Id first = first_free_id(particles, comm);
  particles.grow_from(first, size_factor);
  return pour(
      particles, comm, mix, material,
      {{.columns = Columns(parameters, domain, mix, size_factor), .first = first, .foot = foot}},
      parameters.section);
}

// All ranks go through all boxes, so that ids agree; only the stones are distributed.
double fill_boxes(dem::Particles& particles, const par::Comm& comm, const BedParameters& parameters,
                  int material, std::span<const Box> boxes, double foot) {
  const dem::Domain& domain = particles.domain();
  const Mix mix(parameters, domain.dimension, library_of(comm, parameters));
  const double least = narrowest * mix.largest_bound();
  Id first = first_free_id(particles, comm);
  std::vector<Batch> batches;
  for (const Box& box : boxes) {
    const Vec3 size = box.high - box.low;
    if (size.x() < least || (domain.dimension == Dimension::space && size.y() < least)) continue;
    const Columns columns(bed_of(parameters, box, first), domain, mix);
    batches.push_back({columns, first, foot});
    first += columns.stones();
  }
  return pour(particles, comm, mix, material, batches, parameters.section);
}

}  // namespace trackbed::bed
