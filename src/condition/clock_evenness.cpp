#include "clock_evenness.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "coarse_offset.h"
#include "piste/core/error.h"
#include "piste/math/interruption.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kStretch = 10;  // s

// Rates of the body IMU, measured and as predicted from the reference, in b at equal steps. Zero where one of the two
// IMUs has no sample.
struct RatePair {
  double step = 0;
  std::vector<double> time;
  std::vector<Vector3d> measured, predicted;
};

RatePair rate_pair(const SignalPair& signals, const FilteredPair& pair, const AlignmentState& x) {
  constexpr double kStep = 0.05;  // s
  const BodySignals& body = pair.body;
  const auto stride = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(kStep / body.step)));
  RatePair rates;
  rates.step = static_cast<double>(stride) * body.step;
  for (std::size_t k = 0; k < body.time.size(); k += stride) {
    const double t = x.reference_time(body.time[k], body.time.front());
    const bool inside = pair.reference.contains(t) && !signals.integrals.silent(t - pair.margin, t + pair.margin);
    rates.time.push_back(t);
    rates.predicted.emplace_back(inside ? Vector3d(x.q_rb.conjugate() * pair.reference.at(t).signal.gyro)
                                        : Vector3d::Zero());
    rates.measured.emplace_back(body.usable[k].gyro == 7 ? Vector3d(body.gyro[k] - x.gyro_bias) : Vector3d::Zero());
  }
  return rates;
}

// Correlations of a stretch of the measured rates with the predicted ones, at every shift.
struct Shifts {
  std::ptrdiff_t furthest = 0;
  std::vector<double> correlation;  // from the shift −furthest on

  double at(std::ptrdiff_t shift) const { return correlation[static_cast<std::size_t>(shift + furthest)]; }
  std::ptrdiff_t best() const {
    return std::max_element(correlation.begin(), correlation.end()) - correlation.begin() - furthest;
  }
};

Shifts correlated(const RatePair& rates, std::size_t begin, std::size_t end) {
  constexpr double kFurthest = 20;  // s
  const auto furthest = static_cast<std::ptrdiff_t>(kFurthest / rates.step);
  const auto count = static_cast<std::ptrdiff_t>(rates.time.size());
  double power = 0;
  for (std::size_t i = begin; i < end; ++i) power += rates.measured[i].squaredNorm();
  Shifts found{furthest, {}};
  for (std::ptrdiff_t shift = -furthest; shift <= furthest; ++shift) {
    check_interruption();
    double cross = 0, other = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + shift;
      if (j < 0 || j >= count) continue;
      const Vector3d& predicted = rates.predicted[static_cast<std::size_t>(j)];
      cross += rates.measured[i].dot(predicted);
      other += predicted.squaredNorm();
    }
    found.correlation.push_back(cross > 0 ? cross / std::sqrt(power * other) : 0);
  }
  return found;
}

// The normal equation of one offset: Σ J² / σ² and Σ J r / σ² over a stretch.
struct OffsetSums {
  double time = 0, count = 0, information = 0, pull = 0;

  void add(double slope, double rest, double sigma) {
    // Outliers, to which the robust loss gives little weight, are left out.
    if (std::abs(rest) > 4 * sigma) return;
    information += slope * slope / (sigma * sigma);
    pull -= slope * rest / (sigma * sigma);  // the offset that would explain the residual
  }
};

[[noreturn]] void refuse_clock(const LocalOffset& local, const std::string& name) {
  throw DataError(name, fmt::format("the clock of the body IMU does not run evenly: about {:.1f} s it is {:.1f} "
                                    "ms off the fitted offset and drift; samples or time stamps are wrong there. Align "
                                    "the parts one by one with `span`",
                                    local.time, 1e3 * local.offset));
}

}  // namespace

