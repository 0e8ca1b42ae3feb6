#include "piste/analyse/imu_fit.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "piste/analyse/reference_errors.h"
#include "piste/condition/aligned_signals.h"
#include "piste/core/error.h"

namespace piste {
namespace {

constexpr std::array<std::string_view, 6> kAxes{"fx", "fy", "fz", "wx", "wy", "wz"};
constexpr int kFewest = 30;  // samples of a phase

using Errors = Eigen::Matrix<double, Eigen::Dynamic, ReferenceErrors::kSize>;

// One axis of both IMUs in one phase.
struct Signals {
  Eigen::VectorXd measured, reference;
  Errors errors;  // D: how the reference moves with what is wrong with it
  ReferenceErrors::Covariance P_errors;
};

Signals signals(const AlignedImus& imus, const ReferenceErrors& errors, int axis, const Interval& phase,
                std::string_view name) {
  const bool force = axis < 3;
  const auto& measured = force ? imus.accel : imus.gyro;
  const auto& reference = force ? imus.reference_accel : imus.reference_gyro;
  std::vector<double> m, r;
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < imus.time.size(); ++i) {
    if (!imus.usable[i] || !phase.contains(imus.time[i])) continue;
    m.push_back(measured[i](axis % 3));
    r.push_back(reference[i](axis % 3));
    rows.push_back(i);
  }
  if (m.size() < kFewest) {
    throw DataError("", fmt::format("{} from {:.3f} to {:.3f} s: {} samples of both IMUs are usable, at least {} are "
                                    "needed",
                                    name, phase.start, phase.end, m.size(), kFewest));
  }
  const auto n = static_cast<Eigen::Index>(m.size());
  Errors D(n, ReferenceErrors::kSize);
  for (Eigen::Index i = 0; i < n; ++i) D.row(i) = errors.row(rows[static_cast<std::size_t>(i)], axis);
  return {Eigen::Map<const Eigen::VectorXd>(m.data(), n), Eigen::Map<const Eigen::VectorXd>(r.data(), n), D,
          errors.covariance(axis)};
}

BiasScale line(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  const Regression fit = regress_line(x, y);
  return {fit.value - Eigen::Vector2d(0, 1), fit.covariance, fit.hac_covariance, Eigen::Matrix2d::Zero(), fit.dof};
}

// What the line on the reference makes of D p: its effect on bias and scale, a column each of p.
using LineEffect = Eigen::Matrix<double, 2, ReferenceErrors::kSize>;

LineEffect line_effect(const Signals& s, double x0, const ReferenceErrors::Row& at_x0) {
  const Eigen::VectorXd dx = s.reference.array() - x0;
  LineEffect G;
  G.row(1) = dx.transpose() * (s.errors.rowwise() - at_x0) / dx.squaredNorm();
  G.row(0) = at_x0 - x0 * G.row(1);
  return G;
}

// A phase as a point: where its means lie, and how sure measured − reference is there.
struct Point {
  double measured, reference;
  ReferenceErrors::Row errors;
  Term excess;
};

Term mean_excess(const Signals& s, const ReferenceErrors::Row& errors) {
  Term out = regress_mean(s.measured - s.reference).term(0);
  out.systematic = std::sqrt((errors * s.P_errors * errors.transpose()).value());
  return out;
}

Point mean_point(const Signals& s) {
  const ReferenceErrors::Row errors = s.errors.colwise().mean();
  return {s.measured.mean(), s.reference.mean(), errors, mean_excess(s, errors)};
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

RunFit fit_run(const Signals& s, const std::optional<Point>& rest) {
  RunFit out;
  const Point mean = mean_point(s);
  out.samples = static_cast<int>(s.measured.size());
  out.mean = mean.reference;
  out.rms = std::sqrt(s.reference.squaredNorm() / out.samples);
  out.bias_only = mean.excess;
  const auto both = [&s](const BiasScale& reverse, const BiasScale& inverse, const LineEffect& G) {
    BothDirections lines{reverse, correction(inverse)};
    lines.reverse.systematic_covariance = lines.forward.systematic_covariance = G * s.P_errors * G.transpose();
    return lines;
  };
  out.joint =
      both(line(s.reference, s.measured), line(s.measured, s.reference), line_effect(s, mean.reference, mean.errors));
  const Eigen::Vector2d& found = out.joint.reverse.value;
  const Eigen::VectorXd left = (s.measured - (1 + found(1)) * s.reference).array() - found(0);
  out.residual = std::sqrt(left.squaredNorm() / out.samples);
  if (rest) {
    const double x0 = rest->reference, y0 = rest->measured;
    out.scale_only =
        both(line_through(s.reference, s.measured, x0, y0, rest->excess),
             line_through(s.measured, s.reference, y0, x0, rest->excess), line_effect(s, x0, rest->errors));
  }
  return out;
}

}  // namespace

Term BiasScale::term(int i) const {
  return {value(i), std::sqrt(covariance(i, i)), std::sqrt(hac_covariance(i, i)), dof,
          std::sqrt(systematic_covariance(i, i))};
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
          J * line.hac_covariance * J.transpose(), J * line.systematic_covariance * J.transpose(), line.dof};
}

Findings findings(const AlignedImus& imus, const Phases& phases, const FitOptions& options) {
  const AlignedImus smooth = low_passed(imus, options.low_pass);
  const ReferenceErrors errors(smooth, options.alignment, options.reference);
  Findings out{phases, options.low_pass, {}};
  for (int axis = 0; axis < 6; ++axis) {
    AxisFindings& a = out.axes[static_cast<std::size_t>(axis)];
    a.name = kAxes[static_cast<std::size_t>(axis)];
    if (axis >= 3) a.bias_block = Block::kGyroBias, a.scale_block = Block::kGyroScale;
    const auto point = [&](const std::optional<Interval>& phase, std::string_view name) -> std::optional<Point> {
      if (!phase) return std::nullopt;
      return mean_point(signals(smooth, errors, axis, *phase, name));
    };
    const std::optional<Point> before = point(phases.before, "the rest before"),
                               after = point(phases.after, "the rest after");
    if (before) a.before = before->excess;
    if (after) a.after = after->excess;
    if (before || after) a.rest_signal = (before ? before : after)->reference;
    if (before && after) {
      a.change = difference(after->excess, before->excess);
      const ReferenceErrors::Row moved = after->errors - before->errors;  // a bias of the reference cancels
      a.change->systematic = std::sqrt((moved * errors.covariance(axis) * moved.transpose()).value());
    }
    if (phases.run) {
      a.run = fit_run(signals(smooth, errors, axis, *phases.run, "the run"), before ? before : after);
    }
  }
  return out;
}

}  // namespace piste
