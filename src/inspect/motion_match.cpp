#include "motion_match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "math/wahba.h"
#include "motion_fit.h"
#include "motion_windows.h"
#include "piste/math/interruption.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "signed_permutations.h"

namespace piste {
namespace {

constexpr std::size_t kFewestWindows = 5;              // windows
constexpr double kForward = 1.5;                       // m/s from which a track has a direction
constexpr double kFloor = 0.05;                        // m/s: error of the velocities
constexpr double kClearlyBetter = 1.3, kAsGood = 1.2;  // ratios of mean squared residuals
constexpr double kNearlyAll = 0.85;
constexpr double kClaim = 0.12;       // the same for a hypothesis that contradicts the labels
constexpr double kTurnTolerance = 3;  // factor between the turns of the gyroscopes and of the track
constexpr double kHalfWay = 10 * kDegree;
constexpr double kExplained = 0.2;  // largest rms of the residuals, relative to the change of velocity

// A hypothesis about the labels (axes and units), its residuals in each window, and how much it differs from the
// labels.
struct Reading {
  double factor = 1;
  Matrix3d axes = Matrix3d::Identity();
  bool mirrored = false, gravity = true;
  int oddity = 0;
  std::vector<double> left;  // mean squared residual of each window

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

std::vector<Reading> read_all_ways(const std::vector<MotionWindow>& windows, const std::vector<double>& factors) {
  std::vector<Reading> all;
  for (const double factor : factors) {
    for (const Matrix3d& axes : signed_permutations()) {
      check_interruption();
      std::array<Reading, 4> four;
      for (std::size_t i = 0; i < 4; ++i) {
        const bool mirrored = i % 2 != 0, gravity = i < 2;
        four[i] = {
            factor, axes, mirrored, gravity, oddity_of(axes, mirrored) + (factor == 1 ? 0 : 1) + (gravity ? 0 : 1), {}};
      }
      const std::vector<CarriedWindow> carried = carry_all(windows, factor * axes);
      for (Reading& r : four) {
        for (const WindowFit& fit : fit_all(windows, carried, r.gravity, r.mirrored).fits)
          r.left.push_back(fit.mean_square);
      }
      for (Reading& r : four) all.push_back(std::move(r));
    }
  }
  return all;
}

bool far_better(const Reading& one, const Reading& other) {
  std::size_t better = 0;
  for (std::size_t w = 0; w < one.left.size(); ++w) better += one.left[w] < other.left[w] ? 1 : 0;
  return other.mean_log() - one.mean_log() > std::log(kClearlyBetter) &&
         static_cast<double>(better) >= kNearlyAll * static_cast<double>(one.left.size());
}

double rms(const Reading& r) {
  double sum = 0;
  for (const double l : r.left) sum += l;
  return std::sqrt(sum / static_cast<double>(r.left.size()));
}

// Takes the first hypothesis, which is the labels themselves, unless another is far better. Then, of all hypotheses as
// good as the best, takes the one that differs least from the labels.
const Reading& chosen_of(const std::vector<Reading>& all) {
  const Reading& best = *std::min_element(
      all.begin(), all.end(), [](const Reading& a, const Reading& b) { return a.mean_log() < b.mean_log(); });
  if (!far_better(best, all.front())) return all.front();
  const Reading* chosen = &best;
  for (const Reading& r : all) {
    const bool as_good = r.mean_log() - best.mean_log() < std::log(kAsGood);
    if (as_good && r.oddity < chosen->oddity) chosen = &r;
  }
  return *chosen;
}

// A correction to the offset of the clocks, and its sigma.
struct ClockRest {
  double offset = 0, sigma = 0;
};

// The correction with the smallest residuals. nullopt if it is outside the range that is searched.
std::optional<ClockRest> clock_rest(const MotionSource& source, const std::vector<MotionWindow>& windows,
                                    const Reading& reading, double offset) {
  constexpr double kStep = 0.03, kIndependent = 0.5;  // s
  constexpr double kSteps = 6;                        // to each side
  std::array<double, 13> left{};
  for (std::size_t i = 0; i < left.size(); ++i) {
    check_interruption();
    std::vector<MotionWindow> moved;
    moved.reserve(windows.size());
    for (const MotionWindow& w : windows) {
      auto at = source.window(w.begin, offset + (static_cast<double>(i) - kSteps) * kStep);
      if (!at) at = w;  // clipped or cut at that offset: the window of `offset` serves
      moved.push_back(std::move(*at));
    }
    const auto carried = carry_all(moved, reading.factor * reading.axes);
    for (const WindowFit& fit : fit_all(moved, carried, reading.gravity, reading.mirrored).fits) {
      left[i] += fit.mean_square;
    }
  }
  const auto best = static_cast<std::size_t>(std::min_element(left.begin(), left.end()) - left.begin());
  if (best == 0 || best + 1 == left.size()) return std::nullopt;
  const double bend = left[best - 1] - 2 * left[best] + left[best + 1];
  if (!(bend > 0)) return std::nullopt;
  const double part = 0.5 * (left[best - 1] - left[best + 1]) / bend;
  // The maximum of the log-likelihood −n/2 log(left). It counts horizontal velocities; the windows overlap by half.
  const double n = static_cast<double>(windows.size()) * kStride / kIndependent * 2;
  return ClockRest{(static_cast<double>(best) - kSteps + part) * kStep, kStep * std::sqrt(2 * left[best] / (n * bend))};
}

// The signed permutation that is nearest to forward, right and down in the sensor's axes.
void name_axes(const std::vector<MotionWindow>& windows, const Reading& reading, MotionMatch& match) {
  Matrix3d sum = Matrix3d::Zero();  // of R_bs over time
  std::vector<double> scales;
  const std::vector<CarriedWindow> carried = carry_all(windows, reading.factor * reading.axes);
  const JointFit joint = fit_all(windows, carried, reading.gravity, reading.mirrored);
  match.lever_arm = joint.lever_arm;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const MotionWindow& w = windows[i];
    const WindowFit& fit = joint.fits[i];
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
  const Matrix3d mean = solve_wahba(sum, reading.mirrored).R;
  const auto angle_to = [&](const Matrix3d& R_bs) {
    return std::acos(std::clamp((R_bs.cwiseProduct(mean).sum() - 1) / 2, -1.0, 1.0));
  };
  std::vector<std::pair<double, Matrix3d>> off;
  for (const Matrix3d& R_bs : signed_permutations()) {
    if ((R_bs.determinant() < 0) == reading.mirrored) off.emplace_back(angle_to(R_bs), R_bs);
  }
  std::sort(off.begin(), off.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  // An IMU half-way between two sets of axes: prefer its own axes if they are one of the two.
  const bool own = off[1].second.isIdentity() && off[1].first - off[0].first < kHalfWay;
  match.R_bs = off[own ? 1 : 0].second;
  match.tilt = off[own ? 1 : 0].first;
  match.margin = off[own ? 0 : 1].first - match.tilt;
  match.axes = axes_text(match.R_bs);
  for (const auto& [angle, R_bs] : off) {
    if (R_bs != match.R_bs && angle - match.tilt < kHalfWay) match.as_likely.push_back(axes_text(R_bs));
  }
}

}  // namespace

std::optional<MotionMatch> match_motion(const ImuIntegral& imu, bool increments, const Track& track,
                                        const std::vector<Interval>& rest, double offset, double turns) {
  if (track.empty()) return std::nullopt;
  const MotionSource source{imu, track, gyro_bias(imu, rest, offset)};
  const std::vector<MotionWindow> windows = source.windows(offset);
  if (windows.size() < kFewestWindows) return std::nullopt;

  const double interval = imu.interval();
  // The turns show roughly the unit of the gyroscopes. The labels' unit comes first in any case.
  std::vector<double> factors{1};
  for (const double factor : {kDegree, kDegreesPerRadian, increments ? interval : 1 / interval}) {
    if (turns == 0 || std::abs(std::log(turns * factor)) < std::log(kTurnTolerance)) factors.push_back(factor);
  }
  const std::vector<Reading> all = read_all_ways(windows, factors);
  const Reading& as_given = all.front();
  const Reading& chosen = chosen_of(all);
  double change = 0;
  for (const MotionWindow& w : windows) change += w.change * w.change / static_cast<double>(windows.size());
  change = std::sqrt(change);
  if (rms(chosen) > (&chosen == &as_given ? kExplained : kClaim) * change) return std::nullopt;

  MotionMatch match;
  match.change = change;
  match.gyro_factor = chosen.factor;
  match.gyro_axes = chosen.axes;
  match.mirrored = chosen.mirrored;
  match.gravity = chosen.gravity;
  match.residual = rms(chosen);
  match.residual_as_given = rms(as_given);
  match.windows = windows.size();
  name_axes(windows, chosen, match);
  if (const auto rest_of_clock = clock_rest(source, windows, chosen, offset)) {
    match.clock_rest = rest_of_clock->offset;
    match.sigma_clock = rest_of_clock->sigma;
  }
  return match;
}

}  // namespace piste
