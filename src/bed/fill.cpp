// Stones for the particles, each rank its share.
// Columns need no neighbours to be built, so a rank's cost is that of its own stones and one
// exchange to their owners; docs/decisions/packing.md has the lattice of cells they replaced.
//
// The order of ids, and so every contact's order of summation, follows from the numbers of stones
// and columns alone: a bed has the same bits on any number of ranks.
#include <fmt/format.h>

#include <algorithm>

#include "columns.hpp"
#include "trackbed/bed/bed.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::bed {

namespace {

// A box narrower than this many largest bounds gets no stones: Columns want a little more than 2.
constexpr double narrowest = 2.1;

// Columns that start at a height and whose stones' ids begin with `first`.
struct Batch {
  Columns columns;
  Id first = 0;
  double foot = 0;  // m
};

// Stones of columns [begin, begin + count) of all batches; raises `top` to what they reach.
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

// Every rank builds an even share of the columns; the particles then go to their owners. Templates
// are added anew each time: a run that goes on from a checkpoint may make other stones than before.
// Collective. The height is checked before anything is added: a bed that does not fit leaves no
// stones behind.
double pour(dem::Particles& particles, const par::Comm& comm, const Mix& mix, int material,
            const std::vector<Batch>& batches) {
  // Numbered through all batches: small boxes share the ranks as one large bed does.
  std::int64_t columns = 0;
  for (const Batch& batch : batches) columns += batch.columns.count();
  const auto [begin, count] =
      io::share(static_cast<std::size_t>(columns), comm.rank(), comm.size());
  double top = 0;
  std::vector<dem::NewParticle> mine = build(batches, begin, count, top);
  top = comm.max(top);
  if (top > particles.domain().high.z())
    throw RunError(
        fmt::format("the loose stones reach up to {:.3g} m, beyond the top of the domain ({:.3g} "
                    "m): they are poured higher than ten heights of the bed",
                    top, particles.domain().high.z()));
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

// Own stones of each rank, then the largest of all: ids are never used twice while their stones
// live. Collective.
Id first_free_id(const dem::Particles& particles, const par::Comm& comm) {
  Id highest = -1;
  for (std::size_t i = 0; i < particles.size(); ++i) highest = std::max(highest, particles[i].id);
  return comm.max(highest) + 1;
}

// Parameters of a bed that is `box`. The first id makes its stones others than those of the bed.
// Seed plus first id: cribs filled one after the other get different stones, and the same again in
// a repeated run.
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
                .foot = foot}});
}

namespace {

// m, that loose columns of stones of this share of their size reach. Collective.
double reach_of(const par::Comm& comm, const Columns& columns) {
  const auto [begin, count] =
      io::share(static_cast<std::size_t>(columns.count()), comm.rank(), comm.size());
  double top = 0;
  build({{.columns = columns}}, begin, count, top);
  return comm.max(top);
}

}  // namespace

// The share by its own law, height ~ share^3 (in a plane ^2), a few times over, as the number of
// columns changes with it too.
double fill_to_grow(dem::Particles& particles, const par::Comm& comm,
                    const BedParameters& parameters, int material, double foot, double room) {
  const dem::Domain& domain = particles.domain();
  const Mix mix(parameters, domain.dimension, library_of(comm, parameters));
  const double power = domain.dimension == Dimension::plane ? 2 : 3;
  constexpr int rounds = 4;
  double share = 1;
  for (int round = 0; round < rounds; ++round) {
    const double top = reach_of(comm, Columns(parameters, domain, mix, share));
    share = std::min(1.0, share * std::pow(room * parameters.height / top, 1 / power));
  }
  const Id first = first_free_id(particles, comm);
  particles.grow_from(first, share);
  return pour(particles, comm, mix, material,
              {{.columns = Columns(parameters, domain, mix, share), .first = first, .foot = foot}});
}

// All ranks go through all boxes, so that ids agree; only the stones are shared out.
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
  return pour(particles, comm, mix, material, batches);
}

}  // namespace trackbed::bed
