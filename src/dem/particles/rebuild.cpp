// New owners, ghosts and neighbour lists. All of these follow from the state and the contact
// history, and nothing that affects the forces is changed: results are bitwise identical whenever
// and however often it happens.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <unordered_map>

#include "dem/particles/impl.hpp"
#include "dem/search/cells.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/dem/stiffness.hpp"

namespace trackbed::dem {

// Rows not listed in `rows` are dropped; derived quantities are computed again afterwards.
void pick(State& state, const std::vector<std::size_t>& rows) {
  visit_state(state, [&](auto, auto& array) {
    auto picked = array;
    picked.resize(rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) picked[k] = array[rows[k]];
    array = std::move(picked);
  });
}

namespace {

// Bytes of the stored quantities of one particle for which `wanted` is true, as they are in memory:
// all ranks of a run use the same number format.
template <class Wanted>
void pack(const State& state, std::size_t b, Wanted wanted, std::vector<std::byte>& out) {
  visit_state(state, [&](auto quantity, const auto& array) {
    if (!wanted(quantity)) return;
    const auto* bytes = reinterpret_cast<const std::byte*>(&array[b]);
    out.insert(out.end(), bytes, bytes + sizeof(array[b]));
  });
}

// Adds a particle from them; other quantities are zero.
template <class Wanted>
const std::byte* unpack(State& state, Wanted wanted, const std::byte* in) {
  visit_state(state, [&](auto quantity, auto& array) {
    array.emplace_back();
    if (!wanted(quantity)) return;
    std::memcpy(&array.back(), in, sizeof(array[0]));
    in += sizeof(array[0]);
  });
  return in;
}

constexpr auto all_stored = [](auto) { return true; };
constexpr auto once = [](auto quantity) { return quantity.ghost == Ghost::once; };

}  // namespace

// One formula on owners and on ghosts, so that mass and radius need not be sent and are bitwise
// identical.
void Particles::Impl::derive(std::size_t begin) {
  state.w.resize(state.size());
  state.inertia.resize(state.size());
  for (std::size_t b = begin; b < state.size(); ++b) derive_one(b);
}

void Particles::Impl::derive_one(std::size_t b) {
  const double density = physics.materials[static_cast<std::size_t>(state.material[b])].density;
  state.v[b].w = mass_of(shapes[state.shape[b]], state.scale[b], density, domain);
  derive_size(b);
  update_spin(b);
}

void Particles::Impl::derive_size(std::size_t b) {
  const double scale = state.scale_now(b);
  state.x[b].w = shapes.bound(state.shape[b]) * scale;
  state.inertia[b].set(mass(b) * scale * scale * shapes[state.shape[b]].gyration);
  state.l[b].w = 1 / state.inertia[b].y;
}

// By id: rows of the lists, histories and binary searches rely on it.
void Particles::Impl::sort_own() {
  const auto own_end = state.id.begin() + static_cast<std::ptrdiff_t>(state.own);
  if (std::is_sorted(state.id.begin(), own_end)) return;
  std::vector<std::size_t> order(state.own);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return state.id[a] < state.id[b]; });
  pick(state, order);
}

std::string Particles::Impl::not_a_number(std::size_t b) const {
  if (state.x[b].vec3().allFinite() && quat(state.q[b]).coeffs().allFinite()) return {};
  return fmt::format(
      "the position or attitude of particle {} is not a number; use a smaller "
      "time.step or dem.safety",
      state.id[b]);
}

// Sends particles that left the rank's cells, each with the history of all its contacts.
// Collective. A lost particle is reported and kept until the ranks stop together at the end of the
// window; without a valid position it stays on its rank.
void Particles::Impl::migrate(std::vector<History>& history) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  std::vector<std::vector<std::byte>> leaving(ranks);
  std::vector<std::vector<History>> leaving_history(ranks);
  std::unordered_map<Id, std::size_t> goes_to;
  std::vector<std::size_t> staying;
  for (std::size_t b = 0; b < state.own; ++b) {
    const Vec3 at = state.x[b].vec3();
    if (const std::string words = not_a_number(b); !words.empty())
      report(words);
    else if (grid.outside(at))
      report(
          fmt::format("particle {} left the domain at ({:.6g}, {:.6g}, {:.6g}) m; the domain "
                      "reaches from ({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}) m; use a smaller "
                      "time.step or dem.safety, or lower speeds, or in a deck of placed stones a "
                      "larger domain (domain.low, domain.high)",
                      state.id[b], at.x(), at.y(), at.z(), domain.low.x(), domain.low.y(),
                      domain.low.z(), domain.high.x(), domain.high.y(), domain.high.z()));
    const int owner = at.allFinite() ? grid.owner_at(at) : comm.rank();
    if (owner == comm.rank()) {
      staying.push_back(b);
      continue;
    }
    pack(state, b, all_stored, leaving[static_cast<std::size_t>(owner)]);
    goes_to[state.id[b]] = static_cast<std::size_t>(owner);
  }
  // A copy: the partner may stay here and its rank still needs the record.
  if (!goes_to.empty())
    for (const History& h : history)
      for (const std::int64_t key : {h.first, h.second}) {
        const auto to = key >= 0 ? goes_to.find(particle_of(key)) : goes_to.end();
        if (to != goes_to.end()) leaving_history[to->second].push_back(h);
      }
  migrate_bonds(goes_to);
  // Those that stay, then the received ones; `sort_own` restores the order.
  if (staying.size() < state.own) pick(state, staying);
  for (const auto& bytes : comm.exchange(leaving))
    for (const std::byte* in = bytes.data(), *end = in + bytes.size(); in < end;)
      in = unpack(state, all_stored, in);
  state.own = state.size();
  for (const auto& list : comm.exchange(leaving_history))
    history.insert(history.end(), list.begin(), list.end());
  if (!std::is_sorted(history.begin(), history.end())) std::sort(history.begin(), history.end());
  const auto same = [](const History& a, const History& b) { return !(a < b) && !(b < a); };
  history.erase(std::unique(history.begin(), history.end(), same), history.end());
}

