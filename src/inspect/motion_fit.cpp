#include "motion_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "math/wahba.h"
#include "piste/math/earth.h"

namespace piste {
namespace {

constexpr double kNoise = 0.1, kLeverArm = 0.7;  // sigmas of the track [m/s] and of the lever arm [m] before the fit
const Vector3d kGravity(0, 0, kStandardGravity);

CarriedWindow carry(const MotionWindow& w, const Matrix3d& turn) {
  CarriedWindow out;
  Quaterniond q = Quaterniond::Identity();
  Vector3d u = Vector3d::Zero();
  for (std::size_t i = 0; i <= w.cells.size(); ++i) {
    if (i % kEvery == 0) {
      const Vector3d about = w.cells[std::min(i, w.cells.size() - 1)].angle + w.cells[i == 0 ? 0 : i - 1].angle;
      out.attitude.push_back(q);
      out.velocity.push_back(u);
      out.swing.emplace_back(q.toRotationMatrix() * skew(turn * about / (2 * kCell)));
    }
    if (i == w.cells.size()) break;
    const Quaterniond half = so3_exp(turn * w.cells[i].angle / 2);
    u += (q * half) * w.cells[i].velocity;
    q = (q * half * half).normalized();
  }
  return out;
}

Vector3d without_gravity(const MotionWindow& w, std::size_t k, bool gravity) {
  return gravity ? Vector3d(w.velocity[k] - static_cast<double>(k * kEvery) * kCell * kGravity) : w.velocity[k];
}

template <class T>
std::vector<T> without_mean(std::vector<T> values) {
  T mean = values.front();
  for (std::size_t k = 1; k < values.size(); ++k) mean += values[k];
  mean /= static_cast<double>(values.size());
  for (T& v : values) v -= mean;
  return values;
}

WindowFit scaled_wahba(const std::vector<Vector3d>& alpha, const std::vector<Vector3d>& beta, bool mirrored) {
  Matrix3d H = Matrix3d::Zero();
  double aa = 0, bb = 0;
  for (std::size_t k = 0; k < alpha.size(); ++k) {
    H += beta[k] * alpha[k].transpose();
    aa += alpha[k].squaredNorm();
    bb += beta[k].squaredNorm();
  }
  const WahbaSolution wahba = solve_wahba(H, mirrored);
  const double trace = wahba.alignment();
  return {wahba.R, aa > 0 ? trace / aa : 0,
          (bb - (aa > 0 ? trace * trace / aa : 0)) / static_cast<double>(alpha.size())};
}

}  // namespace

std::vector<CarriedWindow> carry_all(const std::vector<MotionWindow>& windows, const Matrix3d& turn) {
  std::vector<CarriedWindow> carried;
  carried.reserve(windows.size());
  for (const MotionWindow& w : windows) carried.push_back(carry(w, turn));
  return carried;
}

JointFit fit_all(const std::vector<MotionWindow>& windows, const std::vector<CarriedWindow>& carried, bool gravity,
                 bool mirrored) {
  JointFit joint;
  joint.fits.resize(windows.size());
  Matrix3d N = Matrix3d::Identity() * (kNoise * kNoise / kLeverArm / kLeverArm);
  Vector3d n = Vector3d::Zero();
  std::vector<std::vector<Vector3d>> alpha(windows.size()), beta(windows.size());
  for (std::size_t i = 0; i < windows.size(); ++i) {
    for (std::size_t k = 0; k < windows[i].velocity.size(); ++k) {
      beta[i].push_back(without_gravity(windows[i], k, gravity));
    }
    beta[i] = without_mean(std::move(beta[i]));
    alpha[i] = without_mean(carried[i].velocity);
    const WindowFit& fit = joint.fits[i] = scaled_wahba(alpha[i], beta[i], mirrored);
    const std::vector<Matrix3d> swing = without_mean(carried[i].swing);
    for (std::size_t k = 0; k < swing.size(); ++k) {
      const Matrix3d J = fit.R * swing[k];
      N += J.transpose() * J;
      n += J.transpose() * (beta[i][k] - fit.scale * (fit.R * alpha[i][k]));
    }
  }
  joint.lever_arm = N.ldlt().solve(n);
  for (std::size_t i = 0; i < windows.size(); ++i) {
    // α with the antenna's velocity due to the lever arm, in the unit of the forces.
    const double scale = joint.fits[i].scale;
    if (scale == 0) continue;
    const std::vector<Matrix3d> swing = without_mean(carried[i].swing);
    for (std::size_t k = 0; k < swing.size(); ++k) alpha[i][k] += swing[k] * joint.lever_arm / scale;
    joint.fits[i] = scaled_wahba(alpha[i], beta[i], mirrored);
  }
  return joint;
}

}  // namespace piste
