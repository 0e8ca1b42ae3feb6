#include "piste/analyse/imu_fit.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "piste/condition/aligned_signals.h"
#include "piste/core/error.h"

namespace piste {
namespace {

constexpr std::array<std::string_view, 6> kAxes{"fx", "fy", "fz", "wx", "wy", "wz"};
constexpr int kFewest = 30;  // samples of a phase

// One axis of both IMUs in one phase.
struct Signals {
  Eigen::VectorXd measured, reference;
};

Signals signals(const AlignedImus& imus, int axis, const Interval& phase, std::string_view name) {
  const bool force = axis < 3;
  const auto& measured = force ? imus.accel : imus.gyro;
  const auto& reference = force ? imus.reference_accel : imus.reference_gyro;
  std::vector<double> m, r;
  for (std::size_t i = 0; i < imus.time.size(); ++i) {
    if (!imus.usable[i] || !phase.contains(imus.time[i])) continue;
    m.push_back(measured[i](axis % 3));
    r.push_back(reference[i](axis % 3));
  }
  if (m.size() < kFewest) {
    throw DataError("", fmt::format("{} from {:.3f} to {:.3f} s: {} samples of both IMUs are usable, at least {} are "
                                    "needed",
                                    name, phase.start, phase.end, m.size(), kFewest));
  }
  const auto n = static_cast<Eigen::Index>(m.size());
  return {Eigen::Map<const Eigen::VectorXd>(m.data(), n), Eigen::Map<const Eigen::VectorXd>(r.data(), n)};
}

BiasScale line(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  const Regression fit = regress_line(x, y);
  return {fit.value - Eigen::Vector2d(0, 1), fit.covariance, fit.hac_covariance, fit.dof};
}

// A rest: where its mean point lies, and how sure measured − reference is there.
struct RestPoint {
  double measured, reference;
  Term excess;
};

RestPoint rest_point(const Signals& s) {
  return {s.measured.mean(), s.reference.mean(), regress_mean(s.measured - s.reference).term(0)};
}

// y = (1 + k) x + bias through (x₀, y₀), of which y₀ − x₀ has an error.
BiasScale line_through(const Eigen::VectorXd& x, const Eigen::VectorXd& y, double x0, double y0, const Term& excess) {
  const Eigen::VectorXd dx = x.array() - x0;
  const Regression fit = regress(dx, y.array() - y0);
  const double slope = fit.value(0);
  const double lever = -dx.sum() / dx.squaredNorm();  // of the slope on y₀
  const Eigen::Vector2d from_slope(-x0, 1), from_point(1 - x0 * lever, lever);
  const auto covariance = [&](double slope_variance, double excess_sigma) -> Eigen::Matrix2d {
    return slope_variance * from_slope * from_slope.transpose() +
           excess_sigma * excess_sigma * from_point * from_point.transpose();
  };
  BiasScale out;
  out.value << y0 - slope * x0, slope - 1;
  out.covariance = covariance(fit.covariance(0, 0), excess.sigma);
  out.hac_covariance = covariance(fit.hac_covariance(0, 0), excess.standard_error);
  out.dof = std::min(fit.dof, excess.dof);
  return out;
}

RunFit fit_run(const Signals& s, const std::optional<RestPoint>& rest) {
  RunFit out;
  out.samples = static_cast<int>(s.measured.size());
  out.mean = s.reference.mean();
  out.rms = std::sqrt(s.reference.squaredNorm() / out.samples);
  out.bias_only = regress_mean(s.measured - s.reference).term(0);
  out.joint = {line(s.reference, s.measured), correction(line(s.measured, s.reference))};
  const Eigen::Vector2d& found = out.joint.reverse.value;
  const Eigen::VectorXd left = (s.measured - (1 + found(1)) * s.reference).array() - found(0);
  out.residual = std::sqrt(left.squaredNorm() / out.samples);
  if (rest) {
    const auto& [y0, x0, excess] = *rest;
    out.scale_only = {line_through(s.reference, s.measured, x0, y0, excess),
                      correction(line_through(s.measured, s.reference, y0, x0, excess))};
  }
  return out;
}

}  // namespace

Term BiasScale::term(int i) const {
  return {value(i), std::sqrt(covariance(i, i)), std::sqrt(hac_covariance(i, i)), dof};
}

double BiasScale::correlation() const {
  const double variances = covariance(0, 0) * covariance(1, 1);
  return variances > 0 ? covariance(0, 1) / std::sqrt(variances) : 0;
}

double BiasScale::inflation() const {
  const double c = correlation();
  return 1 / (1 - c * c);
}

BiasScale correction(const BiasScale& line) {
  const double bias = line.value(0), slope = 1 + line.value(1);
  Eigen::Matrix2d J;
  J << -1 / slope, bias / (slope * slope), 0, -1 / (slope * slope);
  return {Eigen::Vector2d(-bias / slope, -line.value(1) / slope), J * line.covariance * J.transpose(),
          J * line.hac_covariance * J.transpose(), line.dof};
}

Findings findings(const AlignedImus& imus, const Phases& phases, const FitOptions& options) {
  const AlignedImus smooth = low_passed(imus, options.low_pass);
  Findings out{phases, options.low_pass, {}};
  for (int axis = 0; axis < 6; ++axis) {
    AxisFindings& a = out.axes[static_cast<std::size_t>(axis)];
    a.name = kAxes[static_cast<std::size_t>(axis)];
    if (axis >= 3) a.bias_block = Block::kGyroBias, a.scale_block = Block::kGyroScale;
    std::optional<RestPoint> before, after;
    if (phases.before) before = rest_point(signals(smooth, axis, *phases.before, "the rest before"));
    if (phases.after) after = rest_point(signals(smooth, axis, *phases.after, "the rest after"));
    if (before) a.before = before->excess;
    if (after) a.after = after->excess;
    if (before && after) a.change = difference(after->excess, before->excess);
    if (phases.run) a.run = fit_run(signals(smooth, axis, *phases.run, "the run"), before ? before : after);
  }
  return out;
}

}  // namespace piste
