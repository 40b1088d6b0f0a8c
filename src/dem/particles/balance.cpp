// Sizes of cells and their assignment to ranks: an even partition of the counted work.
//
// Work is counted, not timed, so that a run is always partitioned in the same way and an error that
// depends on the partition can be reproduced.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <unordered_map>

#include "dem/particles/impl.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::dem {

namespace {

// ns per sub-step, fitted to CPU time: each loop alone on beds (900 to 2000 spheres, 600 to 1000
// clumps of 3 spheres, 150 stones of 16 corners at rest, 150 compounds of 2 pieces; floors of 32 to
// 28,800 triangles; skins of 0.05 to 0.4 radii), median of 41 repeats, GCC 12, -O3, 512-bit
// registers, one core; that of ghosts from the halo of 100 to 220 of them between two ranks. They
// reproduce the sum of these loops within 12 %; a whole sub-step of a layer of balls on a floor
// took up to a third less. Only their ratios matter.
constexpr double sphere_cost = 13, body_cost = 145;  // forces cleared, moved; attitude updated
constexpr double ghost_cost = 11;
constexpr double piece_cost = 3;  // placed, if not all are spheres
constexpr double entry_cost = 1.8, contact_cost = 17;
constexpr double bond_cost = 90;  // of 4752 bonds of a block of 1728 balls
constexpr double stone_entry_cost = 3, feature_cost = 7.5, stone_contact_cost = 53;
// On surfaces. Finding the features near a stone costs up to 1000 ns for each triangle (a bed that
// jumps, rebuilds included), but only when its margin is used up: 5 corresponds to once in 200
// sub-steps, which is an assumption.
constexpr double triangle_cost = 23, patch_cost = 55;
constexpr double stone_triangle_cost = 5, stone_feature_cost = 25, stone_patch_cost = 200;

// Entries and features per contact in such beds, where there are no lists yet.
constexpr double entries_per_contact = 2, stone_entries_per_contact = 4, features_per_contact = 5;

constexpr double least_gain = 1.05;  // of the slowest rank; below it a new partition does not pay

// Sizes are counted in steps of a quarter octave.
constexpr int bins = 256, bins_per_octave = 4;
int bin_of(double bound) {
  return std::clamp(static_cast<int>(std::floor(bins_per_octave * std::log2(bound))) + bins / 2, 0,
                    bins - 1);
}

}  // namespace

// The skin if the deck gives none, m. A wider one makes longer lists in each sub-step, a narrower
// one more rebuilds. It is a fraction of the smallest radius, whose list a wide skin would fill
// first. Without particles any value is valid. Collective.
double Particles::Impl::default_skin() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < state.own; ++b) smallest = std::min(smallest, radius(b));
  smallest = comm.min(smallest);
  // Balls have their near pairs apart from the list, which may therefore be long and rarely
  // rebuilt.
  const double fraction = shapes.any_stones() ? 0.15 : 0.3;
  return std::isfinite(smallest) ? fraction * smallest : 1e-3;
}

// Largest radius of each level: up to twice the median, then each twice the previous one; empty
// levels are left out. The median is found in a histogram of whole numbers: a bin of a quarter
// octave is accurate enough, and the levels are the same on any number of ranks. Collective.
std::vector<double> Particles::Impl::level_bounds() const {
  std::vector<std::int64_t> count(bins, 0);
  for (std::size_t b = 0; b < state.own; ++b) ++count[static_cast<std::size_t>(bin_of(radius(b)))];
  comm.sum(count);
  std::int64_t all = 0, below = 0;
  for (const std::int64_t n : count) all += n;
  int median = 0;
  while (median + 1 < bins && 2 * (below += count[static_cast<std::size_t>(median)]) < all)
    ++median;
  const double first = 2 * std::exp2(static_cast<double>(median + 1 - bins / 2) / bins_per_octave);
  // Level n ends at 2^n times the first one's end.
  const auto level = [&](double bound) {
    return bound > first ? static_cast<std::size_t>(std::ceil(std::log2(bound / first))) : 0;
  };
  // A level's bound is the largest radius in it, not its upper limit: its cells become no larger
  // than necessary.
  std::vector<double> largest(bins, 0);
  for (std::size_t b = 0; b < state.own; ++b) {
    double& known = largest[std::min<std::size_t>(level(radius(b)), bins - 1)];
    known = std::max(known, radius(b));
  }
  comm.max(largest);
  std::erase(largest, 0.0);
  return largest.empty() ? std::vector<double>{0} : largest;
}

// Collective. The bound comes first, since quantum, levels and reach follow from it. Lists refer to
// the old owners from here on: the next `advance` makes new ones.
void Particles::Impl::choose_grid(const std::vector<double>& work) {
  std::vector<double> bounds = level_bounds();
  // Of broken stones: fixed, so that the quantum does not depend on when this is chosen.
  bounds.back() = std::max(bounds.back(), breaking.largest_radius);
  bound = bounds.back();
  choose_quantum();
  skin = parameters.skin > 0 ? parameters.skin : default_skin();
  if (breaking.parameters.of_clumps())
    skin = std::max(skin, growth_in_lists * breaking.least_radius);
  constexpr double margin = 1.1;  // stones move on before a bond that is too long breaks
  skin = std::max(skin, margin * bonding.longest);
  population = comm.sum(static_cast<std::int64_t>(state.own));
  grid = Grid(domain, bounds, skin, population);
  grid.partition(by_cell(work), comm.size());
  ready = false;
}

