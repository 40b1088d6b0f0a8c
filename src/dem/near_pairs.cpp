// Selection of near pairs and the way of their histories from the neighbour list to lanes and back.
#include "near_pairs.hpp"

namespace trackbed::dem {

namespace {

// m; squares of it are still numbers, and no two particles are that far apart.
constexpr double far_away = 1e100;

}  // namespace

// Lanes behind the last pair repeat it at a place where it touches nothing.
void NearPairs::gather(const std::vector<Vec4>& x, const PairList& list, double margin) {
  clear();
  shifts = list.shifts;
  shifts.push_back({far_away, 0, 0, 0});
  one_law = true;
  const std::uint8_t first_law = list.entries.empty() ? 0 : list.entries.front().law;
  const auto put = [&](std::size_t k, std::int32_t i, std::uint32_t e) {
    PairBlock& b = blocks.back();
    const Entry& entry = list.entries[e];
    const Vec4& xi = list.xi[e];
    b.i[k] = i, b.j[k] = entry.piece, b.entry[k] = e;
    b.shift[k] = entry.shift, b.law[k] = entry.law;
    b.ri[k] = x[static_cast<std::size_t>(i)].w;
    b.rj[k] = x[static_cast<std::size_t>(entry.piece)].w;
    b.root_mass[k] = xi.w, b.xi.x[k] = xi.x, b.xi.y[k] = xi.y, b.xi.z[k] = xi.z;
    b.touches[k] = entry.touching ? -1 : 0;
    if (!list.size.empty()) size.back()[k] = list.size[e];
    if (list.roll.empty()) return;
    const Vec4& r = list.roll[e];
    roll.back().x[k] = r.x, roll.back().y[k] = r.y, roll.back().z[k] = r.z;
  };
  for (const Row& row : list.rows) {
    const Vec4 pi = x[static_cast<std::size_t>(row.piece)];
    for (std::uint32_t e = row.begin; e < row.end; ++e) {
      const Entry& entry = list.entries[e];
      const Vec4 &pj = x[static_cast<std::size_t>(entry.piece)], &h = list.shifts[entry.shift];
      const double dx = pj.x - pi.x + h.x, dy = pj.y - pi.y + h.y, dz = pj.z - pi.z + h.z;
      const double reach = pi.w + pj.w + margin;
      // What touched is kept until a sub-step has seen that it does not any more.
      if (!(dx * dx + dy * dy + dz * dz < reach * reach) && !entry.touching) continue;
      if (count % lanes == 0) {
        blocks.emplace_back();
        if (!list.size.empty()) size.push_back(Lanes{});
        if (!list.roll.empty()) roll.push_back(Lanes3{});
      }
      put(count++ % lanes, row.piece, e);
      one_law = one_law && entry.law == first_law;
    }
  }
  if (count % lanes == 0) return;
  PairBlock& last = blocks.back();
  const std::size_t used = count % lanes;
  for (std::size_t k = used; k < lanes; ++k) {
    put(k, last.i[used - 1], last.entry[used - 1]);
    last.shift[k] = static_cast<std::int32_t>(shifts.size()) - 1;
    last.touches[k] = 0;
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
