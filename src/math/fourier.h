#pragma once
/// The discrete Fourier transform of real signals.

#include <complex>
#include <memory>
#include <vector>

namespace piste {

/// Transforms of any length. The factors of each length are kept, so that the next transform of that length is faster.
class FourierTransform {
 public:
  FourierTransform();
  ~FourierTransform();

  /// X_k = Σ_i x_i exp(−2π j i k / n), k = 0 … n − 1. Both halves are returned, although one is the conjugate of the
  /// other.
  std::vector<std::complex<double>> forward(const std::vector<double>& x);
  /// x_i = Re Σ_k X_k exp(2π j i k / n) / n: the inverse of `forward`.
  std::vector<double> inverse(const std::vector<std::complex<double>>& X);

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

}  // namespace piste
