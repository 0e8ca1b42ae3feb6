#include "piste/model/known_errors.h"

#include <Eigen/LU>

namespace piste {
namespace {

constexpr int kMostSteps = 20;        // of Newton's method, each of which doubles the number of right digits
constexpr double kConverged = 1e-15;  // size of the last step relative to signal and bias

Vector3d true_signal(const Vector3d& measured, const KnownTriadErrors& e) {
  const double enough = kConverged * (measured.norm() + e.bias.norm());
  Vector3d x = measured - e.bias;
  for (int i = 0; i < kMostSteps; ++i) {
    const Vector3d made =
        x + e.gain * x + e.bias + x.cwiseProduct(x.cwiseProduct(e.quadratic + e.cubic.cwiseProduct(x)));
    Matrix3d slope = Matrix3d::Identity() + e.gain;
    slope.diagonal() += x.cwiseProduct(2 * e.quadratic + 3 * e.cubic.cwiseProduct(x));
    const Vector3d step = slope.inverse() * (measured - made);
    x += step;
    if (step.norm() <= enough) break;
  }
  return x;
}

}  // namespace

ImuSample corrected(const ImuSample& measured, const KnownErrors& errors) {
  ImuSample out = measured;
  const double dt = measured.interval;
  const Vector3d f = true_signal(measured.dvel / dt, errors.accel);
  out.dvel = dt * f;
  out.dtheta = dt * true_signal(measured.dtheta / dt - errors.g_sensitivity * f, errors.gyro);
  return out;
}

}  // namespace piste
