// A bed from copies of one cell. The cell was periodic, so its two ends match: adjacent copies are
// in equilibrium as the cell was, to the rounding of their positions, if every contact keeps its
// history. A contact across the border of the cell becomes one between two neighbouring copies;
// positions in a checkpoint are unwrapped, so the distance of two partners determines in which copy
// the second one is.
//
// Cost: each rank reads the whole cell (250 bytes a particle, 72 a contact, in memory) and makes an
// even part of the copies with their histories, so that no data on a rank scale with the whole bed.
// Rejected: each rank reads part of the cell's rows, which would save the one cell and cost an
// exchange of ids and positions with the partners of every contact.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "dem/particles/impl.hpp"
#include "dem/state/stored.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/dem/templates.hpp"

namespace trackbed::dem {

namespace {

constexpr std::int64_t first_piece = (std::int64_t{1} << piece_bits) - 1;  // bits of a key

// The particles of a cell, ascending by id, on every rank.
struct OneCell {
  State state;
  std::vector<double> x;  // m, from the cell's lower side, within it
  std::int64_t size() const { return static_cast<std::int64_t>(x.size()); }
  std::int64_t number(Id id) const {
    return std::lower_bound(state.id.begin(), state.id.end(), id) - state.id.begin();
  }
};

// Ascending, since ids increase along the track, also in the copies.
OneCell read_cell(const io::File& file, const std::string& group, const Tiling& tiling) {
  OneCell cell;
  visit_state(cell.state, [&](auto quantity, auto& array) {
    using T = typename Number<std::decay_t<decltype(array[0])>>::type;
    const std::string path = group + "/" + quantity.name;
    if (is_stored(file, path)) unflatten(file.read_all<T>(path), array, quantity.columns);
  });
  fill_unstored(cell.state);
  std::vector<std::size_t> order(cell.state.id.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return cell.state.id[a] < cell.state.id[b]; });
  pick(cell.state, order);
  // Shifted into the cell: copies then follow each other and do not interleave.
  for (const Vec4& x : cell.state.x) {
    const double along = x.x - tiling.begin;
    cell.x.push_back(along - std::floor(along / tiling.length) * tiling.length);
  }
  return cell;
}

// Copies of contacts that a rank needs: those of the particles it makes.
class Copier {
 public:
  Copier(const OneCell& cell, const Tiling& tiling, bool ring, io::RowRange mine)
      : cell_(cell), tiling_(tiling), ring_(ring), mine_(mine) {}

  // All copies of one record. `names`: number in this run of each name of a surface in the file.
  void copy(const History& h, const std::vector<int>& names, std::vector<History>& to) const {
    const std::int64_t i = cell_.number(particle_of(h.first));
    const bool surface = h.second < 0;
    const std::int64_t j = surface ? i : cell_.number(particle_of(h.second));
    const std::int64_t beside = surface ? 0 : neighbour(i, j);
    for (std::int64_t k = 0; k < tiling_.copies; ++k) {
      const std::int64_t other = copy_at(k + beside);
      if (other < 0 || (!is_mine(k, i) && !is_mine(other, j))) continue;
      History copied = h;
      copied.first = key(k, i, h.first);
      copied.second = surface ? on_surface(h.second, names) : key(other, j, h.second);
      if (!surface && copied.first > copied.second) turn_round(copied);
      to.push_back(copied);
    }
  }

