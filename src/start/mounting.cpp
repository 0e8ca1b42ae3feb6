#include "start/mounting.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "condition/boresight.h"
#include "core/time_search.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "start/stretch.h"
#include "walker/own_times.h"

namespace piste {
namespace {

// Shortest and longest time [s] between two fixes whose attitudes are subtracted. Over 0.5 s, white noise of 0.1 deg in
// each fix is a rate of 0.3 deg/s.
constexpr double kStep = 0.5;
constexpr double kLongestTurn = 2;
constexpr double kLargestTurn = 2.5;     // rad per step: near π the rotation vector is ambiguous
constexpr double kKnown = 10 * kDegree;  // largest 1-sigma of a result
constexpr std::size_t kFewestSteps = 10;

struct Turns {
  std::vector<Vector3d> rate_r, rate_b;
  std::vector<double> lapse;          // s
  std::vector<std::size_t> from, to;  // the fixes at which each begins and ends
};

Turns turns(const Log& log, const std::vector<AttitudeFix>& fixes, const Vector3d& bias) {
  Turns turns;
  for (std::size_t i = 0, next = 1; next < fixes.size(); ++next) {
    const AttitudeFix &from = fixes[i], &to = fixes[next];
    const double lapse = to.time - from.time;
    if (lapse < kStep - kSameInstant) continue;
    const std::size_t first = std::exchange(i, next);
    if (lapse > kLongestTurn) continue;
    const auto spoilt = [](const ImuSample& s) { return s.gap || s.clipped_gyro != 0; };
    const auto samples = range(log.imu, from.time, to.time + log.imu.front().interval);
    if (std::any_of(samples.begin(), samples.end(), spoilt)) continue;
    const Vector3d r = so3_log(from.q_wr.conjugate() * so3_exp(lapse * log.world.earth_rate()) * to.q_wr);
    const Vector3d b = so3_log(turned(log, from.time, to.time, bias));
    if (r.norm() > kLargestTurn || b.norm() > kLargestTurn) continue;
    turns.rate_r.emplace_back(r / lapse);
    turns.rate_b.emplace_back(b / lapse);
    turns.lapse.push_back(lapse);
    turns.from.push_back(first);
    turns.to.push_back(next);
  }
  return turns;
}

Vector3d mean(const std::vector<Vector3d>& all) {
  return std::accumulate(all.begin(), all.end(), Vector3d(Vector3d::Zero())) / static_cast<double>(all.size());
}

// The covariance of the boresight. White noise of the gyroscopes changes each rate independently. The error m of a fix,
// in axes of r, changes the rate r of the step that it ends by m/T + r × m/2. It changes that of the step that it
// begins by −m/T + r × m/2. The common part of two steps largely cancels; the remainder, half of m in each, acts as a
// boresight. The residuals show the size of each noise: only the error of the fix between them correlates neighbours.
Matrix3d covariance(const Turns& t, const BoresightFromRates& found) {
  const std::size_t n = t.rate_r.size();
  const Matrix3d R_rb = found.q_rb.toRotationMatrix();
  const Vector3d mean_r = mean(t.rate_r), mean_b = mean(t.rate_b);
  const auto residual = [&](std::size_t i) -> Vector3d {
    return R_rb * (t.rate_b[i] - mean_b) - (t.rate_r[i] - mean_r);
  };
  const auto follows = [&](std::size_t i) { return i > 0 && t.from[i] == t.to[i - 1]; };
  double shared = 0, pairs = 0;  // of the fixes [rad²]
  for (std::size_t i = 1; i < n; ++i) {
    if (!follows(i)) continue;
    shared -= residual(i).dot(residual(i - 1)) * t.lapse[i] * t.lapse[i - 1];
    pairs += 3;
  }
  const auto count = static_cast<double>(n);
  const double variance = square(found.residual) * 3 * count / (3 * count - 6);
  const double lapse = std::accumulate(t.lapse.begin(), t.lapse.end(), 0.) / count;
  // Less the chance value of few products: it would pass for errors that cancel.
  const double most = 0.5 * variance * square(lapse),
               chance = variance * square(lapse) / std::sqrt(std::max(pairs, 1.));
  const double of_fix = std::clamp(shared / std::max(pairs, 1.) - chance, 0., most);
  const double of_gyro = variance - 2 * of_fix / square(lapse);

  Matrix3d sum = Matrix3d::Zero(), ended = Matrix3d::Zero();  // effect of the fix that ended the previous step
  for (std::size_t i = 0; i < n; ++i) {
    const Matrix3d score = skew(t.rate_r[i] - mean_r), halves = 0.5 * skew(t.rate_r[i]);
    const Matrix3d apart = Matrix3d::Identity() / t.lapse[i];
    Matrix3d begun = score * (halves - apart);
    if (follows(i)) {
      begun += ended;
    } else {
      sum += of_fix * ended * ended.transpose();
    }
    ended = score * (halves + apart);
    sum += of_fix * begun * begun.transpose() - of_gyro * score * score;
  }
  sum += of_fix * ended * ended.transpose();
  const Matrix3d inverse = found.covariance / variance;  // of the information at unit noise
  return inverse * sum * inverse;
}

}  // namespace

std::optional<Mounting> find_mounting(const Log& log, std::span<const AttitudeOptions> sources) {
  const auto source =
      std::find_if(log.attitude.begin(), log.attitude.end(), [](const auto& fixes) { return !fixes.empty(); });
  if (source == log.attitude.end()) return std::nullopt;
  const auto number = static_cast<std::size_t>(source - log.attitude.begin());
  const std::vector<AttitudeFix> fixes =
      at_own_times(*source, number < sources.size() ? sources[number] : AttitudeOptions{});
  Mounting mounting{Quaterniond::Identity(), Matrix3d::Zero(), Vector3d::Zero()};
  // Two passes: the rotations of the second are without the bias that the first has estimated.
  for (int pass = 0; pass < 2; ++pass) {
    const Turns t = turns(log, fixes, mounting.gyro_bias);
    if (t.rate_r.size() < kFewestSteps) return std::nullopt;
    const BoresightFromRates found = boresight_from_rates(t.rate_r, t.rate_b);
    if (!found.covariance.allFinite()) return std::nullopt;
    mounting.q_rb = found.q_rb;
    mounting.covariance = covariance(t, found);
    mounting.gyro_bias += found.gyro_bias;
  }
  const double variance = Eigen::SelfAdjointEigenSolver<Matrix3d>(mounting.covariance).eigenvalues()(2);
  if (!(variance < kKnown * kKnown)) return std::nullopt;
  return mounting;
}

}  // namespace piste
