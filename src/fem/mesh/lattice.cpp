// Geometry of the elements and the solid of each.
//
// An element has the solid in which its centre is. So layers and outlines need not follow element
// borders; a slope becomes a staircase, whose steps shrink with the elements.
#include "fem/mesh/lattice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "trackbed/core/error.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::fem {

namespace {

// Even-odd rule along a ray in +x. Corners on the ray count for one of their two edges only.
// Arithmetic on the same numbers: every rank assigns the same solid to an element.
bool inside(std::span<const double> outline, double x, double z) {
  const std::size_t corners = outline.size() / 2;
  bool in = false;
  // Edges (b, a); x of the crossing by linear interpolation.
  for (std::size_t a = 0, b = corners - 1; a < corners; b = a++) {
    const double xa = outline[2 * a], za = outline[2 * a + 1];
    const double xb = outline[2 * b], zb = outline[2 * b + 1];
    if ((za > z) != (zb > z) && x < xa + (z - za) * (xb - xa) / (zb - za)) in = !in;
  }
  return in;
}

// The layers together are the ground: there is no separate depth that could be inconsistent.
double depth_of(const GroundParameters& parameters) {
  return std::accumulate(parameters.layers.begin(), parameters.layers.end(), 0.0,
                         [](double sum, const Layer& layer) { return sum + layer.thickness; });
}

// Young's modulus along x from a table, Pa: linear between its rows, constant beyond them.
class Modulus {
 public:
  explicit Modulus(const std::string& path) {
    const auto columns = input::read_table(path, {"x_m", "young_Pa"}, "x_m");
    x_ = columns[0], young_ = columns[1];
    if (x_.empty()) throw InputError({fmt::format("{}: needs at least one row", path)});
    for (std::size_t r = 0; r < x_.size(); ++r)
      if (!(young_[r] > 0))
        throw InputError({fmt::format("{}: young_Pa = {:g} at x = {:g} m: must be above 0", path,
                                      young_[r], x_[r])});
  }
  double at(double x) const {
    if (x <= x_.front()) return young_.front();
    if (x >= x_.back()) return young_.back();
    const auto hi =
        static_cast<std::size_t>(std::upper_bound(x_.begin(), x_.end(), x) - x_.begin());
    const double fraction = (x - x_[hi - 1]) / (x_[hi] - x_[hi - 1]);
    return young_[hi - 1] + fraction * (young_[hi] - young_[hi - 1]);
  }

 private:
  std::vector<double> x_, young_;
};

// Named as in keys of a deck: by name, or by number if there is none.
std::string called(const char* kind, const std::string& name, std::size_t number) {
  return fmt::format("{} {}", kind, name.empty() ? std::to_string(number) : name);
}

}  // namespace

Vec3 Lattice::position(Id node) const {
  // One product per coordinate, not a running sum: bitwise identical for every caller.
  const Index3 p = node_index(node);
  Vec3 x;
  for (int a = 0; a < 3; ++a) {
    const auto at = static_cast<std::size_t>(a);
    x[a] = edges[at].empty() ? low[a] + static_cast<double>(p[at]) * size[a]
                             : edges[at][static_cast<std::size_t>(p[at])];
  }
  // A plane node represents both faces.
  if (plane) x.y() = low.y() + 0.5 * size.y();
  // The top face is exactly z = 0, whatever the rounding of element sizes.
  if (p[2] == elements[2]) x.z() = 0;
  return x;
}

Vec3 Lattice::centre(Id element) const {
  const Index3 z = element_index(element);
  Vec3 x;
  for (int a = 0; a < 3; ++a) {
    const auto at = static_cast<std::size_t>(a);
    const auto i = static_cast<std::size_t>(z[at]);
    x[a] = edges[at].empty() ? low[a] + (static_cast<double>(z[at]) + 0.5) * size[a]
                             : 0.5 * (edges[at][i] + edges[at][i + 1]);
  }
  return x;
}

// Differences of edges of nominally equal size differ by rounding: sizes are rounded to 1e-9.
Vec3 Lattice::size_of(Id element) const {
  const Index3 z = element_index(element);
  Vec3 found = size;
  for (int a = 0; a < 3; ++a) {
    const auto at = static_cast<std::size_t>(a);
    if (edges[at].empty()) continue;
    const auto i = static_cast<std::size_t>(z[at]);
    const double width = edges[at][i + 1] - edges[at][i];
    const double digits = std::pow(10.0, std::floor(std::log10(width)) - 9);
    found[a] = std::round(width / digits) * digits;
  }
  return found;
}

