// Sizes of cells, and which rank gets which: an even split of the work that was counted.
//
// Work is counted, not timed, so that a run always splits the same way and a fault that depends on
// the split can be found again.
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "room.hpp"

namespace trackbed::dem {

namespace {

// ns per sub-step, fitted to CPU time: each loop alone on beds (900 to 2000 spheres, 600 to 1000
// clumps of 3 spheres, 150 stones of 16 corners at rest, 150 compounds of 2 pieces; floors of 32 to
// 28,800 triangles; skins of 0.05 to 0.4 radii), median of 41 repeats, GCC 12, -O3, 512-bit
// registers, one core; that of ghosts from the halo of 100 to 220 of them between two ranks. They
// give the sum of these loops within 12 %; a whole sub-step of a layer of balls on a floor took up
// to a third less than they say. Only their ratios matter.
constexpr double sphere_cost = 13, body_cost = 145;  // forces cleared, moved; attitude followed
constexpr double ghost_cost = 11;
constexpr double piece_cost = 3;  // placed, if not all are spheres
constexpr double entry_cost = 1.8, contact_cost = 17;
constexpr double stone_entry_cost = 3, feature_cost = 7.5, stone_contact_cost = 53;
// On surfaces. Finding the features near a stone costs up to 1000 ns for each triangle (a bed that
// jumps, rebuilds included), but only when its margin is used up: 5 stands for once in 200
// sub-steps, which is a guess.
constexpr double triangle_cost = 23, patch_cost = 55;
constexpr double stone_triangle_cost = 5, stone_feature_cost = 25, stone_patch_cost = 200;

// What a contact brings along in such beds, where the lists do not tell.
constexpr double entries_per_contact = 2, stone_entries_per_contact = 4, features_per_contact = 5;

constexpr double least_gain = 1.05;  // of the slowest rank, below which a new split is not worth it

// Sizes are counted in steps of a quarter octave.
constexpr int bins = 256, bins_per_octave = 4;
int bin_of(double bound) {
  return std::clamp(static_cast<int>(std::floor(bins_per_octave * std::log2(bound))) + bins / 2, 0,
                    bins - 1);
}

}  // namespace

// The skin where the deck gives none, m. A wider one makes longer lists in each sub-step, a
// narrower one more rebuilds. It is a share of the smallest radius, whose list a wide skin would
// fill first. Without particles any will do. Collective.
double Particles::Room::default_skin() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < state.own; ++b) smallest = std::min(smallest, radius(b));
  smallest = comm.min(smallest);
  // Balls have their near pairs apart from the list, which may therefore be long and seldom made.
  const double share = shapes.any_stones() ? 0.15 : 0.3;
  return std::isfinite(smallest) ? share * smallest : 1e-3;
}

// Largest radius of each level: up to twice the median, then twice as large ones each; levels that
// nobody is in are left out.
// The median is found in a histogram of whole numbers: a bin of a quarter octave is near enough,
// and the same levels come out on any number of ranks. Collective.
std::vector<double> Particles::Room::level_bounds() const {
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
  // A level's bound is what is in it, not where it ends: its cells become no larger than they must.
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
void Particles::Room::choose_grid(const std::vector<double>& work) {
  const std::vector<double> bounds = level_bounds();
  bound = bounds.back();
  choose_quantum();
  skin = parameters.skin > 0 ? parameters.skin : default_skin();
  population = comm.sum(static_cast<std::int64_t>(state.own));
  grid = Grid(domain, bounds, skin, population);
  grid.share_out(by_cell(work), comm.size());
  ready = false;
}

// See(particle, its partner or itself, ns) for all that the lists make this rank do in a sub-step.
template <class See>
void Particles::Room::visit_work(See&& see) const {
  const auto body = [&](std::int32_t piece) {
    return static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(piece)]);
  };
  const auto visit = [&](const PairList& list, auto&& cost) {
    for (const Row& row : list.rows)
      for (std::uint32_t e = row.begin; e < row.end; ++e)
        see(body(row.piece), body(list.entries[e].piece), cost(e));
  };
  // An entry costs its look whether it touches or not; a contact pays for the law on top.
  visit(pairs, [&](std::uint32_t e) {
    return pairs.entries[e].touching ? entry_cost + contact_cost : entry_cost;
  });
  visit(stones, [&](std::uint32_t e) {
    return stone_entry_cost + feature_cost * static_cast<double>(stone_contacts.features(e)) +
           (stones.entries[e].touching ? stone_contact_cost : 0);
  });
  for (const Approach& a : approaches) {
    const auto triangles = static_cast<double>(a.triangles.size());
    const auto patches = static_cast<double>(a.patches.size());
    const auto features = static_cast<double>(a.near.features.size());
    see(body(a.piece), body(a.piece),
        has_corners(a.piece) ? stone_triangle_cost * triangles + stone_feature_cost * features +
                                   stone_patch_cost * patches
                             : triangle_cost * triangles + patch_cost * patches);
  }
}

