#include "piste/fit/known_errors_of.h"

namespace piste {
namespace {

KnownTriadErrors& triad_of(KnownErrors& errors, std::size_t axis) { return axis < 3 ? errors.accel : errors.gyro; }

KnownTriadErrors triad(const MatrixFit& fit) {
  KnownTriadErrors out;
  for (int k = 0; k < 3; ++k) {
    const Eigen::VectorXd& found = fit.axes[static_cast<std::size_t>(k)].regression.value;
    out.bias(k) = found(MatrixFit::kBias);
    out.gain.row(k) = found.segment<3>(MatrixFit::kGain);
  }
  return out;
}

}  // namespace

KnownErrors errors_of_lines(const std::array<std::optional<BiasScale>, 6>& lines) {
  KnownErrors out;
  for (std::size_t axis = 0; axis < lines.size(); ++axis) {
    if (!lines[axis]) continue;
    const auto k = static_cast<Eigen::Index>(axis % 3);
    triad_of(out, axis).bias(k) = lines[axis]->value(0);
    triad_of(out, axis).gain(k, k) = lines[axis]->value(1);
  }
  return out;
}

KnownErrors errors_of_polynomials(const std::array<std::optional<PolynomialFit>, 6>& polynomials) {
  KnownErrors out;
  for (std::size_t axis = 0; axis < polynomials.size(); ++axis) {
    if (!polynomials[axis]) continue;
    Eigen::Vector4d c = Eigen::Vector4d::Zero();
    c.head(polynomials[axis]->order + 1) = polynomials[axis]->coefficients.regression.value;
    const auto k = static_cast<Eigen::Index>(axis % 3);
    KnownTriadErrors& triad = triad_of(out, axis);
    triad.bias(k) = c(0);
    triad.gain(k, k) = c(1);
    triad.quadratic(k) = c(2);
    triad.cubic(k) = c(3);
  }
  return out;
}

KnownErrors errors_of_matrices(const std::optional<MatrixFit>& accel, const std::optional<MatrixFit>& gyro) {
  KnownErrors out;
  if (accel) out.accel = triad(*accel);
  if (gyro) out.gyro = triad(*gyro);
  if (gyro && gyro->has_g_sensitivity()) {
    for (int k = 0; k < 3; ++k) {
      const Coefficients& row = gyro->axes[static_cast<std::size_t>(k)];
      out.g_sensitivity.row(k) = row.regression.value.segment<3>(MatrixFit::kGSensitivity);
    }
  }
  return out;
}

}  // namespace piste
