#pragma once
// Square matrices of some dozen rows, without a heap.

#include <Eigen/Core>
#include <cstddef>

namespace piste {

/// Up to thirty rows.
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 30, 30>;

/// out = A B, all of them with n rows and columns one after the other. @pre n ≥ 4, and out is neither A nor B
void multiply(const double* A, const double* B, std::ptrdiff_t n, double* out);

/// out = A B for square matrices of one size. Eigen treats matrices of some dozen rows as large, and packs them.
template <class Matrix>
void set_product(const Matrix& A, const Matrix& B, Matrix& out) {
  multiply(A.data(), B.data(), A.rows(), out.data());
}

/// The covariance conditioned on a given value of the three states from `first` on. Their own block stays.
void hold(Square& all, int first);

/// Eliminates the first `count` rows of a symmetric matrix, stored as its lower triangle.
void eliminate_first(double* C, std::ptrdiff_t size, std::ptrdiff_t count);

}  // namespace piste
