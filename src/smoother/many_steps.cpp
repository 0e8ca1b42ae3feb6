#include "smoother/many_steps.h"

#include "math/wide.h"
#include "model/step_operator.h"

namespace piste {

PISTE_WIDE void apply_transposed(const ManySteps& Phi, const double* in, std::ptrdiff_t n, std::ptrdiff_t columns,
                                 double* out) {
  for (std::ptrdiff_t c = 0; c < columns; ++c, in += n, out += n) {
    double sum[kMostStates];
    for (std::ptrdiff_t r = 0; r < n; ++r) sum[r] = Phi.decay[r] * in[r];
    for (int i = 0; i < StepOperator::kNavigation; ++i) {
      for (std::ptrdiff_t r = 0; r < n; ++r) sum[r] += Phi.rows[i][r] * in[i];
    }
    for (std::ptrdiff_t r = 0; r < n; ++r) out[r] = sum[r];
  }
}

Covariance carried(const ManySteps& Phi, const Covariance& Lambda) {
  const Eigen::Index n = Lambda.rows();
  Covariance half(n, n), out(n, n);
  apply_transposed(Phi, Lambda.data(), n, n, half.data());  // Φᵀ Λ
  half.transposeInPlace();
  apply_transposed(Phi, half.data(), n, n, out.data());
  for (Eigen::Index j = 1; j < n; ++j) {
    for (Eigen::Index i = 0; i < j; ++i) out(i, j) = out(j, i) = 0.5 * (out(i, j) + out(j, i));
  }
  return out;
}

}  // namespace piste
