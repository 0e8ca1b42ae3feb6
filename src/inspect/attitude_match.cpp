#include "piste/inspect/attitude_match.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "attitude_motion.h"
#include "condition/boresight.h"
#include "condition/coarse_offset.h"
#include "core/time_search.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "signed_permutations.h"

namespace piste {
namespace {

using Vector10 = Eigen::Matrix<double, 10, 1>;
using Matrix10 = Eigen::Matrix<double, 10, 10>;

constexpr double kRateCell = 0.05;        // s: interval at which the rate magnitudes are resampled
constexpr double kMostNorms = 400000;     // number of these magnitudes: two logs of hours are correlated in a second
constexpr double kShortestCommon = 10;    // s
constexpr std::size_t kFewestTurns = 50;  // attitudes
constexpr double kUnitFar = 3;            // factor between the rates beyond which a unit is wrong
constexpr double kLeastExplained = 0.8;   // part of the rates' variance
constexpr double kStill = 0.3 * kDegree;  // rad/s: rms of rates that are not informative
constexpr double kOutlier = 5;            // sigmas
constexpr double kLargestScale = 0.3;     // of gyroscopes in the right unit

// The parameters: offset, rotation vector, bias, scale.
struct RateFit {
  double offset = 0;
  Quaterniond q_rs = Quaterniond::Identity();
  Vector3d bias = Vector3d::Zero(), scale = Vector3d::Zero();
};

// One interval of the attitudes: both rotation vectors, and the derivative of the IMU's with respect to the offset.
struct TurnPair {
  double interval = 0;
  Vector3d reference, imu, by_offset;
};

std::vector<TurnPair> pairs_at(const std::vector<ImuSample>& reference, const GyroTurns& imu, double offset) {
  const double aside = std::max(imu.interval() / 2, 0.005);
  std::vector<TurnPair> pairs;
  for (const ImuSample& s : reference) {
    const double end = s.time + offset, begin = end - s.interval;
    if (!imu.covers(begin - aside, end + aside)) continue;
    pairs.push_back({s.interval, s.dtheta, imu.turn(begin, end),
                     (imu.turn(begin + aside, end + aside) - imu.turn(begin - aside, end - aside)) / (2 * aside)});
  }
  return pairs;
}

// Rotation and bias in closed form, and whether they are observable.
BoresightFromRates closed_form(const std::vector<TurnPair>& pairs) {
  std::vector<Vector3d> reference, imu;
  for (const TurnPair& p : pairs) {
    reference.emplace_back(p.reference / p.interval);
    imu.emplace_back(p.imu / p.interval);
  }
  return boresight_from_rates(reference, imu);
}

// The IMU's rotation without its modelled errors, in the reference axes.
Vector3d turned_by(const TurnPair& p, const RateFit& x) {
  return x.q_rs * (p.imu - p.interval * x.bias - x.scale.cwiseProduct(p.imu));
}

// The factor by which correlation of the residuals increases the variance: the sum of their autocorrelation over 1 s.
double correlated(const std::vector<Vector3d>& residuals, double interval) {
  const auto lags = std::min(residuals.size() / 4, static_cast<std::size_t>(std::max(1.0, 1 / interval)));
  double all = 0, sum = 1;
  for (const Vector3d& r : residuals) all += r.squaredNorm();
  for (std::size_t lag = 1; all > 0 && lag <= lags; ++lag) {
    double product = 0;
    for (std::size_t i = lag; i < residuals.size(); ++i) product += residuals[i].dot(residuals[i - lag]);
    sum += 2 * product / all;
  }
  return std::max(1.0, sum);
}

// One Gauss-Newton step, the sigmas of its solution, and the residuals.
struct FitStep {
  RateFit x;
  double change = 0;  // of the offset [s]
  Matrix10 covariance;
  double residual = 0;  // rms of one axis [rad/s]
};

FitStep step_of(const std::vector<TurnPair>& pairs, const RateFit& x) {
  std::vector<double> sizes;
  sizes.reserve(pairs.size());
  for (const TurnPair& p : pairs) sizes.push_back((p.reference - turned_by(p, x)).norm() / p.interval);
  const double most = kOutlier * std::max(median(sizes), 1e-9);
  Matrix10 N = Matrix10::Zero();
  Vector10 n = Vector10::Zero();
  double squares = 0, rates = 0, interval = 0;
  std::vector<Vector3d> residuals;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (sizes[i] > most) continue;
    const TurnPair& p = pairs[i];
    const Vector3d turned = turned_by(p, x), r = p.reference - turned;
    const Matrix3d R_rs = x.q_rs.toRotationMatrix();
    Eigen::Matrix<double, 3, 10> J;
    J << x.q_rs * p.by_offset, -skew(turned), -p.interval * R_rs, -R_rs * p.imu.asDiagonal().toDenseMatrix();
    N += J.transpose() * J;
    n += J.transpose() * r;
    squares += r.squaredNorm();
    rates += (r / p.interval).squaredNorm();
    interval += p.interval;
    residuals.push_back(r);
  }
  const auto count = static_cast<double>(residuals.size());
  const Vector10 d = N.ldlt().solve(n);
  const double variance = squares / (3 * count - 10) * correlated(residuals, interval / count);
  return {{x.offset + d(0), (so3_exp(d.segment<3>(1)) * x.q_rs).normalized(), x.bias + d.segment<3>(4),
           x.scale + d.tail<3>()},
          d(0),
          variance * N.ldlt().solve(Matrix10::Identity()),
          std::sqrt(rates / (3 * count))};
}

void name_axes(const FitStep& step, AttitudeFit& fit) {
  const Matrix3d R_rs = step.x.q_rs.toRotationMatrix();
  double best = -3;
  for (const Matrix3d& axes : signed_permutations()) {
    const double near = axes.cwiseProduct(R_rs).sum();
    if (axes.determinant() < 0 || near <= best) continue;
    best = near;
    fit.axes = axes;
  }
  fit.left = Quaterniond(R_rs * fit.axes.transpose());
  fit.sigma_left = euler_sigma(fit.left, step.covariance.block<3, 3>(1, 1));
}

// Fits from a coarse offset. Without a fit, `why_not` gets the reason, and `contradicts` whether no gyroscope with any
// axes turns as the attitude does.
std::optional<AttitudeFit> fit_rates(const std::vector<ImuSample>& reference, const GyroTurns& imu, double offset,
                                     std::string& why_not, bool& contradicts) {
  constexpr int kMostSteps = 30;
  constexpr double kSettled = 1e-6;  // s
  RateFit x{.offset = offset};
  FitStep step;
  for (int i = 0; i < kMostSteps; ++i) {
    const std::vector<TurnPair> pairs = pairs_at(reference, imu, x.offset);
    if (pairs.size() < kFewestTurns) {
      why_not = "the logs have too little time in common once gaps are left out";
      return std::nullopt;
    }
    if (i == 0) {
      const BoresightFromRates start = closed_form(pairs);
      if (!std::isfinite(start.covariance(0, 0))) {
        why_not = "the body turns about one axis only, which does not determine the axes";
        return std::nullopt;
      }
      x.q_rs = start.q_rb;
      x.bias = start.gyro_bias;
    }
    step = step_of(pairs, x);
    x = step.x;
    if (std::abs(step.change) < kSettled) break;
  }
  AttitudeFit fit;
  fit.offset = x.offset;
  fit.sigma_offset = std::sqrt(step.covariance(0, 0));
  fit.gyro_bias = x.bias;
  fit.residual = step.residual;
  const std::vector<TurnPair> pairs = pairs_at(reference, imu, x.offset);
  double squares = 0;
  for (const TurnPair& p : pairs) squares += (p.imu / p.interval - x.bias).squaredNorm();
  fit.rate = std::sqrt(squares / (3 * static_cast<double>(pairs.size())));
  const double explained = 1 - fit.residual * fit.residual / (fit.rate * fit.rate);
  // A reversed axis is a scale of 2.
  const bool plausible = x.scale.cwiseAbs().maxCoeff() < kLargestScale;
  if (!(explained > kLeastExplained) || !plausible) {
    const BoresightFromRates last = closed_form(pairs);
    const bool mirrored = last.residual_mirrored < last.residual / 2;
    contradicts = !mirrored && !plausible;
    why_not =
        mirrored ? "the rates fit only with one of the two left-handed: an axis of one of them is reversed, or two are "
                   "interchanged"
        : !plausible ? "the rates fit only with scales that no gyroscope has"
                     : fmt::format("whatever the axes, the attitude explains {:.0f} % of the gyroscopes' rates",
                                   100 * std::max(0.0, explained));
    return std::nullopt;
  }
  name_axes(step, fit);
  return fit;
}

}  // namespace

