// Decompositions of small dense matrices. Wherever Eigen's templates for one of them are expanded,
// the compiler needs several seconds; here it is done once. They allocate: of the loops over time
// only implicit plastic steps (each yielding element) and passages (each iteration) call them.
#pragma once

#include <Eigen/Core>

namespace trackbed {

// a = V diag(values) V^T of a symmetric matrix, of which the lower triangle is read; ascending.
struct SymmetricModes {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricModes symmetric_modes(const Eigen::MatrixXd& a);
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a);

// w^2 of k x = w^2 m x, ascending; k is symmetric, m also positive definite.
Eigen::VectorXd generalised_eigenvalues(const Eigen::MatrixXd& k, const Eigen::MatrixXd& m);

// x of a x = b for a regular square matrix, by LU with partial pivoting. A singular matrix yields
// values that are not finite.
Eigen::VectorXd solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd solutions(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// The x of least norm among those that minimise |a x - b|; a may be singular.
Eigen::MatrixXd least_norm_solutions(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace trackbed
