#include "motion_match.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "piste/math/earth.h"
#include "piste/math/statistics.h"
#include "signed_permutations.h"

namespace piste {
namespace {

constexpr double kCell = 0.04, kWindow = 8, kStride = 4;  // s
constexpr std::size_t kEvery = 6;                         // cells between looks at the track
constexpr std::size_t kMost = 40, kFewest = 4;            // windows
constexpr double kMotion = 0.7;                           // m/s that the velocity must change by in a window, rms
constexpr double kForward = 1.5;                          // m/s from which a track has a direction
constexpr double kFloor = 0.05;                           // m/s: what the velocities may be wrong by
constexpr double kFarBetter = 2.0, kAsGood = 1.25;        // ratios of mean squares
constexpr double kNearlyAll = 0.8;
constexpr double kExplained = 0.35;  // rms of what is left, in parts of the change of velocity
const Vector3d kGravity(0, 0, kStandardGravity);

// One stretch: the IMU in cells, and the track at every kEvery-th of their ends, the first at the beginning.
struct Window {
  std::vector<ImuIntegral::Value> cells;
  std::vector<Vector3d> velocity;
  double change = 0;  // rms of the velocity about its mean
};

std::optional<Window> window_at(const ImuIntegral& imu, const Track& track, double begin, double offset,
                                const Vector3d& bias) {
  const auto cells = static_cast<std::size_t>(std::lround(kWindow / kCell));
  if (!imu.covers(begin + offset, begin + offset + kWindow)) return std::nullopt;
  Window w;
  ImuIntegral::Value before = imu.at(begin + offset);
  Vector3d mean = Vector3d::Zero();
  for (std::size_t i = 0; i <= cells; ++i) {
    const double t = begin + static_cast<double>(i) * kCell;
    if (i > 0) {
      const ImuIntegral::Value now = imu.at(t + offset);
      w.cells.push_back({now.angle - before.angle - kCell * bias, now.velocity - before.velocity});
      before = now;
    }
    if (i % kEvery != 0) continue;
    const auto v = track.velocity(t);
    if (!v) return std::nullopt;
    w.velocity.push_back(*v);
    mean += *v;
  }
  mean /= static_cast<double>(w.velocity.size());
  for (const Vector3d& v : w.velocity) w.change += (v - mean).squaredNorm();
  w.change = std::sqrt(w.change / static_cast<double>(w.velocity.size()));
  if (w.change < kMotion) return std::nullopt;
  return w;
}

// The gyroscopes' mean at rest; without rest their median, as most of a journey does not turn.
Vector3d gyro_bias(const ImuIntegral& imu, const std::vector<Interval>& rest, double offset) {
  Vector3d angle = Vector3d::Zero();
  double time = 0;
  for (const Interval& r : rest) {
    const double begin = r.start + offset, end = r.end + offset;
    if (!imu.covers(begin, end)) continue;
    angle += imu.at(end).angle - imu.at(begin).angle;
    time += end - begin;
  }
  if (time > 5) return angle / time;
  std::array<std::vector<double>, 3> rates;
  for (double t = imu.start(); t + 1 < imu.end(); t += 1) {
    const Vector3d rate = imu.at(t + 1).angle - imu.at(t).angle;
    for (std::size_t axis = 0; axis < 3; ++axis) rates[axis].push_back(rate(static_cast<Eigen::Index>(axis)));
  }
  if (rates[0].empty()) return Vector3d::Zero();
  return {median(rates[0]), median(rates[1]), median(rates[2])};
}

// The forces carried to the window's start by the gyroscopes times `turn`, and the attitudes on the way.
struct Carried {
  std::vector<Quaterniond> attitude;
  std::vector<Vector3d> velocity;
};

Carried carry(const Window& w, const Matrix3d& turn) {
  Carried out;
  Quaterniond q = Quaterniond::Identity();
  Vector3d u = Vector3d::Zero();
  for (std::size_t i = 0; i <= w.cells.size(); ++i) {
    if (i % kEvery == 0) {
      out.attitude.push_back(q);
      out.velocity.push_back(u);
    }
    if (i == w.cells.size()) break;
    const Quaterniond half = so3_exp(turn * w.cells[i].angle / 2);
    u += (q * half) * w.cells[i].velocity;
    q = (q * half * half).normalized();
  }
  return out;
}

// Wahba's problem with a free scale, for both signs of the determinant.
struct Fit {
  Matrix3d R;
  double scale = 0, mean_square = 0;
};

std::array<Fit, 2> fits(const Window& w, const Carried& carried, bool gravity) {
  const std::size_t n = w.velocity.size();
  std::vector<Vector3d> beta(n);
  Vector3d mean_alpha = Vector3d::Zero(), mean_beta = Vector3d::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    beta[k] = w.velocity[k];
    if (gravity) beta[k] -= static_cast<double>(k * kEvery) * kCell * kGravity;
    mean_alpha += carried.velocity[k] / static_cast<double>(n);
    mean_beta += beta[k] / static_cast<double>(n);
  }
  Matrix3d H = Matrix3d::Zero();
  double aa = 0, bb = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const Vector3d a = carried.velocity[k] - mean_alpha, b = beta[k] - mean_beta;
    H += b * a.transpose();
    aa += a.squaredNorm();
    bb += b.squaredNorm();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() > 0 ? 1 : -1;
  std::array<Fit, 2> out;
  for (std::size_t mirrored = 0; mirrored < 2; ++mirrored) {
    const Vector3d D(1, 1, mirrored != 0 ? -sign : sign);
    const double trace = svd.singularValues().dot(D);
    out[mirrored].R = svd.matrixU() * D.asDiagonal() * svd.matrixV().transpose();
    out[mirrored].scale = aa > 0 ? trace / aa : 0;
    out[mirrored].mean_square = (bb - (aa > 0 ? trace * trace / aa : 0)) / static_cast<double>(n);
  }
  return out;
}

// A reading of the labels, what it leaves in each window, and how far it is from the labels' own.
struct Reading {
  double factor = 1;
  Matrix3d axes = Matrix3d::Identity();
  bool mirrored = false, gravity = true;
  int oddity = 0;
  std::vector<double> left;  // mean square, a window each