 private:
  // Number of copies between that of i and that of its partner j: the nearest image, since a cell
  // is longer than three particles.
  std::int64_t neighbour(std::int64_t i, std::int64_t j) const {
    const auto x = [&](std::int64_t n) { return cell_.x[static_cast<std::size_t>(n)]; };
    return -std::llround((x(j) - x(i)) / tiling_.length);
  }
  // Below 0: beyond the ends of a bed that is not periodic.
  std::int64_t copy_at(std::int64_t k) const {
    const std::int64_t n = tiling_.copies;
    return ring_ ? (k + n) % n : (k < n ? k : -1);
  }
  bool is_mine(std::int64_t k, std::int64_t i) const {
    const auto item = static_cast<std::size_t>(k * cell_.size() + i);
    return item >= mine_.begin && item < mine_.begin + mine_.count;
  }
  std::int64_t key(std::int64_t k, std::int64_t i, std::int64_t old) const {
    return piece_key(k * cell_.size() + i, static_cast<std::size_t>(old & first_piece));
  }
  static std::int64_t on_surface(std::int64_t old, const std::vector<int>& names) {
    const std::int64_t code = -1 - old;
    return patch_key(names.at(static_cast<std::size_t>(code >> 32)),
                     static_cast<int>(code & 0xffffffff));
  }
  // The same contact with exchanged partners: displacements are those of the first relative to the
  // second and change sign; a rotation about the normal does not, since the normal does.
  static void turn_round(History& h) {
    std::swap(h.first, h.second);
    for (double& xi : h.xi) xi = -xi;
    for (double& roll : h.roll) roll = -roll;
  }

  const OneCell& cell_;
  const Tiling& tiling_;
  bool ring_;
  io::RowRange mine_;
};

}  // namespace

// Motion is kept, not set to zero: then the copies continue exactly as the cell would have, and a
// cell at rest stays at rest. The offset of copies is a fraction of the domain, so that a rounding
// of the cell's length does not accumulate at the last joint.
void Particles::tile(const io::File& file, const std::string& group, const Tiling& tiling) {
  Impl& r = *impl_;
  require(r.comm.sum(static_cast<std::int64_t>(r.state.own)) == 0,
          "copying a cell requires an empty domain");
  if (file.has(group + "/bonds/stones") && file.extent(group + "/bonds/stones").at(0) > 0)
    throw InputError(
        {"bed.cell: its stones have bonds, which are not copied; make bonds in the run "
         "that lays the copies"});
  std::vector<int> shapes, names;
  for (const Template& shape : load_templates(file, group + "/template"))
    shapes.push_back(r.shapes.add(shape));
  for (const std::string& name : read_surface_names(file, group)) {
    const auto other = tiling.names.find(name);
    names.push_back(r.name_number(other == tiling.names.end() ? name : other->second));
  }
  const OneCell cell = read_cell(file, group, tiling);
  const double begin = r.domain.low.x();
  const double pitch = (r.domain.high.x() - begin) / static_cast<double>(tiling.copies);
  const io::RowRange mine = io::row_range(static_cast<std::size_t>(tiling.copies * cell.size()),
                                          r.comm.rank(), r.comm.size());
  r.state = cell.state;
  std::vector<std::size_t> rows;
  for (std::size_t item = mine.begin; item < mine.begin + mine.count; ++item)
    rows.push_back(item % cell.x.size());
  pick(r.state, rows);
  for (std::size_t b = 0; b < rows.size(); ++b) {
    const std::size_t item = mine.begin + b, k = item / cell.x.size();
    r.state.id[b] = static_cast<Id>(item);
    r.state.shape[b] = shapes.at(static_cast<std::size_t>(r.state.shape[b]));
    r.state.material[b] = tiling.materials.at(static_cast<std::size_t>(r.state.material[b]));
    r.state.x[b].x = begin + (static_cast<double>(k) * pitch + cell.x[rows[b]]);
    r.state.account[b] = {};
  }
  r.state.own = mine.count;
  r.derive(0);
  r.forget_contacts(), r.waiting.clear();
  const Copier copier(cell, tiling, r.domain.periodic[0], mine);
  for (const History& h : read_histories(file, group, Rows::all)) copier.copy(h, names, r.waiting);
  r.check_laws();
  // Last: the work of the first partition is counted from the waiting histories.
  r.choose_grid(r.work());
}

}  // namespace trackbed::dem
