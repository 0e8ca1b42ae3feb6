#include "math/blocks.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "math/wide.h"

namespace piste {
namespace {

using Index = std::ptrdiff_t;
using FourRows = double __attribute__((vector_size(4 * sizeof(double))));

// C ← kept C + factor A B for 4 R rows and N columns.
template <int R, int N>
[[gnu::always_inline]] inline void multiply_tile(double factor, const Factors& of, bool kept, double* C,
                                                 Index stride_C) {
  FourRows sum[N][R] = {};
  for (Index k = 0; k < of.inner; ++k) {
    const double* const b = of.B + k * of.row;
    for (int i = 0; i < R; ++i) {
      FourRows a;
      std::memcpy(&a, of.A + k * of.stride + Index{4} * i, sizeof a);
      for (int j = 0; j < N; ++j) sum[j][i] += a * b[j * of.column];
    }
  }
  for (int j = 0; j < N; ++j) {
    for (int i = 0; i < R; ++i) {
      double* const to = C + j * stride_C + Index{4} * i;
      FourRows all = {};
      if (kept) std::memcpy(&all, to, sizeof all);
      all += factor * sum[j][i];
      std::memcpy(to, &all, sizeof all);
    }
  }
}

template <int R>
[[gnu::always_inline]] inline void multiply_rows(double factor, Factors of, bool kept, double* C, Index stride_C,
                                                 Index columns) {
  constexpr int kTogether = 4;
  Index j = 0;
  for (; j + kTogether <= columns; j += kTogether) {
    multiply_tile<R, kTogether>(factor, of, kept, C, stride_C);
    of.B += kTogether * of.column;
    C += kTogether * stride_C;
  }
  switch (columns - j) {
    case 3:
      return multiply_tile<R, 3>(factor, of, kept, C, stride_C);
    case 2:
      return multiply_tile<R, 2>(factor, of, kept, C, stride_C);
    case 1:
      return multiply_tile<R, 1>(factor, of, kept, C, stride_C);
    default:
      return;
  }
}

PISTE_WIDE void multiply_padded(double factor, Factors of, bool kept, bool lower, double* C, Index stride_C,
                                Index columns) {
  const auto until = [&](Index end_of_rows) { return lower ? std::min(columns, end_of_rows) : columns; };
  Index row = 0;
  for (; row + 8 <= stride_C; row += 8, of.A += 8) {
    multiply_rows<2>(factor, of, kept, C + row, stride_C, until(row + 8));
  }
  if (row < stride_C) multiply_rows<1>(factor, of, kept, C + row, stride_C, until(row + 4));
}

// The sweep operator on every row in turn (Goodnight 1979, The American Statistician 33): A becomes −A⁻¹. Of A the
// groups of rows from the diagonal on are read and written. `column`: room for one. Pivots are variances given all rows
// before, of which the first are one.
PISTE_WIDE bool sweep(double* A, Index n, Index stride, double* column) {
  constexpr double kNothing = 1e-15;
  for (Index k = 0; k < n; ++k) {
    double* const pivot_column = A + k * stride;
    const double pivot = pivot_column[k];
    if (!(pivot > kNothing)) return false;
    const double over = 1 / pivot;
    for (Index i = 0; i < k; ++i) column[i] = A[i * stride + k];
    column[k] = 0;
    for (Index i = k + 1; i < stride; ++i) column[i] = pivot_column[i];
    for (Index j = 0; j < n; ++j) {
      if (j == k) continue;
      double* const to = A + j * stride;
      const double factor = column[j] * over;
      for (Index i = j / 4 * 4; i < stride; i += 4) {
        FourRows rest, part;
        std::memcpy(&rest, to + i, sizeof rest);
        std::memcpy(&part, column + i, sizeof part);
        rest -= part * factor;
        std::memcpy(to + i, &rest, sizeof rest);
      }
      if (j < k) to[k] = factor;
    }
    for (Index i = k + 1; i < n; ++i) pivot_column[i] = column[i] * over;
    pivot_column[k] = -over;
  }
  return true;
}

}  // namespace

void multiply(double factor, const Factors& of, bool kept, bool lower, Blocks::View C) {
  multiply_padded(factor, of, kept, lower, C.data(), C.outerStride(), C.cols());
}

bool invert_definite(Blocks::View A) {
  constexpr Index kLargest = 128;
  const Index n = A.rows(), stride = A.outerStride();
  alignas(32) double scale[kLargest], column[kLargest];
  eigen_assert(stride <= kLargest);
  for (Index i = 0; i < n; ++i) {
    scale[i] = 1 / std::sqrt(A(i, i));
    if (!std::isfinite(scale[i])) return false;
  }
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i) A(i, j) *= scale[i] * scale[j];
  }
  if (!sweep(A.data(), n, stride, column)) return false;
  for (Index j = 0; j < n; ++j) {
    A(j, j) *= -(scale[j] * scale[j]);
    for (Index i = j + 1; i < n; ++i) A(i, j) = A(j, i) = -A(i, j) * (scale[i] * scale[j]);
  }
  return true;
}

}  // namespace piste
