// The unknowns of the rails at a node, s_n, separate the track into two parts: elements connect
// neighbouring nodes only, and a sleeper is connected to one node. With the unknowns left of node
// n + 1 and the sleeper of node n eliminated (Schur complement A_n),
//   s_n = P_n s_(n+1) + B_n f_n,   B_n = [A_n^-1]_ss,   P_n = -B_n U_n,
//   A_(n+1) = A - U_n' B_n U_n,   G_n = B_n + P_n G_(n+1) P_n',
// f_n forces on s_n, U_n the block of the element between n and n + 1, G_n the flexibility of s_n.
// Forces b_l, b_r at both ends of element e are equivalent to c = P_e' b_l + b_r at its right end:
//   s_(e+1) = G_(e+1) c,   s_e = P_e s_(e+1) + B_e b_l,   s_n = P_n ... P_(e-1) s_e   for n < e,
// as in the substitutions of a band solve, but with four unknowns per node instead of all unknowns
// and all wheels. P, B and G are computed once.
// Cost: a product of 4 x 4 matrices per node between the first and the last point, and some ten
// operations per pair of points. Rejected: a band solve with a right side for each wheel, which
// took nine tenths of a step (docs/decisions/track_alone.md); the inverse at all rail nodes, a
// quarter of a gigabyte for two rails of 200 m.
#include "track/passage/influence.hpp"

#include <algorithm>

#include "track/passage/digits.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

// m/N (1/N): smaller responses are set to zero, since their products would underflow. A force of
// 1e6 N gives less than 1e-30 m.
constexpr double negligible = 1e-40;

}  // namespace

// A point in an element: equivalent forces at its ends, and c above.
struct Influence::Point {
  std::size_t number;
  std::int32_t element = -1;  // -1: beyond the track
  Eigen::Vector4d left = Eigen::Vector4d::Zero(), right = left, both = left;
};

// Responses s at one node to unit forces on its right: a column for each, the farthest first.
struct Influence::Responses {
  explicit Responses(std::size_t forces) : state(4, static_cast<Eigen::Index>(forces)) {}
  void transfer(const Block& by) {
    if (first == all) return;
    auto active = state.middleCols(first, all - first);
    active = (by * active).eval();
    while (first < all && state.col(first).cwiseAbs().maxCoeff() < negligible) ++first;
  }

  Eigen::Matrix<double, 4, Eigen::Dynamic> state;
  std::int32_t node = 0;
  Eigen::Index first = 0, all = 0;  // `first`: of the columns that are not negligible
};

Influence::Influence(const Sparse& matrix, const std::vector<RailNodes>& nodes)
    : place_(static_cast<std::size_t>(matrix.rows())) {
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (std::size_t k = 0; k < nodes[n].size(); ++k)
      if (nodes[n][k] >= 0)
        place_[static_cast<std::size_t>(nodes[n][k])] = {static_cast<std::int32_t>(n),
                                                         static_cast<std::int32_t>(k)};
  eliminate(matrix, nodes);
  whole_ = partial_;
  for (std::size_t n = nodes.size() - 1; n-- > 0;)
    whole_[n] = partial_[n] + transfer_[n] * whole_[n + 1] * transfer_[n].transpose();
}

// Unknowns are numbered node by node: first those of its rails, then those of its sleeper.
void Influence::eliminate(const Sparse& matrix, const std::vector<RailNodes>& nodes) {
  const auto begin_of = [&](std::size_t n) -> Eigen::Index {
    if (n == nodes.size()) return matrix.rows();
    const auto held = [](std::int32_t unknown) { return unknown < 0; };
    return *std::find_if_not(nodes[n].begin(), nodes[n].end(), held);
  };
  Block carried = Block::Zero();
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Eigen::Index begin = begin_of(n), count = begin_of(n + 1) - begin;
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(count, count);
    Eigen::MatrixXd rails = Eigen::MatrixXd::Zero(count, 4);
    Block next = Block::Zero();
    for (Eigen::Index column = 0; column < count; ++column) {
      const Place& own = place_[static_cast<std::size_t>(begin + column)];
      if (own.node >= 0) rails(column, own.number) = 1;
      for (Sparse::InnerIterator entry(matrix, begin + column); entry; ++entry) {
        const Eigen::Index row = entry.row() - begin;
        if (row >= 0 && row < count) block(row, column) = entry.value();
        if (row < count) continue;
        const Place& other = place_[static_cast<std::size_t>(entry.row())];
        require(own.node >= 0 && other.node == own.node + 1,
                "only elements of rails connect the nodes of a track");
        next(own.number, other.number) = entry.value();
      }
    }
    const Eigen::VectorXd diagonal = block.diagonal();
    block -= rails * carried * rails.transpose();
    const Eigen::LDLT<Eigen::MatrixXd> factor(block);
    require_digits(factor.vectorD(), factor.transpositionsP() * diagonal);
    partial_.push_back(rails.transpose() * factor.solve(rails));
    transfer_.push_back(-partial_.back() * next);
    carried = next.transpose() * partial_.back() * next;
  }
}

Influence::Point Influence::point(const RailPoint& of, std::size_t number) const {
  Point point{.number = number};
  for (std::size_t k = 0; k < 4; ++k) {
    if (of.unknown[k] < 0) continue;
    const Place& place = place_[static_cast<std::size_t>(of.unknown[k])];
    require(place.node >= 0, "influence coefficients are those of points of rails");
    point.element = k < 2 ? place.node : place.node - 1;
    (k < 2 ? point.left : point.right)[place.number] = of.value[k];
  }
  if (point.element >= 0)
    point.both =
        transfer_[static_cast<std::size_t>(point.element)].transpose() * point.left + point.right;
  return point;
}

// From node `from` down to `to`: s_to per s_from.
Influence::Block Influence::transfer(std::int32_t from, std::int32_t to) const {
  Block product = Block::Identity();
  for (std::int32_t n = from; n-- > to;) {
    product = (transfer_[static_cast<std::size_t>(n)] * product).eval();
    if (product.cwiseAbs().maxCoeff() < negligible) return Block::Zero();
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
  Responses responses(on.size());
  for (auto first = on.begin(); first != on.end();) {
    const std::int32_t e = first->element;
    const auto at = static_cast<std::size_t>(e);
    const auto last = std::find_if(first, on.end(), [e](const Point& p) { return p.element != e; });
    responses.transfer(transfer(responses.node, e + 1));
    for (Eigen::Index k = responses.first; k < responses.all; ++k)
      for (auto one = first; one != last; ++one)
        set(*one, on[static_cast<std::size_t>(k)], one->both.dot(responses.state.col(k)));
    responses.transfer(transfer_[at]);
    for (auto one = first; one != last; ++one) {
      const Eigen::Vector4d right = whole_[at + 1] * one->both;
      const Eigen::Vector4d left = partial_[at] * one->left;
      for (auto other = first; other <= one; ++other)
        set(*one, *other, other->both.dot(right) + other->left.dot(left));
      responses.state.col(responses.all++) = transfer_[at] * right + left;
    }
    responses.node = e;
    first = last;
  }
  return result;
}

}  // namespace trackbed::track
