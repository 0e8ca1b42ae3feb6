#include "math/fourier.h"

#include <unsupported/Eigen/FFT>

namespace piste {

struct FourierTransform::Factors {
  Eigen::FFT<double> fft;
};

FourierTransform::FourierTransform() : factors_(std::make_unique<Factors>()) {}

FourierTransform::~FourierTransform() = default;

std::vector<std::complex<double>> FourierTransform::forward(const std::vector<double>& x) {
  std::vector<std::complex<double>> X;
  factors_->fft.fwd(X, x);
  return X;
}

std::vector<double> FourierTransform::inverse(const std::vector<std::complex<double>>& X) {
  std::vector<double> x;
  factors_->fft.inv(x, X);
  return x;
}

}  // namespace piste
