// Selection of near pairs, and transfer of their histories from the neighbour list to lanes and
// back.
#include "dem/search/near_pairs.hpp"

#include <algorithm>

namespace trackbed::dem {

namespace {

// m; its squares are finite, and no two particles are that far apart.
constexpr double far_away = 1e100;

}  // namespace

// Into a lane of the last block.
void NearPairs::put(std::size_t lane, std::int32_t piece, std::uint32_t e,
                    const std::vector<Vec4>& x, const PairList& list) {
  PairBlock& b = blocks.back();
  const Entry& entry = list.entries[e];
  const Vec4& xi = list.xi[e];
  b.i[lane] = piece, b.j[lane] = entry.piece, b.entry[lane] = e;
  b.shift[lane] = entry.shift, b.law[lane] = entry.law;
  b.ri[lane] = x[static_cast<std::size_t>(piece)].w;
  b.rj[lane] = x[static_cast<std::size_t>(entry.piece)].w;
  b.root_mass[lane] = xi.w, b.xi.x[lane] = xi.x, b.xi.y[lane] = xi.y, b.xi.z[lane] = xi.z;
  b.touches[lane] = entry.touching ? -1 : 0;
  if (!list.size.empty()) size.back()[lane] = list.size[e];
  if (list.roll.empty()) return;
  const Vec4& r = list.roll[e];
  roll.back().x[lane] = r.x, roll.back().y[lane] = r.y, roll.back().z[lane] = r.z;
}

// Lanes after the last pair repeat it at a place where it touches nothing.
void NearPairs::fill_last(const std::vector<Vec4>& x, const PairList& list) {
  const std::size_t used = count % lanes;
  if (used == 0) return;
  PairBlock& last = blocks.back();
  for (std::size_t lane = used; lane < lanes; ++lane) {
    put(lane, last.i[used - 1], last.entry[used - 1], x, list);
    last.shift[lane] = static_cast<std::int32_t>(shifts.size()) - 1;
    last.touches[lane] = 0;
  }
}

void NearPairs::gather(const std::vector<Vec4>& x, const std::vector<std::int32_t>& body,
                       const PairList& list, const Limits* limits) {
  const auto is_slow = [&](std::int32_t piece) {
    return slow[static_cast<std::size_t>(body[static_cast<std::size_t>(piece)])] > 0;
  };
  clear();
  shifts = list.shifts;
  shifts.push_back({far_away, 0, 0, 0});
  one_law = true;
  for (const Row& row : list.rows) {
    const Vec4 pi = x[static_cast<std::size_t>(row.piece)];
    const bool row_is_slow = is_slow(row.piece);
    for (std::uint32_t e = row.begin; e < row.end; ++e) {
      const Entry& entry = list.entries[e];
      const Vec4 &pj = x[static_cast<std::size_t>(entry.piece)], &h = list.shifts[entry.shift];
      const double dx = pj.x - pi.x + h.x, dy = pj.y - pi.y + h.y, dz = pj.z - pi.z + h.z;
      const double reach = pi.w + pj.w + margin;
      const bool is_far = !(dx * dx + dy * dy + dz * dz < reach * reach);
      // A pair that was in contact is kept until a sub-step has found that it is not any more.
      if (is_far && !entry.touching && row_is_slow && is_slow(entry.piece)) continue;
      if (count % lanes == 0) {
        blocks.emplace_back();
        if (!list.size.empty()) size.push_back(Lanes{});
        if (!list.roll.empty()) roll.push_back(Lanes3{});
      }
      put(count++ % lanes, row.piece, e, x, list);
      one_law = one_law && entry.law == blocks.front().law[0];
    }
  }
  fill_last(x, list);
  if (limits) find_limits(*limits);
}

// Slightly before the force is reached, which decides: its rounding is not that of the overlap.
void NearPairs::find_limits(const Limits& limits) {
  constexpr double before = 1e-14;  // of the reach, whose rounding the overlap has
  limit.resize(blocks.size());
  for (std::size_t n = 0; n < blocks.size(); ++n)
    for (std::size_t k = 0; k < lanes; ++k) {
      const PairBlock& b = blocks[n];
      const double weaker = std::min(limits.strength[static_cast<std::size_t>(b.i[k])],
                                     limits.strength[static_cast<std::size_t>(b.j[k])]);
      const double reach = b.ri[k] + b.rj[k];
      limit[n][k] =
          overlap_at(limits.laws[b.law[k]], weaker, b.ri[k] * b.rj[k] / reach) - before * reach;
    }
}

void NearPairs::store(PairList& list) const {
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t n = k / lanes, lane = k % lanes;
    const PairBlock& b = blocks[n];
    const std::uint32_t e = b.entry[lane];
    list.entries[e].touching = b.touches[lane] != 0;
    list.xi[e].set({b.xi.x[lane], b.xi.y[lane], b.xi.z[lane]});
    if (!size.empty()) list.size[e] = size[n][lane];
    if (!roll.empty()) list.roll[e] = {roll[n].x[lane], roll[n].y[lane], roll[n].z[lane], 0};
  }
}

}  // namespace trackbed::dem
