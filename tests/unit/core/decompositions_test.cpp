// Each decomposition against its defining equations, on random matrices.
#include "trackbed/core/decompositions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trackbed/core/rotation.hpp"

namespace trackbed::decompositions_test {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr double rounding = 1e-12;  // entries are of order 1; 8 rows and columns

double largest(const Matrix& m) { return m.cwiseAbs().maxCoeff(); }

Matrix symmetric(int n) {
  const Matrix a = Matrix::Random(n, n);
  return a + a.transpose();
}

TEST(Decompositions, ModesOfASymmetricMatrix) {
  const Matrix a = symmetric(8);
  const auto [values, vectors] = symmetric_modes(a);
  EXPECT_LT(largest(a * vectors - vectors * values.asDiagonal()), rounding);
  EXPECT_LT(largest(vectors.transpose() * vectors - Matrix::Identity(8, 8)), rounding);
  EXPECT_LT(largest(symmetric_eigenvalues(a) - values), rounding);
  EXPECT_TRUE(std::is_sorted(values.begin(), values.end()));
}

TEST(Decompositions, EigenvaluesOfAPencilMakeItSingular) {
  const Matrix k = symmetric(8), root = Matrix::Random(8, 8);
  const Matrix m = root * root.transpose() + Matrix::Identity(8, 8);
  const Vector squared = generalised_eigenvalues(k, m);
  EXPECT_TRUE(std::is_sorted(squared.begin(), squared.end()));
  for (const double s : squared) {
    const Vector of = symmetric_eigenvalues(k - s * m);
    EXPECT_LT(of.cwiseAbs().minCoeff(), 1e-10);  // times m, of order 10
  }
}

TEST(Decompositions, SolutionsOfARegularSystem) {
  const Matrix a = Matrix::Random(8, 8) + 8 * Matrix::Identity(8, 8), b = Matrix::Random(8, 3);
  EXPECT_LT(largest(a * solutions(a, b) - b), rounding);
  EXPECT_LT(largest(a * solution(a, b.col(1)) - b.col(1)), rounding);
}

// The residual is orthogonal to the columns of a, the solution to its null space.
TEST(Decompositions, LeastNormOfASingularSystem) {
  const Matrix left = Matrix::Random(8, 5), a = left * Matrix::Random(5, 8);
  const Matrix b = Matrix::Random(8, 2), x = least_norm_solutions(a, b);
  EXPECT_LT(largest(a.transpose() * (a * x - b)), 100 * rounding);  // the condition of a
  const auto [values, vectors] = symmetric_modes(a.transpose() * a);
  EXPECT_LT(largest(vectors.leftCols(3).transpose() * x), 100 * rounding);
}

TEST(Rotation, TurnsOneDirectionOntoAnother) {
  for (int k = 0; k < 100; ++k) {
    const Vec3 from = Vec3::Random(), to = Vec3::Random();
    const Quat q = rotation_onto(from, to);
    EXPECT_LT((q * from.normalized() - to.normalized()).norm(), rounding);
    EXPECT_NEAR(q.norm(), 1, rounding);
    // The shortest: about an axis across both.
    EXPECT_LT(std::abs(q.vec().dot(from)) + std::abs(q.vec().dot(to)), rounding);
  }
}

TEST(Rotation, ByHalfATurnAndByNone) {
  const Vec3 up = Vec3::UnitZ();
  EXPECT_LT((rotation_onto(up, -up) * up + up).norm(), rounding);
  EXPECT_LT((rotation_onto(up, up) * up - up).norm(), rounding);
  for (const double off : {1e-9, 1e-5, 1e-3, 2e-3})
    EXPECT_LT((rotation_onto(up, {off, 0, -1}) * up - Vec3(off, 0, -1).normalized()).norm(), 1e-9);
}

}  // namespace
}  // namespace trackbed::decompositions_test