  double mean_log() const {
    double sum = 0;
    for (const double l : left) sum += std::log(l + kFloor * kFloor);
    return sum / static_cast<double>(left.size());
  }
};

int oddity_of(const Matrix3d& axes, bool mirrored) {
  if (axes.isIdentity()) return mirrored ? 2 : 0;
  if ((-axes).isIdentity()) return mirrored ? 1 : 3;
  if (mirrored) return 7;
  if (axes.isDiagonal()) return axes.trace() == 1 ? 3 : 5;
  const bool swap = axes.isApprox(axes.transpose()) && axes.minCoeff() == 0;
  return swap ? 4 : 6;
}

std::vector<Reading> read_all_ways(const std::vector<Window>& windows, const std::vector<double>& factors) {
  std::vector<Reading> all;
  for (const double factor : factors) {
    for (const Matrix3d& axes : signed_permutations()) {
      std::array<Reading, 4> four;
      for (std::size_t i = 0; i < 4; ++i) {
        const bool mirrored = i % 2 != 0, gravity = i < 2;
        four[i] = {
            factor, axes, mirrored, gravity, oddity_of(axes, mirrored) + (factor == 1 ? 0 : 1) + (gravity ? 0 : 1), {}};
      }
      for (const Window& w : windows) {
        const Carried carried = carry(w, factor * axes);
        const auto with = fits(w, carried, true), without = fits(w, carried, false);
        for (std::size_t i = 0; i < 4; ++i) four[i].left.push_back((i < 2 ? with : without)[i % 2].mean_square);
      }
      for (Reading& r : four) all.push_back(std::move(r));
    }
  }
  return all;
}

bool far_better(const Reading& one, const Reading& other) {
  std::size_t better = 0;
  for (std::size_t w = 0; w < one.left.size(); ++w) better += one.left[w] < other.left[w] ? 1 : 0;
  return other.mean_log() - one.mean_log() > std::log(kFarBetter) &&
         static_cast<double>(better) >= kNearlyAll * static_cast<double>(one.left.size());
}

double rms(const Reading& r) {
  double sum = 0;
  for (const double l : r.left) sum += l;
  return std::sqrt(sum / static_cast<double>(r.left.size()));
}

std::string text_of(const Matrix3d& R_bs) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    Eigen::Index axis = 0;
    R_bs.row(row).cwiseAbs().maxCoeff(&axis);
    if (row > 0) text += ' ';
    text += R_bs(row, axis) > 0 ? '+' : '-';
    text += static_cast<char>('x' + axis);
  }
  return text;
}

