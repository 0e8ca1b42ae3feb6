#include "math/blocks.h"

#include <algorithm>
#include <cmath>

#include "math/four.h"

namespace piste {
namespace {

using Index = std::ptrdiff_t;

// C ← kept C + factor A B for 4 R rows and N columns.
template <int R, int N>
PISTE_INSIDE void multiply_tile(double factor, const Factors& of, bool kept, double* C, Index stride_C) {
  Four sum[N][R] = {};
  for (Index k = 0; k < of.inner; ++k) {
    const double* const b = of.B + k * of.row;
    for (int i = 0; i < R; ++i) {
      Four a;
      load(of.A + k * of.stride + Index{4} * i, a);
      for (int j = 0; j < N; ++j) sum[j][i] += a * b[j * of.column];
    }
  }
  for (int j = 0; j < N; ++j) {
    for (int i = 0; i < R; ++i) {
      double* const to = C + j * stride_C + Index{4} * i;
      Four all = {};
      if (kept) load(to, all);
      all += factor * sum[j][i];
      store(all, to);
    }
  }
}

template <int R>
PISTE_INSIDE void multiply_rows(double factor, Factors of, bool kept, double* C, Index stride_C, Index columns) {
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

// The update by a pivot of N columns of the same group: rest ← rest − column (column_j / pivot).
template <int N>
PISTE_INSIDE void sweep_columns(double over, const double* column, Index group, double* A, Index stride) {
  double factor[N];
  for (int j = 0; j < N; ++j) factor[j] = column[group + j] * over;
  for (Index i = group; i < stride; i += 4) {
    Four part;
    load(column + i, part);
    for (int j = 0; j < N; ++j) {
      double* const to = A + (group + j) * stride + i;
      Four rest;
      load(to, rest);
      rest -= part * factor[j];
      store(rest, to);
    }
  }
}

// Of A the groups of rows from the diagonal on, times `sign` and the scales of row and column.
PISTE_INSIDE void scale_both(double sign, const double* scale, double* A, Index n, Index stride) {
  for (Index j = 0; j < n; ++j) {
    for (Index i = j / 4 * 4; i < stride; i += 4) {
      double* const to = A + j * stride + i;
      Four rest, part;
      load(to, rest);
      load(scale + i, part);
      rest *= sign * (part * scale[j]);
      store(rest, to);
    }
  }
}

// The sweep operator on every row in turn (Goodnight 1979, The American Statistician 33): A becomes −A⁻¹, scaled. Of A
// the groups of rows from the diagonal on are read. `scale` and `column`: zeros, work space. Pivots are conditional
// variances given all rows before; the matrix is scaled so that its diagonal is 1.
PISTE_WIDE bool invert_padded(double* A, Index n, Index stride, double* scale, double* column) {
  constexpr double kNothing = 1e-15;
  for (Index i = 0; i < n; ++i) {
    scale[i] = 1 / std::sqrt(A[i * stride + i]);
    if (!std::isfinite(scale[i])) return false;
  }
  scale_both(1, scale, A, n, stride);
  for (Index k = 0; k < n; ++k) {
    double* const pivot_column = A + k * stride;
    const double pivot = pivot_column[k];
    if (!(pivot > kNothing)) return false;
    const double over = 1 / pivot;
    for (Index i = 0; i < k; ++i) column[i] = A[i * stride + k];
    column[k] = 0;  // so its own column stays
    for (Index i = k + 1; i < stride; ++i) column[i] = pivot_column[i];
    Index group = 0;
    for (; group + 4 <= n; group += 4) sweep_columns<4>(over, column, group, A, stride);
    if (n - group == 3) sweep_columns<3>(over, column, group, A, stride);
    if (n - group == 2) sweep_columns<2>(over, column, group, A, stride);
    if (n - group == 1) sweep_columns<1>(over, column, group, A, stride);
    for (Index i = 0; i < k; ++i) A[i * stride + k] = column[i] * over;
    for (Index i = k + 1; i < n; ++i) pivot_column[i] = column[i] * over;
    pivot_column[k] = -over;
  }
  scale_both(-1, scale, A, n, stride);
  for (Index j = 0; j < n; ++j) {
    for (Index i = j + 1; i < n; ++i) A[i * stride + j] = A[j * stride + i];
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
  alignas(32) double scale[kLargest] = {}, column[kLargest] = {};
  eigen_assert(stride <= kLargest);
  return invert_padded(A.data(), n, stride, scale, column);
}

}  // namespace piste
