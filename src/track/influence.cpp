// The unknowns of the rails at a node, s_n, part the track in two: elements join neighbours alone,
// and a sleeper hangs on its own node. So with the unknowns left of node n + 1 and the sleeper of
// node n eliminated (Schur's complement, A_n),
//   s_n = P_n s_(n+1) + B_n f_n,   B_n = [A_n^-1]_ss,   P_n = -B_n U_n,
//   A_(n+1) = A - U_n' B_n U_n,   G_n = B_n + P_n G_(n+1) P_n',
// f_n forces on s_n, U_n the element's share between n and n + 1, G_n what f_n does to s_n. Forces
// b_l, b_r at both ends of element e count like c = P_e' b_l + b_r at its right end:
//   s_(e+1) = G_(e+1) c,   s_e = P_e s_(e+1) + B_e b_l,   s_n = P_n ... P_(e-1) s_e   for n < e,
// which is what the substitutions of a band solve do, of four unknowns a node instead of all
// unknowns and all wheels. P, B and G are made once.
// Cost: a product of 4 x 4 matrices per node between the first and the last point, and some ten
// numbers per pair of points. Rejected: a band solve with a right side for each wheel, which took
// nine tenths of a step (docs/decisions/track_alone.md); the inverse at all rail nodes, a quarter
// of a gigabyte for two rails of 200 m.
#include "influence.hpp"

#include <algorithm>

#include "digits.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

// m/N (1/N): what arrives from afar, no wheel feels, and products of it would leave the range of
// numbers. A force of 1e6 N moves less than 1e-30 m by it.
constexpr double faded = 1e-40;

}  // namespace

// Of one element: forces at its ends, and c above.
struct Influence::Point {
  std::size_t number;
  std::int32_t element = -1;  // -1: beyond the track
  Eigen::Vector4d left = Eigen::Vector4d::Zero(), right = left, both = left;
};

// What unit forces do to s of one node left of them: a column for each, the farthest first.
struct Influence::Waves {
  explicit Waves(std::size_t forces) : state(4, static_cast<Eigen::Index>(forces)) {}
  void pass(const Cut& by) {
    if (felt == all) return;
    auto going = state.middleCols(felt, all - felt);
    going = (by * going).eval();
    while (felt < all && state.col(felt).cwiseAbs().maxCoeff() < faded) ++felt;
  }

  Eigen::Matrix<double, 4, Eigen::Dynamic> state;
  std::int32_t node = 0;
  Eigen::Index felt = 0, all = 0;  // columns that have not faded begin at `felt`
};

Influence::Influence(const Sparse& matrix, const std::vector<RailNodes>& nodes)
    : place_(static_cast<std::size_t>(matrix.rows())) {
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (std::size_t k = 0; k < nodes[n].size(); ++k)
      if (nodes[n][k] >= 0)
        place_[static_cast<std::size_t>(nodes[n][k])] = {static_cast<std::int32_t>(n),
                                                         static_cast<std::int32_t>(k)};
  eliminate(matrix, nodes);
  inverse_ = alone_;
  for (std::size_t n = nodes.size() - 1; n-- > 0;)
    inverse_[n] = alone_[n] + pass_[n] * inverse_[n + 1] * pass_[n].transpose();
}

