// Cells give the partners of each particle; a sort by id gives the unique order on which bitwise
// reproducibility relies (docs/decisions/particles.md). Cost: about linear in the particles; run at
// rebuilds only. Rejected: rows for each particle with all its partners, which computes each
// contact twice on every rank.
#include "dem/search/pairs.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "dem/search/cells.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::dem {

namespace {

struct Partner {
  Id id;
  std::int32_t body;
  std::uint16_t shift;
};

// Builds the rows of two lists at once: pairs of balls and pairs with corners have the same
// partners.
class PairFinder {
 public:
  PairFinder(const Scene& scene, const std::vector<History>& history, PairList& pairs,
             StoneList& stones)
      : scene_(scene),
        history_(history),
        pairs_(pairs),
        stones_(stones),
        cells_(scene.state, scene.grid, scene.state.size()) {}

  // Rows of ghosts too: a contact of a ghost with a higher own id is in the ghost's row.
  void run() {
    const State& s = scene_.state;
    std::vector<std::int32_t> order(s.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
      return s.id[static_cast<std::size_t>(a)] < s.id[static_cast<std::size_t>(b)];
    });
    pairs_.clear(), stones_.clear();
    for (const std::int32_t body : order) {
      find_partners(static_cast<std::size_t>(body));
      for (std::size_t p = scene_.pieces.begin[static_cast<std::size_t>(body)];
           p < scene_.pieces.begin[static_cast<std::size_t>(body) + 1]; ++p)
        make_row(p);
    }
    // One numbering for both lists.
    stones_.shifts = pairs_.shifts;
    pairs_.xi.shrink_to_fit(), pairs_.roll.shrink_to_fit();
  }

 private:
  // All levels of sizes, each up to the reach of its largest particle. A pair is taken from the
  // side of the lower id; pairs of two ghosts are not needed on this rank. Two held particles have
  // no contact: no force would move them, and they may overlap by design.
  void find_partners(std::size_t i) {
    const State& s = scene_.state;
    const Vec3 home = scene_.grid.wrapped(s.x[i].vec3(), cells_.wrap(i));
    partners_.clear();
    const Vec4 ball{home.x(), home.y(), home.z(), s.x[i].w};
    for (std::size_t level = 0; level < scene_.grid.levels().size(); ++level)
      cells_.near(level, ball, [&](const Cells::Member& member, const Cell& across) {
        const auto j = static_cast<std::size_t>(member.particle);
        if (member.id <= s.id[i] || (i >= s.own && j >= s.own)) return;
        if (s.held[i] != 0 && s.held[j] != 0) return;
        const std::uint16_t shift = shift_number(cells_.wrap(i), cells_.wrap(j), across);
        partners_.push_back({member.id, member.particle, shift});
      });
    // The order of cells depends on positions and ranks; that of ids does not.
    std::sort(partners_.begin(), partners_.end(),
              [](const Partner& a, const Partner& b) { return a.id < b.id; });
  }

  // Balls with skin; all closer pairs at the rebuild are in the list until the next one.
  bool near(const Vec4& a, const Vec4& b, std::uint16_t shift) const {
    const Vec4& h = pairs_.shifts[shift];
    const double dx = b.x - a.x + h.x, dy = b.y - a.y + h.y, dz = b.z - a.z + h.z;
    const double reach = a.w + b.w + scene_.skin;
    return dx * dx + dy * dy + dz * dz < reach * reach;
  }

  // Raw positions are unwrapped; the shift brings j to the image that neighbours i. x_j + wrap_j L
  // + across L is beside x_i + wrap_i L, so x_j gets (wrap_j - wrap_i + across) L, L the period, m.
  std::uint16_t shift_number(const std::array<int, 3>& wrap_i, const std::array<int, 3>& wrap_j,
                             const std::array<int, 3>& across) {
    std::array<int, 3> turns{};
    for (std::size_t a = 0; a < 3; ++a) turns[a] = wrap_j[a] - wrap_i[a] + across[a];
    if (turns == std::array<int, 3>{}) return 0;
    const auto [known, added] =
        numbers_.try_emplace(turns, static_cast<std::uint16_t>(pairs_.shifts.size()));
    if (added) {
      require(pairs_.shifts.size() < 65535, "there are at most 65535 different periodic shifts");
      pairs_.shifts.push_back({turns[0] * scene_.grid.period(0), turns[1] * scene_.grid.period(1),
                               turns[2] * scene_.grid.period(2), 0});
    }
    return known->second;
  }

  // The row of piece p with all pieces of all partners. A partner's ball as a whole is tested
  // first, if that saves work.
  void make_row(std::size_t p) {
    const State& s = scene_.state;
    const auto i = static_cast<std::size_t>(scene_.pieces.body[p]);
    const auto begin = static_cast<std::uint32_t>(pairs_.entries.size());
    const auto stones_begin = static_cast<std::uint32_t>(stones_.entries.size());
    const std::int64_t key = piece_key(s.id[i], p - scene_.pieces.begin[i]);
    for (const Partner& partner : partners_) {
      const auto j = static_cast<std::size_t>(partner.body);
      if (scene_.pieces.begin[i + 1] - scene_.pieces.begin[i] > 1) {
        Vec4 piece = scene_.pieces.x[p];
        if (!near(piece, s.x[j], partner.shift)) continue;
      }
      for (std::size_t r = scene_.pieces.begin[j]; r < scene_.pieces.begin[j + 1]; ++r)
        if (near(scene_.pieces.x[p], scene_.pieces.x[r], partner.shift))
          add_entry(p, r, partner.shift, key);
    }
    end_row(p, begin, pairs_);
    end_row(p, stones_begin, stones_);
  }

