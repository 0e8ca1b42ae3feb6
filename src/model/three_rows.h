#pragma once
// Three rows of a product of which most factors are known to be zero, for functions that are PISTE_WIDE.

#include <array>
#include <cstddef>

#include "math/four.h"

namespace piste {

// 4 V numbers of each of the three rows, from `at` on.
template <std::size_t N, int V>
PISTE_INSIDE void three_tiles(const double (&weights)[N][3], const double* const (&inputs)[N], std::ptrdiff_t at,
                              double* out, std::ptrdiff_t stride) {
  Four a[V], b[V], c[V];
#pragma GCC unroll 16
  for (std::size_t k = 0; k < N; ++k) {
    const double u = weights[k][0], v = weights[k][1], w = weights[k][2];
    for (int i = 0; i < V; ++i) {
      Four x;
      load(inputs[k] + at + std::ptrdiff_t{4} * i, x);
      a[i] = k == 0 ? u * x : a[i] + u * x;
      b[i] = k == 0 ? v * x : b[i] + v * x;
      c[i] = k == 0 ? w * x : c[i] + w * x;
    }
  }
  for (int i = 0; i < V; ++i) {
    double* const to = out + at + std::ptrdiff_t{4} * i;
    store(a[i], to);
    store(b[i], to + stride);
    store(c[i], to + 2 * stride);
  }
}

// The rows from `row` on of M × inputs, over the first n columns of these, a multiple of four. `columns`: those of M.
// Rows of `out` are `stride` numbers apart.
template <std::size_t N>
PISTE_INSIDE void three_rows(const double* const* columns, int row, const std::array<int, N>& depends,
                             const double* const* in, std::ptrdiff_t n, double* out, std::ptrdiff_t stride) {
  double weights[N][3];
  const double* inputs[N];
  for (std::size_t k = 0; k < N; ++k) {
    inputs[k] = in[depends[k]];
    for (int i = 0; i < 3; ++i) weights[k][i] = columns[depends[k]][row + i];
  }
  out += row * stride;
  // Two at a time: each weight is then fetched half as often.
  std::ptrdiff_t at = 0;
  for (; at + 8 <= n; at += 8) three_tiles<N, 2>(weights, inputs, at, out, stride);
  if (at < n) three_tiles<N, 1>(weights, inputs, at, out, stride);
}

}  // namespace piste
