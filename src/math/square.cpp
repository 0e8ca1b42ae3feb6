#include "math/square.h"

#include <Eigen/LU>
#include <algorithm>

#include "math/four.h"

namespace piste {
namespace {

// 4 R rows and C columns of A B, from `row` and `column` on, for matrices of n rows.
template <int R, int C>
PISTE_INSIDE void tile_of_product(const double* A, const double* B, std::ptrdiff_t row, std::ptrdiff_t column,
                                  std::ptrdiff_t n, double* out) {
  Four sum[C][R] = {};
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    const double* a = A + k * n + row;
    for (int i = 0; i < R; ++i) {
      Four four;
      load(a + std::ptrdiff_t{4} * i, four);
      for (int j = 0; j < C; ++j) sum[j][i] += four * B[(column + j) * n + k];
    }
  }
  for (int j = 0; j < C; ++j) {
    for (int i = 0; i < R; ++i) store(sum[j][i], out + (column + j) * n + row + std::ptrdiff_t{4} * i);
  }
}

template <int C>
PISTE_INSIDE void columns_of_product(const double* A, const double* B, std::ptrdiff_t column, std::ptrdiff_t n,
                                     double* out) {
  std::ptrdiff_t row = 0;
  for (; row + 8 <= n; row += 8) tile_of_product<2, C>(A, B, row, column, n, out);
  // The last four rows, some of them again, to the same bits.
  for (; row < n; row += 4) tile_of_product<1, C>(A, B, std::min(row, n - 4), column, n, out);
}

PISTE_WIDE void multiply_square(const double* A, const double* B, std::ptrdiff_t n, double* out) {
  std::ptrdiff_t column = 0;
  for (; column + 3 <= n; column += 3) columns_of_product<3>(A, B, column, n, out);
  for (; column < n; ++column) columns_of_product<1>(A, B, column, n, out);
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

void multiply(const double* A, const double* B, std::ptrdiff_t n, double* out) { multiply_square(A, B, n, out); }

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
