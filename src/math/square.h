#pragma once
// Square matrices of up to thirty rows, without a heap.

#include <Eigen/Core>
#include <cstddef>

namespace piste {

using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 30, 30>;

/// A B. Eigen takes matrices of this size to be large, and packs them.
Square product(const Square& A, const Square& B);

/// Aᵀ X A
inline Square turned(const Square& A, const Square& X) { return product(A.transpose(), product(X, A)); }

inline Square symmetric(const Square& X) { return 0.5 * (X + X.transpose()); }

/// Does X ← Aᵀ X A + added n times, by doubling, for symmetric matrices.
void recur(Square& X, Square A, Square added, int n);

/// The covariance for a given value of the three states from `first` on, beside which theirs stays.
void hold(Square& all, int first);

/// Eliminates the first `count` rows of a symmetric matrix, of which the lower half is there.
void eliminate_first(double* C, std::ptrdiff_t size, std::ptrdiff_t count);

}  // namespace piste