// Calls visit(particle, its partner or itself, ns) for all work of this rank in a sub-step
// according to the lists.
template <class Visit>
void Particles::Impl::visit_work(Visit&& visit) const {
  const auto body = [&](std::int32_t piece) {
    return static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(piece)]);
  };
  const auto visit_list = [&](const PairList& list, auto&& cost) {
    for (const Row& row : list.rows)
      for (std::uint32_t e = row.begin; e < row.end; ++e)
        visit(body(row.piece), body(list.entries[e].piece), cost(e));
  };
  // Each entry costs its test whether in contact or not; a contact costs the law in addition.
  visit_list(pairs, [](std::uint32_t) { return entry_cost; });
  visit_touching([&](std::int32_t piece, std::uint32_t e, auto...) {
    visit(body(piece), body(pairs.entries[e].piece), contact_cost);
  });
  visit_list(stones, [&](std::uint32_t e) {
    return stone_entry_cost + feature_cost * static_cast<double>(stone_contacts.features(e)) +
           (stones.entries[e].touching ? stone_contact_cost : 0);
  });
  for (const Bonding::Place& place : bonding.places) visit(place.i, place.j, bond_cost);
  for (const Approach& a : approaches) {
    const auto triangles = static_cast<double>(a.triangles.size());
    const auto patches = static_cast<double>(a.patches.size());
    const auto features = static_cast<double>(a.near.features.size());
    visit(body(a.piece), body(a.piece),
          has_corners(a.piece) ? stone_triangle_cost * triangles + stone_feature_cost * features +
                                     stone_patch_cost * patches
                               : triangle_cost * triangles + patch_cost * patches);
  }
}

// ns per sub-step of a particle without its contacts.
double Particles::Impl::upkeep(std::size_t b) const {
  const bool spheres = shapes.only_spheres();
  if (b >= state.own) return ghost_upkeep(b);
  if (spheres) return sphere_cost;
  const std::size_t pieces_of_it = shapes.end(state.shape[b]) - shapes.begin(state.shape[b]);
  return body_cost + piece_cost * static_cast<double>(pieces_of_it);
}

// A ghost is sent, received and placed, but not advanced in time.
double Particles::Impl::ghost_upkeep(std::size_t b) const {
  if (shapes.only_spheres()) return ghost_cost;
  const std::size_t pieces_of_it = shapes.end(state.shape[b]) - shapes.begin(state.shape[b]);
  return ghost_cost + piece_cost * static_cast<double>(pieces_of_it);
}

// The work of each own particle according to the rank's lists, ns per sub-step. Local. Half of each
// contact belongs to either particle. Contacts that wait for the next lists are known by their
// history only.
std::vector<double> Particles::Impl::work() const {
  std::vector<double> work(state.own);
  for (std::size_t b = 0; b < state.own; ++b) work[b] = upkeep(b);
  visit_work([&](std::size_t i, std::size_t j, double ns) {
    // The half of a ghost is counted by its owner, who has the same contact in its own list.
    for (const std::size_t b : {i, j})
      if (b < state.own) work[b] += 0.5 * ns;
  });
  std::unordered_map<Id, std::size_t> known;
  if (!waiting.empty())
    for (std::size_t b = 0; b < state.own; ++b) known[state.id[b]] = b;
  // A mean contact, with the corresponding entries.
  const double contact = shapes.any_stones()
                             ? stone_contact_cost + features_per_contact * feature_cost +
                                   stone_entries_per_contact * stone_entry_cost
                             : contact_cost + entries_per_contact * entry_cost;
  for (const History& h : waiting)
    for (const std::int64_t key : {h.first, h.second})
      if (const auto found = known.find(key >= 0 ? particle_of(key) : -1); found != known.end())
        work[found->second] += 0.5 * contact;
  if (bonding.places.empty())
    for (const Bond& bond : bonding.bonds)
      for (const Id id : {bond.first, bond.second})
        if (const auto b = own_number(id)) work[*b] += 0.5 * bond_cost;
  return work;
}

// The work in each cell of level 0, by which cells are partitioned. Collective. Rounded up to whole
// numbers, so that ranks may add them in any order and no particle counts as zero.
std::vector<double> Particles::Impl::by_cell(const std::vector<double>& work) const {
  std::vector<double> cells(grid.cells(), 0);
  for (std::size_t b = 0; b < state.own; ++b)
    if (state.x[b].vec3().allFinite())
      cells[grid.cell_of(state.x[b].vec3())] += std::max(1.0, std::ceil(work[b]));
  comm.sum(std::span<double>(cells));
  return cells;
}

