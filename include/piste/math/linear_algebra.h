#pragma once
/// Decompositions of matrices whose size is known at run time, as plain functions: Eigen compiles each of them for
/// seconds wherever it is written out, and here once. Not for the per-epoch path: they allocate.

#include <Eigen/Core>

namespace piste {

/// x of A x = b, by A = Pᵀ L D Lᵀ P (Golub and Van Loan 2013, Matrix Computations, section 4.2.8). Only the lower
/// triangle of A is read. @pre A is symmetric and positive or negative semidefinite, b has as many rows.
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
/// A column of X for each column of B.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// X that makes each column of A X − B shortest, by Householder's A = Q R without pivoting.
/// @pre A has full column rank, and as many rows as B.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// A⁻¹ by L U with partial pivoting. @pre A is square and regular.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& A);

/// A = U diag(values) Vᵀ with orthogonal U and V; the values fall.
struct SingularValues {
  Eigen::MatrixXd U;
  Eigen::VectorXd values;
  Eigen::MatrixXd V;
};

/// By two-sided Jacobi rotations, which find small values to full relative precision. @pre A is square.
SingularValues singular_values(const Eigen::MatrixXd& A);

/// Eigenvalues, which rise, and a column of `vectors` for each.
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
