#pragma once
/// Decompositions of matrices whose size is known at run time, as plain functions. Each takes Eigen seconds to compile
/// in every file that contains it; behind a function it is compiled once. They allocate memory, so the per-epoch path
/// must not use them.

#include <Eigen/Core>

namespace piste {

/// Solves A x = b for x by A = Pᵀ L D Lᵀ P (Golub and Van Loan 2013, Matrix Computations, section 4.2.8). Only the
/// lower triangle of A is read. @pre A is symmetric and positive or negative semidefinite, b has as many rows.
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
/// The same for several right-hand sides: one column of X for each column of B.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// The least-squares solution: X for which each column of A X − B is shortest. By Householder's A = Q R without
/// pivoting.
/// @pre A has full column rank, and as many rows as B.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// A⁻¹ by L U with partial pivoting. @pre A is square and regular.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& A);

/// A = U diag(values) Vᵀ with orthogonal U and V. The largest value comes first.
struct SingularValues {
  Eigen::MatrixXd U;
  Eigen::VectorXd values;
  Eigen::MatrixXd V;
};

/// By two-sided Jacobi rotations, which find small values to full relative precision. @pre A is square.
SingularValues singular_values(const Eigen::MatrixXd& A);

/// Eigenvalues, the smallest first, and the eigenvector of each as a column of `vectors`.
struct Eigensystem {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// A V = V diag(values), Vᵀ V = 1. Only the lower triangle of A is read. @pre A is symmetric.
Eigensystem eigensystem(const Eigen::MatrixXd& A);

/// A V = B V diag(values), Vᵀ B V = 1. Only the lower triangles are read.
/// @pre A is symmetric, B symmetric and positive definite.
Eigensystem eigensystem(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

}  // namespace piste