// ns per sub-step of a particle by itself.
double Particles::Room::upkeep(std::size_t b) const {
  const bool spheres = shapes.only_spheres();
  // A ghost is sent, received and placed, but neither kicked nor moved.
  double cost = b >= state.own ? ghost_cost : spheres ? sphere_cost : body_cost;
  if (spheres) return cost;
  const std::size_t pieces_of_it = shapes.end(state.shape[b]) - shapes.begin(state.shape[b]);
  return cost + piece_cost * static_cast<double>(pieces_of_it);
}

// The work of each own particle as the rank's lists tell it, ns per sub-step. Local.
// Half of each contact belongs to either particle. Contacts that wait for the next lists are known
// by their history alone.
std::vector<double> Particles::Room::work() const {
  std::vector<double> work(state.own);
  for (std::size_t b = 0; b < state.own; ++b) work[b] = upkeep(b);
  visit_work([&](std::size_t i, std::size_t j, double ns) {
    // The half of a ghost is left to its owner, who has the same contact in its own list.
    for (const std::size_t b : {i, j})
      if (b < state.own) work[b] += 0.5 * ns;
  });
  std::unordered_map<Id, std::size_t> known;
  if (!waiting.empty())
    for (std::size_t b = 0; b < state.own; ++b) known[state.id[b]] = b;
  // A mean contact, with the entries that come along with it.
  const double contact = shapes.any_stones()
                             ? stone_contact_cost + features_per_contact * feature_cost +
                                   stone_entries_per_contact * stone_entry_cost
                             : contact_cost + entries_per_contact * entry_cost;
  for (const History& h : waiting)
    for (const std::int64_t key : {h.first, h.second})
      if (const auto found = known.find(key >= 0 ? particle_of(key) : -1); found != known.end())
        work[found->second] += 0.5 * contact;
  return work;
}

// The work in each cell of level 0, which is what is shared out. Collective.
// Rounded up to whole numbers, so that ranks may add them in any order and no particle is nothing.
std::vector<double> Particles::Room::by_cell(const std::vector<double>& work) const {
  std::vector<double> cells(grid.cells(), 0);
  for (std::size_t b = 0; b < state.own; ++b)
    if (state.x[b].vec3().allFinite())
      cells[grid.cell_of(state.x[b].vec3())] += std::max(1.0, std::ceil(work[b]));
  comm.sum(std::span<double>(cells));
  return cells;
}

// Not the sum of `work`: a contact across ranks is computed on both, ghosts cost as well, and that
// is what makes a rank late.
double Particles::Room::load() const {
  double ns = 0;
  for (std::size_t b = 0; b < state.size(); ++b) ns += upkeep(b);
  visit_work([&](std::size_t, std::size_t, double cost) { ns += cost; });
  return ns;
}

double Particles::imbalance() const {
  const Room& r = *room_;
  const double mine = r.load(), mean = r.comm.sum(mine) / r.comm.size();
  return mean > 0 ? r.comm.max(mine) / mean : 1;
}

// A split that is uneven because it cannot be better is left alone.
// Collective: every rank sees the same numbers and decides alike. Nothing is asked before the lists
// exist, since they tell the work.
bool Particles::rebalance() {
  Room& r = *room_;
  if (r.comm.size() == 1 || r.parameters.rebalance == 0 || !r.ready) return false;
  const double now = imbalance();
  if (now <= r.parameters.rebalance) return false;
  const std::vector<double> work = r.by_cell(r.work());
  // The present split and the new one are measured alike, by `par::worst_part`, which knows ghosts
  // only from cuts between cells. `now` is what the lists say; the two must not be compared.
  Grid trial = r.grid;
  const double worst = r.grid.worst(work, r.comm.size());
  if (trial.share_out(work, r.comm.size()) * least_gain > worst) return false;
  r.balance.before = now, ++r.balance.rebalances;
  // It counts the work once more and comes to the same split: `by_cell` is exact.
  repartition();
  return true;
}

Balance Particles::balance() const { return room_->balance; }

}  // namespace trackbed::dem
