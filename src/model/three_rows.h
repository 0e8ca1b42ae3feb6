#pragma once
// Three rows of a product of which most factors are known to be zero.

#include <array>
#include <cstddef>

namespace piste {

// Three rows of M × inputs, over the first n columns of these. `columns`: those of M.
template <std::size_t N, std::size_t Padded>
[[gnu::always_inline]] inline void three_rows(const double* const* columns, int row, const std::array<int, N>& depends,
                                              const double* const* in, std::ptrdiff_t n, double (*out)[Padded]) {
  double w[3][N];
  for (int i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < N; ++k) w[i][k] = columns[depends[k]][row + i];
  }
  // The compiler need not fear that the rows written are among those read.
  const double* x[N];
  for (std::size_t k = 0; k < N; ++k) x[k] = in[depends[k]];
  double* __restrict first = out[row], * __restrict second = out[row + 1], * __restrict third = out[row + 2];
  for (std::ptrdiff_t r = 0; r < n; ++r) {
    double a = w[0][0] * x[0][r], b = w[1][0] * x[0][r], c = w[2][0] * x[0][r];
    for (std::size_t k = 1; k < N; ++k) {
      a += w[0][k] * x[k][r];
      b += w[1][k] * x[k][r];
      c += w[2][k] * x[k][r];
    }
    first[r] = a;
    second[r] = b;
    third[r] = c;
  }
}

}  // namespace piste
