#pragma once
// Three rows of a product of which most factors are known to be zero, for functions that are PISTE_WIDE.

#include <array>
#include <cstddef>

#include "math/four.h"

namespace piste {

// 4 V numbers of each of the three rows, from `at` on. `columns`: those of M.
template <std::size_t N, int V>
PISTE_INSIDE void three_tiles(const double* const* columns, int row, const std::array<int, N>& depends,
                              const double* const* in, std::ptrdiff_t at, double* out, std::ptrdiff_t stride) {
  Four a[V], b[V], c[V];
  {
    const double *const weights = columns[depends[0]] + row, *const input = in[depends[0]] + at;
    for (int i = 0; i < V; ++i) {
      Four x;
      load(input + std::ptrdiff_t{4} * i, x);
      a[i] = weights[0] * x;
      b[i] = weights[1] * x;
      c[i] = weights[2] * x;
    }
  }
#pragma GCC unroll 1
  for (std::size_t k = 1; k < N; ++k) {
    const double *const weights = columns[depends[k]] + row, *const input = in[depends[k]] + at;
    const double u = weights[0], v = weights[1], w = weights[2];
    for (int i = 0; i < V; ++i) {
      Four x;
      load(input + std::ptrdiff_t{4} * i, x);
      a[i] += u * x;
      b[i] += v * x;
      c[i] += w * x;
    }
  }
  for (int i = 0; i < V; ++i) {
    double* const to = out + at + std::ptrdiff_t{4} * i;
    store(a[i], to);
    store(b[i], to + stride);
    store(c[i], to + 2 * stride);
  }
}

// The rows from `row` on of M × inputs, over the first n columns of these, a multiple of four. Rows of `out` are
// `stride` numbers apart.
template <std::size_t N>
PISTE_INSIDE void three_rows(const double* const* columns, int row, const std::array<int, N>& depends,
                             const double* const* in, std::ptrdiff_t n, double* out, std::ptrdiff_t stride) {
  out += row * stride;
  // As many at a time as there are registers: each weight is then fetched seldom.
  std::ptrdiff_t at = 0;
  for (; at + 16 <= n; at += 16) three_tiles<N, 4>(columns, row, depends, in, at, out, stride);
  switch (n - at) {
    case 12:
      return three_tiles<N, 3>(columns, row, depends, in, at, out, stride);
    case 8:
      return three_tiles<N, 2>(columns, row, depends, in, at, out, stride);
    case 4:
      return three_tiles<N, 1>(columns, row, depends, in, at, out, stride);
    default:
      return;
  }
}

}  // namespace piste