double Lattice::depth() const {
  return edges[2].empty() ? size.z() * static_cast<double>(elements[2]) : -low.z();
}

std::int64_t Lattice::home_count() const {
  const Index3 n = points();
  return (n[0] - (periodic[0] ? 1 : 0)) * (n[1] - (periodic[1] ? 1 : 0)) * n[2];
}

Id Lattice::home(Id id) const {
  if (!periodic[0] && !periodic[1]) return id;
  Index3 p = node_index(id);
  for (const std::size_t a : {0, 1})
    if (periodic[a] && p[a] == elements[a]) p[a] = 0;
  return node(p);
}

int Lattice::shown(Id home) const {
  const Index3 p = node_index(home);
  int count = plane ? 2 : 1;
  for (const std::size_t a : {0, 1})
    if (periodic[a] && p[a] == 0) count *= 2;
  return count;
}

// Eight inside a solid, fewer at its borders; four in a plane.
int Lattice::elements_at(Id node, std::array<Id, 8>& found) const {
  // Loops in the order of element numbers, so the result is ascending.
  const Index3 p = node_index(node);
  int count = 0;
  for (std::int64_t k = p[2] - 1; k <= p[2]; ++k)
    for (std::int64_t j = plane ? 0 : p[1] - 1; j <= p[1]; ++j)
      for (std::int64_t i = p[0] - 1; i <= p[0]; ++i) {
        Index3 at = {i, j, k};
        for (const std::size_t a : {0, 1})
          if (periodic[a] && at[a] < 0) at[a] += elements[a];
        bool in = true;
        for (std::size_t a = 0; a < 3; ++a) in = in && at[a] >= 0 && at[a] < elements[a];
        if (in) found[static_cast<std::size_t>(count++)] = element(at);
      }
  return count;
}

// Elements are boxes, m; a plane model is one element thick and centred about y = 0.
Lattice make_lattice(const GroundParameters& parameters, Dimension dimension, double thickness) {
  Lattice lattice;
  lattice.plane = dimension == Dimension::plane;
  lattice.elements = {parameters.elements_x, lattice.plane ? 1 : parameters.elements_y,
                      parameters.elements_over_depth()};
  const double depth = depth_of(parameters);
  lattice.low = {parameters.x[0], lattice.plane ? -0.5 * thickness : parameters.y[0], -depth};
  const Vec3 extent(parameters.x[1] - parameters.x[0],
                    lattice.plane ? thickness : parameters.y[1] - parameters.y[0], depth);
  for (int a = 0; a < 3; ++a)
    lattice.size[a] =
        extent[a] / static_cast<double>(lattice.elements[static_cast<std::size_t>(a)]);
  lattice.periodic = {parameters.periodic(0), !lattice.plane && parameters.periodic(1)};
  if (parameters.ratio_x != 1) lattice.edges[0] = parameters.edges(0);
  if (parameters.ratio_y != 1 && !lattice.plane) lattice.edges[1] = parameters.edges(1);
  if (parameters.layers_have_elements()) lattice.edges[2] = parameters.edges(2);
  return lattice;
}

bool contains(const Block& block, const Vec3& point) {
  const bool across = block.y.empty() || (block.y[0] <= point.y() && point.y() <= block.y[1]);
  return block.present && across && inside(block.outline, point.x(), point.z());
}

int block_at(const GroundParameters& parameters, const Vec3& point) {
  for (std::size_t b = parameters.blocks.size(); b-- > 0;) {
    // From the last block backwards: later blocks overrule earlier ones.
    if (contains(parameters.blocks[b], point))
      return static_cast<int>(parameters.layers.size() + b);
  }
  return -1;
}

// Layers in turn, then blocks in turn. Linear in the number of blocks and layers, a handful each;
// called a few times per held element.
int region_at(const GroundParameters& parameters, const Vec3& point) {
  if (const int block = block_at(parameters, point); block >= 0) return block;
  double bottom = 0;
  for (std::size_t l = 0; l < parameters.layers.size(); ++l) {
    bottom -= parameters.layers[l].thickness;
    if (point.z() > bottom) return static_cast<int>(l);
  }
  // Reached only by rounding of the lowest centre.
  return static_cast<int>(parameters.layers.size()) - 1;
}