  static void end_row(std::size_t p, std::uint32_t begin, PairList& list) {
    const auto end = static_cast<std::uint32_t>(list.entries.size());
    if (end > begin) list.rows.push_back({static_cast<std::int32_t>(p), begin, end});
  }

  bool has_corners(std::size_t p) const {
    const Pieces& pieces = scene_.pieces;
    return !pieces.core.empty() && scene_.shapes.core(pieces.core[p]).corners.size() > 1;
  }

  // For a held particle the mass of the other one: no force moves a held particle.
  static double effective_mass(const State& s, std::size_t i, std::size_t j) {
    const double m_i = s.v[i].w, m_j = s.v[j].w;
    if (s.held[i] != 0) return m_j;
    return s.held[j] != 0 ? m_i : m_i * m_j / (m_i + m_j);
  }

  // The law is looked up here and not in each sub-step; its existence has been checked
  // (`check_laws`).
  void add_entry(std::size_t p, std::size_t r, std::uint16_t shift, std::int64_t key) {
    const State& s = scene_.state;
    const auto i = static_cast<std::size_t>(scene_.pieces.body[p]);
    const auto j = static_cast<std::size_t>(scene_.pieces.body[r]);
    const int law =
        scene_.laws.index(static_cast<int>(s.material[i]), static_cast<int>(s.material[j]));
    require(law >= 0, "there is a contact law between the materials of two particles");
    // Masses do not change between rebuilds, so neither does the root of m_eff.
    Vec4 xi{0, 0, 0, std::sqrt(effective_mass(s, i, j))}, roll{};
    // Rows and entries ascend like the sorted history, so one pass over it is sufficient.
    const History wanted = history_of_keys(key, piece_key(s.id[j], r - scene_.pieces.begin[j]));
    while (next_ < history_.size() && history_[next_] < wanted) ++next_;
    std::uint8_t touching = 0;
    Vec4 turn{};
    double size = 0;
    // In contact from the start: a pair that is not in contact any more loses its history in the
    // next sub-step.
    if (next_ < history_.size() && !(wanted < history_[next_])) {
      touching = 1;
      xi.set(Eigen::Map<const Vec3>(history_[next_].xi));
      turn = {history_[next_].turn, history_[next_].size, history_[next_].ring, 0};
      size = history_[next_].size;
      roll.set(Eigen::Map<const Vec3>(history_[next_].roll));
    }
    const bool stones = has_corners(p) || has_corners(r);
    PairList& list = stones ? stones_ : pairs_;
    list.entries.push_back(
        {static_cast<std::int32_t>(r), shift, static_cast<std::uint8_t>(law), touching});
    list.xi.push_back(xi);
    if (rolls_) list.roll.push_back(roll);
    if (stones)
      stones_.turn.push_back(turn);
    else if (hertz_)
      list.size.push_back(size);
  }

  const Scene& scene_;
  const std::vector<History>& history_;
  PairList& pairs_;
  StoneList& stones_;
  Cells cells_;
  bool rolls_ = scene_.laws.any_rolls(), hertz_ = scene_.laws.any_hertz();
  std::vector<Partner> partners_;
  std::map<std::array<int, 3>, std::uint16_t> numbers_;
  std::size_t next_ = 0;
};

}  // namespace

void find_pairs(const Scene& scene, const std::vector<History>& history, PairList& pairs,
                StoneList& stones) {
  PairFinder(scene, history, pairs, stones).run();
}

// The reverse: every contact of this rank's lists as a record, sorted. Both ranks of a contact
// obtain the same record. Local.
std::vector<History> collect_history(const State& state, const Pieces& pieces,
                                     const PairList& pairs, const StoneList& stones,
                                     const std::vector<Approach>& approaches,
                                     const std::vector<int>& names) {
  std::vector<History> all;
  const auto key = [&](std::int32_t piece) {
    const auto p = static_cast<std::size_t>(piece);
    const auto b = static_cast<std::size_t>(pieces.body[p]);
    return piece_key(state.id[b], p - pieces.begin[b]);
  };
  const auto collect = [&](const PairList& list, const std::vector<Vec4>* turn) {
    for (const Row& row : list.rows)
      for (std::uint32_t e = row.begin; e < row.end; ++e) {
        if (!list.entries[e].touching) continue;
        const Vec4 roll = list.roll.empty() ? Vec4{} : list.roll[e];
        const Vec4 about = turn ? (*turn)[e] : Vec4{0, list.size.empty() ? 1 : list.size[e], 0, 0};
        all.push_back({key(row.piece),
                       key(list.entries[e].piece),
                       {list.xi[e].x, list.xi[e].y, list.xi[e].z},
                       about.x,
                       about.y,
                       about.z,
                       {roll.x, roll.y, roll.z}});
      }
  };
  // Each of the lists is in order already.
  collect(pairs, nullptr);
  const auto stones_begin = static_cast<std::ptrdiff_t>(all.size());
  collect(stones, &stones.turn);
  const auto surfaces_begin = static_cast<std::ptrdiff_t>(all.size());
  for (const Approach& a : approaches)
    for (const Approach::Patch& p : a.patches)
      all.push_back({key(a.piece),
                     patch_key(names[static_cast<std::size_t>(a.surface)], p.patch),
                     {p.xi.x, p.xi.y, p.xi.z},
                     p.turn,
                     p.size,
                     p.ring,
                     {p.roll.x, p.roll.y, p.roll.z}});
  std::sort(all.begin() + surfaces_begin, all.end());
  std::inplace_merge(all.begin() + stones_begin, all.begin() + surfaces_begin, all.end());
  std::inplace_merge(all.begin(), all.begin() + stones_begin, all.end());
  return all;
}

}  // namespace trackbed::dem
