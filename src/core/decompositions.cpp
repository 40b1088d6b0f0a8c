#include "trackbed/core/decompositions.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

namespace trackbed {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

SymmetricModes symmetric_modes(const Matrix& a) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Vector symmetric_eigenvalues(const Matrix& a) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Vector generalised_eigenvalues(const Matrix& k, const Matrix& m) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<Matrix>(k, m).eigenvalues();
}

Vector solution(const Matrix& a, const Vector& b) { return a.partialPivLu().solve(b); }

Matrix solutions(const Matrix& a, const Matrix& b) { return a.partialPivLu().solve(b); }

Matrix least_norm_solutions(const Matrix& a, const Matrix& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

}  // namespace trackbed