// Damping that a solid does not define is that of the ground.
Solids::Solids(const GroundParameters& parameters, const Lattice& lattice) {
  const auto add = [&](int of, Elastic one, const Strength& limit, const std::string& as) {
    if (one.rayleigh_mass < 0) one.rayleigh_mass = parameters.rayleigh_mass;
    if (one.rayleigh_stiffness < 0) one.rayleigh_stiffness = parameters.rayleigh_stiffness;
    solid.push_back(one);
    strength.push_back(limit);
    name.push_back(as);
    region.push_back(of);
    return static_cast<int>(solid.size()) - 1;
  };
  int number = 0;
  for (const Layer& layer : parameters.layers) {
    const int of = number++;
    std::vector<int>& columns = columns_.emplace_back();
    const std::string as = called("layer", layer.name, columns_.size() - 1);
    if (layer.young_file.empty()) {
      columns.push_back(add(of, layer.solid, layer.strength, as));
      continue;
    }
    // Columns of equal modulus share a solid, so that the force kernel keeps its long runs there.
    const Modulus modulus(layer.young_file);
    for (std::int64_t i = 0; i < lattice.elements[0]; ++i) {
      const double x = lattice.centre(lattice.element({i, 0, 0})).x();
      Elastic one = layer.solid;
      one.young = modulus.at(x);
      const bool same = i > 0 && solid.back().young == one.young;
      columns.push_back(
          same ? columns.back()
               : add(of, one, layer.strength, fmt::format("{} at x = {:.4g} m", as, x)));
    }
  }
  for (const MeshSolid& one : parameters.solids)
    add(number++, one.solid, one.strength, "solid " + one.name);
  for (std::size_t b = 0; b < parameters.blocks.size(); ++b) {
    const Block& block = parameters.blocks[b];
    columns_.push_back(
        {add(number++, block.solid, block.strength, called("block", block.name, b))});
  }
  size.assign(solid.size(), lattice.size);
  if (lattice.graded() && !parameters.of_tetrahedra()) separate_sizes(parameters, lattice);
  find_alike(parameters);
}

Solids::KindAndSize Solids::key_of(int kind, const Vec3& size) {
  return {static_cast<double>(kind), size.x(), size.y(), size.z()};
}

// Every rank visits all elements in turn: the same numbers on each without a message.
void Solids::separate_sizes(const GroundParameters& parameters, const Lattice& lattice) {
  const Solids plain = *this;
  solid.clear(), strength.clear(), name.clear(), size.clear(), region.clear();
  for (Id element = 0; element < lattice.element_count(); ++element) {
    const int of = plain.kind_of(parameters, lattice, element);
    const Vec3 extent = lattice.size_of(element);
    const auto next = static_cast<int>(solid.size());
    if (!sized_.emplace(key_of(of, extent), next).second) continue;
    const auto at = static_cast<std::size_t>(of);
    solid.push_back(plain.solid[at]), strength.push_back(plain.strength[at]);
    name.push_back(plain.name[at]), size.push_back(extent);
    region.push_back(plain.region[at]);
  }
}

void Solids::find_alike(const GroundParameters& parameters) {
  std::map<KindAndSize, std::int32_t> first;
  for (std::int32_t s = 0; const std::int32_t of : region) {
    const auto layer = static_cast<std::size_t>(of);
    const bool changes =
        layer < parameters.layers.size() && !parameters.layers[layer].young_file.empty();
    const Vec3& extent = size[static_cast<std::size_t>(s)];
    alike.push_back(changes ? first.emplace(key_of(of, extent), s).first->second : s);
    ++s;
  }
}

int Solids::of(const GroundParameters& parameters, const Lattice& lattice, Id element) const {
  const int found = kind_of(parameters, lattice, element);
  return sized_.empty() ? found : sized_.at(key_of(found, lattice.size_of(element)));
}

int Solids::kind_of(const GroundParameters& parameters, const Lattice& lattice, Id element) const {
  return in(region_at(parameters, lattice.centre(element)), lattice.element_index(element)[0]);
}

int Solids::in(int region, std::int64_t column) const {
  const auto& columns = columns_[static_cast<std::size_t>(region)];
  return columns.size() == 1 ? columns.front() : columns[static_cast<std::size_t>(column)];
}

}  // namespace trackbed::fem