// The signed permutation that is nearest to the directions forward, right and down, as the sensor's axes have them.
void name_axes(const std::vector<Window>& windows, const Reading& reading, MotionMatch& match) {
  Matrix3d sum = Matrix3d::Zero();  // of R_bs over time
  std::vector<double> scales;
  for (const Window& w : windows) {
    const Carried carried = carry(w, reading.factor * reading.axes);
    const Fit fit = fits(w, carried, reading.gravity)[reading.mirrored ? 1 : 0];
    scales.push_back(fit.scale);
    for (std::size_t k = 0; k < w.velocity.size(); ++k) {
      const double speed = w.velocity[k].head<2>().norm();
      if (speed < kForward) continue;
      Matrix3d R_wh = Matrix3d::Identity();  // along the track
      R_wh.topLeftCorner<2, 2>() << w.velocity[k].x(), -w.velocity[k].y(), w.velocity[k].y(), w.velocity[k].x();
      R_wh.topLeftCorner<2, 2>() /= speed;
      sum += R_wh.transpose() * fit.R * carried.attitude[k];
    }
  }
  match.accel_factor = median(scales);
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d mean = svd.matrixU() * svd.matrixV().transpose();
  double best = -4, second = -4;
  for (const Matrix3d& R_bs : signed_permutations()) {
    if ((R_bs.determinant() < 0) != reading.mirrored) continue;
    const double fit = R_bs.cwiseProduct(mean).sum();
    if (fit > best) {
      second = best;
      best = fit;
      match.R_bs = R_bs;
    } else {
      second = std::max(second, fit);
    }
  }
  const auto angle = [](double trace) { return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0)); };
  match.tilt = angle(best);
  match.margin = angle(second) - match.tilt;
  match.axes = text_of(match.R_bs);
}

}  // namespace

std::optional<MotionMatch> match_motion(const ImuIntegral& imu, bool increments, const Track& track,
                                        const std::vector<Interval>& rest, double offset) {
  if (track.empty()) return std::nullopt;
  const Vector3d bias = gyro_bias(imu, rest, offset);
  std::vector<Window> windows;
  const double begin = std::max(track.start(), imu.start() - offset), end = std::min(track.end(), imu.end() - offset);
  for (double t = begin; t + kWindow < end; t += kStride) {
    if (auto w = window_at(imu, track, t, offset, bias)) windows.push_back(std::move(*w));
  }
  if (windows.size() < kFewest) return std::nullopt;
  if (windows.size() > kMost) {  // spread over the log
    std::vector<Window> some;
    some.reserve(kMost);
    for (std::size_t i = 0; i < kMost; ++i) some.push_back(std::move(windows[i * windows.size() / kMost]));
    windows = std::move(some);
  }

  constexpr double kDegrees = 180 / std::numbers::pi;
  const double interval = imu.interval();
  const std::vector<Reading> all =
      read_all_ways(windows, {1, 1 / kDegrees, kDegrees, increments ? interval : 1 / interval});
  const Reading& as_given = all.front();
  const Reading* chosen = &as_given;
  const Reading& best = *std::min_element(
      all.begin(), all.end(), [](const Reading& a, const Reading& b) { return a.mean_log() < b.mean_log(); });
  if (far_better(best, as_given)) {
    chosen = &best;
    for (const Reading& r : all) {
      const bool as_good = r.mean_log() - best.mean_log() < std::log(kAsGood);
      if (as_good && r.oddity < chosen->oddity) chosen = &r;
    }
  }
  double change = 0;
  for (const Window& w : windows) change += w.change * w.change / static_cast<double>(windows.size());
  if (rms(*chosen) > kExplained * std::sqrt(change)) return std::nullopt;

  MotionMatch match;
  match.gyro_factor = chosen->factor;
  match.gyro_axes = chosen->axes;
  match.mirrored = chosen->mirrored;
  match.gravity = chosen->gravity;
  match.residual = rms(*chosen);
  match.residual_as_given = rms(as_given);
  match.windows = windows.size();
  name_axes(windows, *chosen, match);
  return match;
}

}  // namespace piste