bool AttitudeMatch::is_late(double imu_offset) const {
  constexpr double kLeast = 0.005, kSure = 3, kOfRow = 0.6;  // s; sigmas; half a row, and a margin for the fit
  return fit &&
         std::abs(attitude_delay(*fit, imu_offset)) > std::max({kLeast, kSure * fit->sigma_offset, kOfRow * interval});
}

AttitudeMatch match(const ImuRecording& imu, const AttitudeRecording& attitude) {
  AttitudeMatch m;
  const std::vector<ImuSample> reference = turns_of(attitude);
  if (imu.time.size() < kFewestTurns || reference.size() < kFewestTurns) {
    m.why_not = fmt::format("{} attitudes and {} rows of the IMU are too few", reference.size(), imu.time.size());
    return m;
  }
  m.imu = {imu.time.front(), imu.time.back()};
  m.attitude = {attitude.fixes.front().time, attitude.fixes.back().time};
  m.overlap = overlap(m.imu, m.attitude);
  const GyroTurns turns(imu);
  m.interval = turns.interval();
  const double longest = std::max(m.imu.end - m.imu.start, m.attitude.end - m.attitude.start);
  const double cell = std::max({kRateCell, reference.front().interval, longest / kMostNorms});
  const RateNorms body = rate_norms(turns.samples(), cell), other = rate_norms(reference, cell);
  if (const double most = std::max(root_mean_square(body.value), root_mean_square(other.value)); most < kStill) {
    m.why_not = fmt::format("not determined by the motion: the body turns by {:.2g} deg/s (rms) only", most / kDegree);
    return m;
  }
  const double ratio = root_mean_square(body.value) / std::max(root_mean_square(other.value), 1e-12);
  if (ratio > kUnitFar || ratio < 1 / kUnitFar) {
    m.why_not = fmt::format("the gyroscopes turn {:.3g} times as fast as the attitude: see their units", ratio);
    m.contradicts = true;
    return m;
  }
  const CoarseOffset coarse = correlate(body, other, kShortestCommon);
  m.correlation = coarse.peak.peak;
  if (coarse.evidence < kEvident) {
    m.why_not = fmt::format("not determined by the motion: the rates correlate by {:.2f} at best", m.correlation);
  } else if (coarse.over_rival < kEvident) {
    m.why_not =
        fmt::format("the motion repeats itself: the rates correlate by {:.3f} at {:.2f} s, and by {:.3f} elsewhere",
                    m.correlation, coarse.peak.peak_offset, coarse.peak.rival);
  } else {
    m.fit = fit_rates(reference, turns, coarse.peak.peak_offset, m.why_not, m.contradicts);
  }
  return m;
}

double attitude_delay(const AttitudeFit& fit, double imu_offset) { return imu_offset - fit.offset; }

}  // namespace piste
