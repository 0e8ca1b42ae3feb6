#include "math/square.h"

#include <Eigen/LU>

#include "math/wide.h"

namespace piste {
namespace {

PISTE_WIDE void multiply_square(const double* __restrict A, const double* __restrict B, std::ptrdiff_t n,
                                double* __restrict out) {
  for (std::ptrdiff_t j = 0; j < n; ++j) {
    double* __restrict column = out + j * n;
    for (std::ptrdiff_t i = 0; i < n; ++i) column[i] = 0;
    for (std::ptrdiff_t k = 0; k < n; ++k) {
      for (std::ptrdiff_t i = 0; i < n; ++i) column[i] += A[n * k + i] * B[n * j + k];
    }
  }
}

PISTE_WIDE void eliminate_wide(double* C, std::ptrdiff_t size, std::ptrdiff_t count) {
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const double* __restrict pivot = C + k * size;
    if (!(pivot[k] > 0)) continue;  // known exactly
    const double inverse = 1 / pivot[k];
    for (std::ptrdiff_t j = k + 1; j < size; ++j) {
      double* __restrict column = C + j * size;
      const double factor = pivot[j] * inverse;
      for (std::ptrdiff_t i = j; i < size; ++i) column[i] -= factor * pivot[i];
    }
  }
}

}  // namespace

Square product(const Square& A, const Square& B) {
  Square out(A.rows(), A.rows());
  multiply_square(A.data(), B.data(), A.rows(), out.data());
  return out;
}

void recur(Square& X, Square A, Square added, int n) {
  for (;; A = product(A, A)) {
    if (n % 2 == 1) X = symmetric(turned(A, X) + added);
    if ((n /= 2) == 0) return;
    added = symmetric(added + turned(A, added));
  }
}

void hold(Square& all, int first) {
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 30, 3>;
  const Columns with = all.middleCols<3>(first);
  const Eigen::Matrix3d own = with.middleRows<3>(first);
  const Columns weighted = with.lazyProduct(own.inverse());
  all -= weighted.lazyProduct(with.transpose());
  all.middleCols<3>(first).setZero();
  all.middleRows<3>(first).setZero();
  all.block<3, 3>(first, first) = own;
}

void eliminate_first(double* C, std::ptrdiff_t size, std::ptrdiff_t count) { eliminate_wide(C, size, count); }

}  // namespace piste
