#include "motion_match.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "math/time.h"
#include "piste/math/earth.h"
#include "piste/math/statistics.h"
#include "signed_permutations.h"

namespace piste {
namespace {

constexpr double kCell = 0.04, kWindow = 5, kStride = 2.5;  // s
constexpr std::size_t kEvery = 6;                           // cells between looks at the track
constexpr std::size_t kMost = 40, kFewest = 5;              // windows
constexpr std::size_t kMostClipped = 2;                     // rows of a window
constexpr double kMotion = 0.7;                             // m/s that the velocity must change by in a window, rms
constexpr double kForward = 1.5;                            // m/s from which a track has a direction
constexpr double kNoise = 0.1, kLeverArm = 0.7;             // m/s of the track, m of the antenna: before it is fitted
constexpr double kFloor = 0.05;                             // m/s: what the velocities may be wrong by
constexpr double kFarBetter = 1.3, kAsGood = 1.2;           // ratios of mean squares
constexpr double kNearlyAll = 0.85;
constexpr double kClaim = 0.12;       // likewise, where it says something against the labels
constexpr double kTurnTolerance = 3;  // of the gyroscopes' turns against the track's
constexpr double kHalfWay = 10 * std::numbers::pi / 180;
constexpr double kExplained = 0.2;  // rms of what is left, in parts of the change of velocity
const Vector3d kGravity(0, 0, kStandardGravity);

// One stretch: the IMU in cells, and the track at every kEvery-th of their ends, the first at the beginning.
struct Window {
  double begin = 0;  // of the track
  std::vector<ImuIntegral::Value> cells;
  std::vector<Vector3d> velocity;
  double change = 0;  // rms of the velocity about its mean
};

std::optional<Window> window_at(const ImuIntegral& imu, const Track& track, double begin, double offset,
                                const Vector3d& bias) {
  const auto cells = static_cast<std::size_t>(std::lround(kWindow / kCell));
  const double first = begin + offset, last = first + kWindow;
  if (!imu.covers(first, last) || imu.clipped(first, last) > kMostClipped) return std::nullopt;
  Window w;
  w.begin = begin;
  ImuIntegral::Value before = imu.at(first);
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
  // A second each, of a day at most.
  const double stride = std::max(1.0, (imu.end() - imu.start()) / kDay);
  for (double t = imu.start(); t + 1 < imu.end(); t += stride) {
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
  std::vector<Matrix3d> swing;  // of the antenna, by the lever arm
};

Carried carry(const Window& w, const Matrix3d& turn) {
  Carried out;
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

std::vector<Carried> carry_all(const std::vector<Window>& windows, const Matrix3d& turn) {
  std::vector<Carried> carried;
  carried.reserve(windows.size());
  for (const Window& w : windows) carried.push_back(carry(w, turn));
  return carried;
}

// Wahba's problem with a free scale, for one sign of the determinant.
struct Fit {
  Matrix3d R;
  double scale = 0, mean_square = 0;
};

Vector3d without_gravity(const Window& w, std::size_t k, bool gravity) {
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

Fit wahba(const std::vector<Vector3d>& alpha, const std::vector<Vector3d>& beta, bool mirrored) {
  Matrix3d H = Matrix3d::Zero();
  double aa = 0, bb = 0;
  for (std::size_t k = 0; k < alpha.size(); ++k) {
    H += beta[k] * alpha[k].transpose();
    aa += alpha[k].squaredNorm();
    bb += beta[k].squaredNorm();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() > 0 ? 1 : -1;
  const Vector3d D(1, 1, mirrored ? -sign : sign);
  const double trace = svd.singularValues().dot(D);
  return {svd.matrixU() * D.asDiagonal() * svd.matrixV().transpose(), aa > 0 ? trace / aa : 0,
          (bb - (aa > 0 ? trace * trace / aa : 0)) / static_cast<double>(alpha.size())};
}

// All windows, with one lever arm in common.
struct Joint {
  std::vector<Fit> fits;
  Vector3d lever_arm = Vector3d::Zero();  // in the accelerometers' axes
};

Joint fit_all(const std::vector<Window>& windows, const std::vector<Carried>& carried, bool gravity, bool mirrored) {
  Joint joint;
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
    const Fit& fit = joint.fits[i] = wahba(alpha[i], beta[i], mirrored);
    const std::vector<Matrix3d> swing = without_mean(carried[i].swing);
    for (std::size_t k = 0; k < swing.size(); ++k) {
      const Matrix3d J = fit.R * swing[k];
      N += J.transpose() * J;
      n += J.transpose() * (beta[i][k] - fit.scale * (fit.R * alpha[i][k]));
    }
  }
  joint.lever_arm = N.ldlt().solve(n);
  for (std::size_t i = 0; i < windows.size(); ++i) {
    // α with the swing, in the forces' own unit.
    const double scale = joint.fits[i].scale;
    if (scale == 0) continue;
    const std::vector<Matrix3d> swing = without_mean(carried[i].swing);
    for (std::size_t k = 0; k < swing.size(); ++k) alpha[i][k] += swing[k] * joint.lever_arm / scale;
    joint.fits[i] = wahba(alpha[i], beta[i], mirrored);
  }
  return joint;
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
      const std::vector<Carried> carried = carry_all(windows, factor * axes);
      for (Reading& r : four) {
        for (const Fit& fit : fit_all(windows, carried, r.gravity, r.mirrored).fits) r.left.push_back(fit.mean_square);
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

// What the clock is off beyond `offset`: where the least is left.
void refine_clock(const ImuIntegral& imu, const Track& track, const std::vector<Window>& windows, const Vector3d& bias,
                  const Reading& reading, double offset, MotionMatch& match) {
  constexpr double kStep = 0.03, kIndependent = 0.5;  // s
  constexpr double kSteps = 6;                        // to either side
  std::array<double, 13> left{};
  for (std::size_t i = 0; i < left.size(); ++i) {
    std::vector<Window> moved;
    moved.reserve(windows.size());
    for (const Window& w : windows) {
      auto at = window_at(imu, track, w.begin, offset + (static_cast<double>(i) - kSteps) * kStep, bias);
      if (!at) at = w;  // clipped or cut there: it says nothing then
      moved.push_back(std::move(*at));
    }
    const auto carried = carry_all(moved, reading.factor * reading.axes);
    for (const Fit& fit : fit_all(moved, carried, reading.gravity, reading.mirrored).fits) left[i] += fit.mean_square;
  }
  const auto best = static_cast<std::size_t>(std::min_element(left.begin(), left.end()) - left.begin());
  if (best == 0 || best + 1 == left.size()) return;
  const double bend = left[best - 1] - 2 * left[best] + left[best + 1];
  if (!(bend > 0)) return;
  const double part = 0.5 * (left[best - 1] - left[best + 1]) / bend;
  match.clock_rest = (static_cast<double>(best) - kSteps + part) * kStep;
  // Of the log-likelihood −n/2 log(left), over horizontal velocities; the windows overlap by half.
  const double n = static_cast<double>(windows.size()) * kStride / kIndependent * 2;
  match.sigma_clock = kStep * std::sqrt(2 * left[best] / (n * bend));
}

// The signed permutation that is nearest to the directions forward, right and down, as the sensor's axes have them.
void name_axes(const std::vector<Window>& windows, const Reading& reading, MotionMatch& match) {
  Matrix3d sum = Matrix3d::Zero();  // of R_bs over time
  std::vector<double> scales;
  const std::vector<Carried> carried = carry_all(windows, reading.factor * reading.axes);
  const Joint joint = fit_all(windows, carried, reading.gravity, reading.mirrored);
  match.lever_arm = joint.lever_arm;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const Window& w = windows[i];
    const Fit& fit = joint.fits[i];
    scales.push_back(fit.scale);
    for (std::size_t k = 0; k < w.velocity.size(); ++k) {
      const double speed = w.velocity[k].head<2>().norm();
      if (speed < kForward) continue;
      Matrix3d R_wh = Matrix3d::Identity();  // along the track
      R_wh.topLeftCorner<2, 2>() << w.velocity[k].x(), -w.velocity[k].y(), w.velocity[k].y(), w.velocity[k].x();
      R_wh.topLeftCorner<2, 2>() /= speed;
      sum += R_wh.transpose() * fit.R * carried[i].attitude[k];
    }
  }
  match.accel_factor = median(scales);
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d mean = svd.matrixU() * svd.matrixV().transpose();
  const auto angle_to = [&](const Matrix3d& R_bs) {
    return std::acos(std::clamp((R_bs.cwiseProduct(mean).sum() - 1) / 2, -1.0, 1.0));
  };
  std::vector<std::pair<double, Matrix3d>> off;
  for (const Matrix3d& R_bs : signed_permutations()) {
    if ((R_bs.determinant() < 0) == reading.mirrored) off.emplace_back(angle_to(R_bs), R_bs);
  }
  std::sort(off.begin(), off.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  // An IMU that sits half way between two axes: the sensor's own, where they are one of them.
  const bool own = off[1].second.isIdentity() && off[1].first - off[0].first < kHalfWay;
  match.R_bs = off[own ? 1 : 0].second;
  match.tilt = off[own ? 1 : 0].first;
  match.margin = off[own ? 0 : 1].first - match.tilt;
  match.axes = axes_text(match.R_bs);
}

}  // namespace

std::optional<MotionMatch> match_motion(const ImuIntegral& imu, bool increments, const Track& track,
                                        const std::vector<Interval>& rest, double offset, double turns) {
  if (track.empty()) return std::nullopt;
  const Vector3d bias = gyro_bias(imu, rest, offset);
  std::vector<Window> windows;
  const double begin = std::max(track.start(), imu.start() - offset), end = std::min(track.end(), imu.end() - offset);
  constexpr double kLooks = 4000;
  const double stride = std::max(kStride, (end - begin) / kLooks);
  for (double t = begin; t + kWindow < end; t += stride) {
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
  // The turns tell about which unit the gyroscopes have; the labels' own stands first, whatever they tell.
  std::vector<double> factors{1};
  for (const double factor : {1 / kDegrees, kDegrees, increments ? interval : 1 / interval}) {
    if (turns == 0 || std::abs(std::log(turns * factor)) < std::log(kTurnTolerance)) factors.push_back(factor);
  }
  const std::vector<Reading> all = read_all_ways(windows, factors);
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
  change = std::sqrt(change);
  if (rms(*chosen) > (chosen == &as_given ? kExplained : kClaim) * change) return std::nullopt;

  MotionMatch match;
  match.change = change;
  match.gyro_factor = chosen->factor;
  match.gyro_axes = chosen->axes;
  match.mirrored = chosen->mirrored;
  match.gravity = chosen->gravity;
  match.residual = rms(*chosen);
  match.residual_as_given = rms(as_given);
  match.windows = windows.size();
  name_axes(windows, *chosen, match);
  refine_clock(imu, track, windows, bias, *chosen, offset, match);
  return match;
}

}  // namespace piste