namespace {

// Own particles that each rank needs, ascending.
using GhostLists = std::vector<std::vector<std::int32_t>>;

// Every pair belongs to the level of the larger particle: ranks that may have a partner up to that
// size get the particle.
GhostLists needed_around(const State& state, const Grid& grid, const par::Comm& comm) {
  GhostLists lists(static_cast<std::size_t>(comm.size()));
  for (std::size_t b = 0; b < state.own; ++b) {
    const Vec3 at = state.x[b].vec3();
    if (!at.allFinite()) continue;
    const double reach =
        state.x[b].w + grid.levels()[grid.level_of(state.x[b].w)].bound + grid.skin();
    const Vec3 home = grid.wrapped(at, grid.locate(at).wrap);
    grid.levels()[0].lattice.around(home, reach, [&](const Cell& cell, const Cell&) {
      auto& list = lists[static_cast<std::size_t>(grid.owner(cell))];
      if (grid.owner(cell) == comm.rank()) return;
      if (list.empty() || list.back() != static_cast<std::int32_t>(b))
        list.push_back(static_cast<std::int32_t>(b));
    });
  }
  return lists;
}

// The other side of pairs of different levels: the owner of the larger one needs the smaller. The
// owner of the smaller has the larger by the list above.
void add_small_beside_large(const State& state, const Grid& grid, const par::Comm& comm,
                            GhostLists& lists) {
  std::vector<std::vector<Vec4>> large(lists.size());
  for (std::size_t r = 0; r < lists.size(); ++r)
    for (const std::int32_t b : lists[r]) {
      const Vec4& x = state.x[static_cast<std::size_t>(b)];
      if (grid.level_of(x.w) > 0) large[r].push_back(x);
    }
  large = comm.exchange(large);
  const Cells cells(state, grid, state.own);
  for (std::size_t r = 0; r < lists.size(); ++r) {
    for (const Vec4& x : large[r]) {
      const Vec3 home = grid.wrapped(x.vec3(), grid.locate(x.vec3()).wrap);
      const Vec4 ball{home.x(), home.y(), home.z(), x.w};
      for (std::size_t level = 0; level < grid.level_of(x.w); ++level)
        cells.near(level, ball, [&](const Cells::Member& small, const Cell&) {
          lists[r].push_back(small.particle);
        });
    }
    std::sort(lists[r].begin(), lists[r].end());
    lists[r].erase(std::unique(lists[r].begin(), lists[r].end()), lists[r].end());
  }
}

}  // namespace

// Collective. Quantities that do not change between rebuilds are sent once here, the others in each
// sub-step.
void Particles::Impl::find_ghosts() {
  GhostLists items = needed_around(state, grid, comm);
  if (grid.levels().size() > 1) add_small_beside_large(state, grid, comm, items);
  std::vector<std::vector<std::byte>> outgoing(items.size());
  for (std::size_t r = 0; r < items.size(); ++r)
    for (const std::int32_t item : items[r])
      pack(state, static_cast<std::size_t>(item), once, outgoing[r]);
  halo.connect(comm, items);
  for (const auto& bytes : comm.exchange(outgoing))
    for (const std::byte* in = bytes.data(), *end = in + bytes.size(); in < end;)
      in = unpack(state, once, in);
  derive(0);
  update_ghosts();
}