void refuse_jumps(const SignalPair& signals, const FilteredPair& pair, const AlignmentState& x,
                  const std::string& name) {
  constexpr double kFastest = 0.01;             // the rate of a clock: a fit beyond it is refused
  constexpr double kStep = 0.1, kSurely = 0.9;  // s: two steps of the rates; correlation
  const RatePair rates = rate_pair(signals, pair, x);
  const auto length = static_cast<std::size_t>(kStretch / rates.step);
  // Of two neighbouring stretches with motion, each must fit far better at its own shift than at that of the other.
  std::optional<Shifts> before;
  std::size_t begin_before = 0;
  for (std::size_t begin = 0; begin + length <= rates.time.size(); begin += length) {
    Shifts here = correlated(rates, begin, begin + length);
    const std::ptrdiff_t shift = here.best();
    if (here.at(shift) < kSurely) continue;
    if (before) {
      const std::ptrdiff_t other = before->best();
      const double jump = static_cast<double>(shift - other) * rates.step,
                   apart = rates.time[begin] - rates.time[begin_before];
      if (std::abs(jump) > kFastest * apart + kStep &&
          evidence_over(here.at(shift), here.at(other), kStretch) > kEvident &&
          evidence_over(before->at(other), before->at(shift), kStretch) > kEvident) {
        throw DataError(
            name,
            fmt::format("the clock of the body IMU jumps: between {:.1f} and {:.1f} s its rates begin to fit those "
                        "of the reference {:.2f} s {} than before; samples are missing, or time stamps are wrong. "
                        "Align the parts one by one with `span`",
                        rates.time[begin_before], rates.time[begin + length - 1], std::abs(jump),
                        jump > 0 ? "later" : "earlier"));
      }
    }
    before = std::move(here);
    begin_before = begin;
  }
}

std::vector<LocalOffset> local_offsets(const FilteredPair& pair, const AlignmentFit& fit) {
  const AlignmentState& x = fit.x;
  const Matrix3d R_br = x.q_rb.toRotationMatrix().transpose();
  const double first = pair.body.time.front();
  std::vector<OffsetSums> stretches;
  for (const AlignmentEpoch& e : fit.epochs) {
    const double m = pair.body.time[e.sample], t = x.reference_time(m, first);
    const auto stretch = static_cast<std::size_t>((m - first) / kStretch);
    if (stretches.size() <= stretch) stretches.resize(stretch + 1);
    const AlignmentResidual r = residual(pair, x, e.sample);
    const MeanSignal slope = pair.reference.at(t).slope;
    const Vector3d w = R_br * slope.gyro, f = R_br * (slope.accel + slope.lever * x.p_rb_r);
    OffsetSums& sums = stretches[stretch];
    sums.time += t;
    sums.count += 1;
    for (int axis = 0; axis < 3; ++axis) {
      if (e.usable.gyro >> axis & 1) sums.add(w(axis), r.gyro(axis), e.gyro_sigma);
      if (e.usable.accel >> axis & 1) sums.add(f(axis), r.accel(axis), e.accel_sigma);
    }
  }
  constexpr double kCoarse = 3e-3;  // s
  std::vector<LocalOffset> local;
  for (const OffsetSums& s : stretches) {
    if (!(s.information > 0)) continue;
    const LocalOffset offset{s.time / s.count, s.pull / s.information, 1 / std::sqrt(s.information)};
    if (offset.sigma <= kCoarse) local.push_back(offset);
  }
  return local;
}

double clock_wander(const std::vector<LocalOffset>& local, const std::string& name) {
  constexpr double kJump = 20e-3, kSurely = 6, kUneven = 5e-3, kAccident = 1e-4;
  // About their own line, which the offset and the drift of the fit have taken out but for rounding.
  Eigen::Matrix2d weights = Eigen::Matrix2d::Zero(), squared = Eigen::Matrix2d::Zero();
  Eigen::Vector2d pull = Eigen::Vector2d::Zero();
  double q = 0, sum = 0;
  for (const LocalOffset& l : local) {
    if (std::abs(l.offset) > std::max(kJump, kSurely * l.sigma)) refuse_clock(l, name);
    const double weight = 1 / (l.sigma * l.sigma);
    const Eigen::Vector2d row(1, l.time - local.front().time);
    weights += weight * row * row.transpose();
    squared += weight * weight * row * row.transpose();
    pull += weight * l.offset * row;
    q += weight * l.offset * l.offset;
    sum += weight;
  }
  const double freedom = static_cast<double>(local.size()) - 2;
  if (freedom < 1) return 0;
  const Eigen::LDLT<Eigen::Matrix2d> root(weights);
  q -= pull.dot(root.solve(pull));
  if (q < chi_squared_quantile(1 - kAccident, freedom)) return 0;
  // E[Q] = n − 2 + wander² (Σ w − tr((Xᵀ W X)⁻¹ Xᵀ W² X))
  const double wander = std::sqrt((q - freedom) / (sum - root.solve(squared).trace()));
  if (wander > kUneven) {
    refuse_clock(*std::max_element(local.begin(), local.end(),
                                   [](const LocalOffset& a, const LocalOffset& b) {
                                     return std::abs(a.offset) < std::abs(b.offset);
                                   }),
                 name);
  }
  return wander;
}

}  // namespace piste