// Not the sum of `work`: a contact across ranks is computed on both, and ghosts cost as well; both
// contribute to the time of a rank.
double Particles::Impl::load() const {
  double ns = 0;
  for (std::size_t b = 0; b < state.size(); ++b) ns += upkeep(b);
  visit_work([&](std::size_t, std::size_t, double cost) { ns += cost; });
  return ns;
}

double Particles::imbalance() const {
  const Impl& r = *impl_;
  const double mine = r.load(), mean = r.comm.sum(mine) / r.comm.size();
  return mean > 0 ? r.comm.max(mine) / mean : 1;
}

namespace {

// Largest and mean of a number of each part.
void most_and_mean(const std::vector<double>& of_parts, double& most, double& mean) {
  most = *std::max_element(of_parts.begin(), of_parts.end());
  mean =
      std::accumulate(of_parts.begin(), of_parts.end(), 0.0) / static_cast<double>(of_parts.size());
}

}  // namespace

// Parts besides its own that have cells within reach of the particle: they get it as a ghost. Those
// of small particles beside large ones (add_small_beside_large) are left out.
std::vector<int> Particles::Impl::other_parts(std::size_t b, const Grid& partitioned) const {
  std::vector<int> found;
  const Vec3 at = state.x[b].vec3();
  if (!at.allFinite()) return found;
  const double reach = state.x[b].w +
                       partitioned.levels()[partitioned.level_of(state.x[b].w)].bound +
                       partitioned.skin();
  const int own = partitioned.owner_at(at);
  partitioned.levels()[0].lattice.around(
      partitioned.wrapped(at, partitioned.locate(at).wrap), reach,
      [&](const Cell& cell, const Cell&) {
        const int part = partitioned.owner(cell);
        if (part != own && std::find(found.begin(), found.end(), part) == found.end())
          found.push_back(part);
      });
  return found;
}

// A contact between two parts is computed in both, as between ranks.
Decomposition Particles::decomposition(int parts) const {
  const Impl& r = *impl_;
  require(r.comm.size() == 1 && r.ready, "a decomposition needs one rank with lists");
  Grid partitioned = r.grid;
  partitioned.partition(r.by_cell(r.work()), parts);
  const auto count = static_cast<std::size_t>(parts);
  std::vector<double> work(count, 0), own(count, 0), ghosts(count, 0), neighbours(count, 0);
  std::vector<std::size_t> part_of(r.state.own);
  std::set<std::pair<int, std::size_t>> meets;
  for (std::size_t b = 0; b < r.state.own; ++b) {
    const std::size_t mine = part_of[b] =
        static_cast<std::size_t>(partitioned.owner_at(r.state.x[b].vec3()));
    work[mine] += r.upkeep(b), ++own[mine];
    for (const int other : r.other_parts(b, partitioned)) {
      const auto there = static_cast<std::size_t>(other);
      work[there] += r.ghost_upkeep(b), ++ghosts[there];
      meets.insert({other, mine});
    }
  }
  for (const auto& [to, from] : meets) ++neighbours[static_cast<std::size_t>(to)];
  r.visit_work([&](std::size_t i, std::size_t j, double ns) {
    if (i >= r.state.own || j >= r.state.own) return;  // images beyond a periodic side
    work[part_of[i]] += ns;
    if (part_of[j] != part_of[i]) work[part_of[j]] += ns;
  });
  std::vector<double> bytes = ghosts;
  for (double& one : bytes) one *= static_cast<double>(r.bytes_of_ghost());
  Decomposition found;
  most_and_mean(work, found.work_most, found.work_mean);
  most_and_mean(own, found.particles_most, found.particles_mean);
  most_and_mean(ghosts, found.ghosts_most, found.ghosts_mean);
  most_and_mean(neighbours, found.neighbours_most, found.neighbours_mean);
  most_and_mean(bytes, found.bytes_most, found.bytes_mean);
  return found;
}

// A partition that is uneven because it cannot be better is left unchanged. Collective: every rank
// has the same numbers and decides identically. Nothing is done before the lists exist, from which
// the work is counted.
bool Particles::rebalance() {
  Impl& r = *impl_;
  if (r.comm.size() == 1 || r.parameters.rebalance == 0 || !r.ready) return false;
  const double now = imbalance();
  if (now <= r.parameters.rebalance) return false;
  const std::vector<double> work = r.by_cell(r.work());
  // The present and the new partition are measured in the same way, by `par::worst_part`, which
  // counts ghosts only from cuts between cells. `now` is measured by the lists; the two must not be
  // compared.
  Grid trial = r.grid;
  const double worst = r.grid.worst(work, r.comm.size());
  if (trial.partition(work, r.comm.size()) * least_gain > worst) return false;
  r.balance.before = now, ++r.balance.rebalances;
  // It counts the work once more and obtains the same partition: `by_cell` is exact.
  repartition();
  return true;
}

Balance Particles::balance() const { return impl_->balance; }

}  // namespace trackbed::dem