namespace {

// Attitudes of spheres without bonds are not updated and not sent to their ghosts, which saves a
// third of the data.
template <bool turning>
constexpr bool in_each_step(Ghost ghost) {
  return ghost == Ghost::each_step || (turning && ghost == Ghost::turning);
}

// Numbers sent to a ghost in each sub-step.
template <bool turning>
consteval std::size_t numbers_in_each_step() {
  std::size_t numbers = 0;
  State none;
  visit_all(none, [&](auto quantity, auto&) {
    if (in_each_step<turning>(quantity.ghost)) numbers += quantity.columns;
  });
  return numbers;
}

// Data of a ghost needed by contacts; radius and mass follow from data sent once. No padding and no
// pointers: it is sent as it is.
template <bool turning>
struct Motion {
  double number[numbers_in_each_step<turning>()];
};

// copy(number in the message, number in the state, bytes) for each quantity of particle b.
template <bool turning, class S, class Copy>
[[gnu::always_inline]] inline void visit_motion(S& state, std::size_t b, Copy&& copy) {
  std::size_t first = 0;
  visit_all(state, [&](auto quantity, auto& array) {
    if constexpr (in_each_step<turning>(quantity.ghost)) {
      constexpr std::size_t bytes = quantity.columns * sizeof(double);
      static_assert(bytes <= sizeof(array[0]));
      copy(first, &array[b], std::integral_constant<std::size_t, bytes>{});
      first += quantity.columns;
    }
  });
}

// The exchange of a sub-step. Collective among neighbours.
template <bool turning>
void forward(par::Halo& halo, State& state) {
  thread_local std::vector<Motion<turning>> mine, ghosts;
  mine.resize(state.own);
  for (const std::int32_t item : halo.items()) {
    const auto b = static_cast<std::size_t>(item);
    visit_motion<turning>(state, b, [&](std::size_t first, const void* from, auto bytes) {
      std::memcpy(mine[b].number + first, from, bytes);
    });
  }
  ghosts.resize(halo.received());
  halo.forward(mine.data(), ghosts.data());
  for (std::size_t k = 0; k < ghosts.size(); ++k)
    visit_motion<turning>(state, state.own + k, [&](std::size_t first, void* to, auto bytes) {
      std::memcpy(to, ghosts[k].number + first, bytes);
    });
}

}  // namespace

void Particles::Impl::update_ghosts() {
  const auto timing = scope(Phase::halo);
  if (turns())
    forward<true>(halo, state);
  else
    forward<false>(halo, state);
}

std::size_t Particles::Impl::bytes_of_ghost() const {
  return turns() ? sizeof(Motion<true>) : sizeof(Motion<false>);
}

double Particles::Impl::stiffest_contact(double radius) const {
  return dem::stiffest_contact(declared, radius, parameters.largest_overlap);
}

// Range for the force of the largest overlap allowed on a node, with a factor of eight (ExactSum),
// or for the load passed to `expect_load`. No more than that: the quantum limits the accuracy of
// the balance of a window in which stones are in light contact only.
void Particles::Impl::choose_quantum() {
  const double overlap = parameters.largest_overlap * bound;
  if (bound > 0)
    load_quantum = std::max(load_quantum, exact_quantum(stiffest_contact(bound) * overlap));
  for (Surface* surface : surfaces) {
    if (surface->load_quantum == load_quantum) continue;
    surface->load_quantum = load_quantum;
    surface->clear_load();
  }
}

// Reference positions from which motion is measured to decide whether lists are outdated. For
// surfaces those at the end of the window: lists were made for all of it.
void Particles::Impl::store_reference() {
  reference_x.assign(state.x.begin(), state.x.begin() + static_cast<std::ptrdiff_t>(state.own));
  reference_q.assign(state.q.begin(), state.q.begin() + static_cast<std::ptrdiff_t>(state.own));
  reference_grown = state.grown;
  largest_motion = surface_motion = 0;
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    surface_reference[k].resize(surfaces[k]->nodes());
    for (std::size_t n = 0; n < surfaces[k]->nodes(); ++n)
      surface_reference[k][n] = node_at(*surfaces[k], static_cast<std::int32_t>(n), 1);
  }
}

// A particle moves by less than the skin until the next rebuild.
void Particles::Impl::find_at_border() {
  at_border.clear();
  for (const Approach& a : approaches) {
    const auto b = static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(a.piece)]);
    if (!at_border.empty() && at_border.back().body == b) continue;
    const Cell wrap = grid.locate(state.x[b].vec3()).wrap;
    for (const double offset : {-skin, skin}) {
      const Vec3 there = state.x[b].vec3() + Vec3::Constant(offset);
      if (grid.locate(there).wrap == wrap) continue;
      at_border.push_back({b, wrap});
      break;
    }
  }
}

bool Particles::Impl::crossed_a_border() const {
  return std::any_of(at_border.begin(), at_border.end(), [&](const AtBorder& p) {
    return grid.locate(state.x[p.body].vec3()).wrap != p.wrap;
  });
}

// Collective. The order matters: histories are read from the old lists before these are deleted;
// owners before ghosts, ghosts before pieces, pieces before lists.
void Particles::Impl::rebuild() {
  const auto timing = scope(Phase::search);
  std::vector<History> carried = history();
  if (!waiting.empty()) carried.insert(carried.end(), waiting.begin(), waiting.end());
  waiting.clear();
  visit_state(state, [&](auto, auto& array) { array.resize(state.own); });
  migrate(carried);
  sort_own();
  find_ghosts();
  lay_out(state, shapes, pieces);
  place(state, shapes, pieces);
  find_strengths();
  find_pairs(scene(), carried, pairs, stones);
  near_valid = false;
  stone_contacts.reset(scene(), stones);
  find_approaches(scene(), surfaces, surface_names, carried, approaches);
  find_at_border();
  store_reference();
  find_growing();
  place_bonds();
  ++rebuilds;
  ready = true;
}

}  // namespace trackbed::dem