// Unknowns are numbered node by node: those of its rails first, then of its sleeper.
void Influence::eliminate(const Sparse& matrix, const std::vector<RailNodes>& nodes) {
  const auto begin_of = [&](std::size_t n) -> Eigen::Index {
    if (n == nodes.size()) return matrix.rows();
    const auto held = [](std::int32_t unknown) { return unknown < 0; };
    return *std::find_if_not(nodes[n].begin(), nodes[n].end(), held);
  };
  Cut carried = Cut::Zero();
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Eigen::Index begin = begin_of(n), count = begin_of(n + 1) - begin;
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(count, count);
    Eigen::MatrixXd rails = Eigen::MatrixXd::Zero(count, 4);
    Cut next = Cut::Zero();
    for (Eigen::Index column = 0; column < count; ++column) {
      const Place& own = place_[static_cast<std::size_t>(begin + column)];
      if (own.node >= 0) rails(column, own.number) = 1;
      for (Sparse::InnerIterator entry(matrix, begin + column); entry; ++entry) {
        const Eigen::Index row = entry.row() - begin;
        if (row >= 0 && row < count) block(row, column) = entry.value();
        if (row < count) continue;
        const Place& other = place_[static_cast<std::size_t>(entry.row())];
        require(own.node >= 0 && other.node == own.node + 1,
                "elements of rails alone join the nodes of a track");
        next(own.number, other.number) = entry.value();
      }
    }
    const Eigen::VectorXd diagonal = block.diagonal();
    block -= rails * carried * rails.transpose();
    const Eigen::LDLT<Eigen::MatrixXd> factor(block);
    require_digits(factor.vectorD(), factor.transpositionsP() * diagonal);
    alone_.push_back(rails.transpose() * factor.solve(rails));
    pass_.push_back(-alone_.back() * next);
    carried = next.transpose() * alone_.back() * next;
  }
}

Influence::Point Influence::point(const RailPoint& of, std::size_t number) const {
  Point point{.number = number};
  for (std::size_t k = 0; k < 4; ++k) {
    if (of.unknown[k] < 0) continue;
    const Place& place = place_[static_cast<std::size_t>(of.unknown[k])];
    require(place.node >= 0, "points of rails alone");
    point.element = k < 2 ? place.node : place.node - 1;
    (k < 2 ? point.left : point.right)[place.number] = of.value[k];
  }
  if (point.element >= 0)
    point.both =
        pass_[static_cast<std::size_t>(point.element)].transpose() * point.left + point.right;
  return point;
}

// From node `from` down to `to`: s_to per s_from.
Influence::Cut Influence::way(std::int32_t from, std::int32_t to) const {
  Cut product = Cut::Identity();
  for (std::int32_t n = from; n-- > to;) {
    product = (pass_[static_cast<std::size_t>(n)] * product).eval();
    if (product.cwiseAbs().maxCoeff() < faded) return Cut::Zero();
  }
  return product;
}

// From the last element with points back to the first one.
Eigen::MatrixXd Influence::between(const std::vector<RailPoint>& points) const {
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(count, count);
  std::vector<Point> on;
  for (std::size_t k = 0; k < points.size(); ++k)
    if (const Point one = point(points[k], k); one.element >= 0) on.push_back(one);
  std::sort(on.begin(), on.end(), [](const Point& a, const Point& b) {
    return a.element != b.element ? a.element > b.element : a.number < b.number;
  });
  const auto set = [&](const Point& one, const Point& other, double value) {
    const auto i = static_cast<Eigen::Index>(one.number);
    const auto j = static_cast<Eigen::Index>(other.number);
    result(i, j) = result(j, i) = value;
  };
  Waves waves(on.size());
  for (auto first = on.begin(); first != on.end();) {
    const std::int32_t e = first->element;
    const auto at = static_cast<std::size_t>(e);
    const auto last = std::find_if(first, on.end(), [e](const Point& p) { return p.element != e; });
    waves.pass(way(waves.node, e + 1));
    for (Eigen::Index k = waves.felt; k < waves.all; ++k)
      for (auto one = first; one != last; ++one)
        set(*one, on[static_cast<std::size_t>(k)], one->both.dot(waves.state.col(k)));
    waves.pass(pass_[at]);
    for (auto one = first; one != last; ++one) {
      const Eigen::Vector4d right = inverse_[at + 1] * one->both;
      const Eigen::Vector4d left = alone_[at] * one->left;
      for (auto other = first; other <= one; ++other)
        set(*one, *other, other->both.dot(right) + other->left.dot(left));
      waves.state.col(waves.all++) = pass_[at] * right + left;
    }
    waves.node = e;
    first = last;
  }
  return result;
}

}  // namespace trackbed::track
