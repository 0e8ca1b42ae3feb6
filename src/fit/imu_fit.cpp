#include "piste/fit/imu_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "fit/reference_errors.h"
#include "math/linear_algebra.h"
#include "model/imu_errors.h"
#include "piste/core/error.h"
#include "piste/math/interruption.h"

namespace piste {
namespace {

constexpr std::array<std::string_view, 6> kAxes{"fx", "fy", "fz", "wx", "wy", "wz"};
constexpr int kFewest = 30;         // samples of a phase
constexpr double kMostRatio = 1e6;  // of the variances of two noises: beyond it one of them is negligible

using Errors = Eigen::Matrix<double, Eigen::Dynamic, ReferenceErrors::kSize>;

// One axis of both IMUs in one phase.
struct Signals {
  Eigen::VectorXd measured, reference;
  Errors errors;                               // D: how the reference depends on its errors p
  ReferenceErrors::Covariance P_errors, root;  // root rootᵀ = P_errors
};

using Rows = std::vector<std::size_t>;

Rows usable_rows(const AlignedImus& imus, const Interval& phase, std::string_view name) {
  Rows rows;
  for (std::size_t i = 0; i < imus.time.size(); ++i) {
    if (imus.usable[i] && phase.contains(imus.time[i])) rows.push_back(i);
  }
  if (rows.size() < kFewest) {
    const std::string span = imus.time.empty() ? ""
                                               : fmt::format("; both have samples from {:.3f} to {:.3f} s",
                                                             imus.time.front(), imus.time.back());
    throw DataError("", fmt::format("{} from {:.3f} to {:.3f} s: {} samples of both IMUs are usable, at least {} are "
                                    "needed{}",
                                    name, phase.start, phase.end, rows.size(), kFewest, span));
  }
  return rows;
}

// A row of three for each of the rows.
Eigen::MatrixX3d part(const std::vector<Vector3d>& signal, const Rows& rows) {
  Eigen::MatrixX3d out(rows.size(), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) out.row(static_cast<Eigen::Index>(i)) = signal[rows[i]].transpose();
  return out;
}

Errors errors_of(const ReferenceErrors& errors, int axis, const Rows& rows) {
  Errors D(rows.size(), ReferenceErrors::kSize);
  for (std::size_t i = 0; i < rows.size(); ++i) D.row(static_cast<Eigen::Index>(i)) = errors.row(rows[i], axis);
  return D;
}

// L with L Lᵀ = P, which may be singular.
ReferenceErrors::Covariance root_of(const ReferenceErrors::Covariance& P) {
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse = (sigma.array() > 0).select(sigma.cwiseInverse(), 0);
  const Eigensystem eigen = eigensystem(inverse.asDiagonal() * P * inverse.asDiagonal());
  return sigma.asDiagonal() * eigen.vectors * eigen.values.cwiseMax(0).cwiseSqrt().asDiagonal();
}

Signals signals(const AlignedImus& imus, const ReferenceErrors& errors, int axis, const Rows& rows) {
  const bool force = axis < 3;
  return {part(force ? imus.accel : imus.gyro, rows).col(axis % 3),
          part(force ? imus.reference_accel : imus.reference_gyro, rows).col(axis % 3), errors_of(errors, axis, rows),
          errors.covariance(axis), root_of(errors.covariance(axis))};
}

BiasScale line(const Regression& fit) {
  return {.value = fit.value - Eigen::Vector2d(0, 1),
          .covariance = fit.covariance,
          .hac_covariance = fit.hac_covariance,
          .dof = fit.dof,
          .averages = fit.averages};
}

// The effect of D p on bias and scale of the line on the reference: a column for each element of p.
using LineEffect = Eigen::Matrix<double, 2, ReferenceErrors::kSize>;

LineEffect line_effect(const Signals& s, double x0, const ReferenceErrors::Row& at_x0) {
  const Eigen::VectorXd dx = s.reference.array() - x0;
  LineEffect G;
  G.row(1) = dx.transpose() * (s.errors.rowwise() - at_x0) / dx.squaredNorm();
  G.row(0) = at_x0 - x0 * G.row(1);
  return G;
}

// A phase as a point: its means, and the uncertainty of measured − reference.
struct Point {
  double measured, reference;
  ReferenceErrors::Row errors;
  Term excess;
};

Term mean_excess(const Signals& s, const ReferenceErrors::Row& errors) {
  Term out = regress_mean(s.measured - s.reference).term(0);
  out.systematic = std::sqrt((errors * s.P_errors * errors.transpose()).value());
  out.effects = (errors * s.root).transpose();
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
  out.averages = from_slope * fit.averages.row(0);
  return out;
}

// Variance of the IMU's noise divided by that of the reference's, at rest, where both see the same sway.
std::optional<double> noise_ratio(const Signals& rest) {
  const Eigen::VectorXd m = rest.measured.array() - rest.measured.mean();
  const Eigen::VectorXd r = rest.reference.array() - rest.reference.mean();
  const double common = m.dot(r), noise_m = m.squaredNorm() - common, noise_r = r.squaredNorm() - common;
  if (noise_m + noise_r <= 0) return std::nullopt;
  return noise_r > 0 ? std::clamp(noise_m / noise_r, 1 / kMostRatio, kMostRatio) : kMostRatio;
}

double noise_ratio(const FitOptions& options, bool force) {
  if (!options.sensor || !options.reference) return kMostRatio;
  const auto density = [force](const ImuSensor& sensor) { return (force ? sensor.accel : sensor.gyro).noise; };
  if (density(*options.reference) == 0) return kMostRatio;
  return std::clamp(std::pow(density(*options.sensor) / density(*options.reference), 2), 1 / kMostRatio, kMostRatio);
}

// The effect of D p on the coefficients of the columns of X: a column for each element of p.
Eigen::MatrixXd effect(const Eigen::MatrixXd& X, const Eigen::MatrixXd& D) { return least_squares(X, D); }

// The fit, or nothing if the data do not determine it.
template <class Fit>
auto if_determined(const Fit& fit) -> std::optional<decltype(fit())> {
  try {
    return fit();
  } catch (const DataError&) {
    return std::nullopt;
  }
}

PolynomialFit fit_polynomial(const Signals& s) {
  const Eigen::VectorXd excess = s.measured - s.reference;
  std::array<Regression, PolynomialFit::kHighest> fits;
  PolynomialFit out;
  out.effective_samples = static_cast<double>(excess.size());
  for (int order = 1; order <= PolynomialFit::kHighest; ++order) {
    Regression& fit = fits[static_cast<std::size_t>(order - 1)];
    fit = regress_polynomial(s.reference, excess, order);
    if (order > 1) out.effective_samples = std::min(out.effective_samples, fit.effective_samples(order));
  }
  out.effective_samples = std::max(out.effective_samples, PolynomialFit::kHighest + 2.0);
  const double m = out.effective_samples, n = static_cast<double>(excess.size());
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const double p = static_cast<double>(i) + 2;
    out.bic[i] = m * std::log(fits[i].residual * fits[i].residual * (n - p) / n) + p * std::log(m);
  }
  const auto best = std::min_element(out.bic.begin(), out.bic.end()) - out.bic.begin();
  out.order = static_cast<int>(best) + 1;

  const Eigen::Index p = out.order + 1;
  const double mean = s.reference.mean();
  Eigen::MatrixXd powers(excess.size(), p);
  Eigen::Matrix<double, 2, Eigen::Dynamic> tangent(2, p);
  for (int j = 0; j < p; ++j) {
    powers.col(j) = s.reference.array().pow(j);
    tangent.col(j) << (1 - j) * std::pow(mean, j), j == 0 ? 0 : j * std::pow(mean, j - 1);
  }
  const Eigen::MatrixXd G = effect(powers, s.errors);
  out.coefficients = {fits[static_cast<std::size_t>(best)], G * s.P_errors * G.transpose(), G * s.root};
  out.tangent = out.coefficients.line(tangent);
  return out;
}

MatrixFit fit_matrix(const AlignedImus& imus, const ReferenceErrors& errors, bool force, bool g_sensitivity,
                     const Rows& rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  const Eigen::MatrixX3d reference = part(force ? imus.reference_accel : imus.reference_gyro, rows);
  Eigen::MatrixXd X(n, g_sensitivity ? 7 : 4);
  X.leftCols(4) << Eigen::VectorXd::Ones(n), reference;
  if (g_sensitivity) X.rightCols(3) = part(imus.reference_accel, rows);
  constexpr Eigen::Index size = ReferenceErrors::kSize;
  Eigen::MatrixXd D(n, 3 * size);
  const int first = force ? 0 : 3;
  for (int k = 0; k < 3; ++k) {
    D.middleCols<size>(k * size) = errors_of(errors, first + k, rows);
  }
  const auto fits = regress_each(X, part(force ? imus.accel : imus.gyro, rows) - reference);
  const Eigen::MatrixXd G = effect(X, D);
  MatrixFit out;
  for (int k = 0; k < 3; ++k) {
    const Eigen::MatrixXd G_k = G.middleCols<size>(k * size);
    const auto i = static_cast<std::size_t>(k);
    const ReferenceErrors::Covariance P = errors.covariance(first + k);
    out.axes[i] = {fits[i], G_k * P * G_k.transpose(), G_k * root_of(P)};
  }
  return out;
}

// Adds the uncertainty by the in-run drift between the mean of the rest and the mean of the run.
void let_drift(Term& excess, const FitOptions& options, bool force, const Interval& run, const Interval& rest) {
  if (!options.sensor) return;
  const double gap = std::max({0.0, run.start - rest.end, rest.start - run.end});
  const DriftProcess& drift = force ? options.sensor->accel.drift : options.sensor->gyro.drift;
  excess.standard_error =
      std::hypot(excess.standard_error, change_sigma(drift, rest.end - rest.start, gap, run.end - run.start));
}

RunFit fit_run(const Signals& s, const std::optional<Point>& rest, double ratio) {
  RunFit out;
  const Point mean = mean_point(s);
  out.samples = static_cast<int>(s.measured.size());
  out.mean = mean.reference;
  out.rms = std::sqrt(s.reference.squaredNorm() / out.samples);
  out.bias_only = mean.excess;
  const auto both = [&s](const BiasScale& reverse, const BiasScale& inverse, const LineEffect& G) {
    BothDirections lines{reverse, correction(inverse)};
    lines.reverse.systematic_covariance = lines.forward.systematic_covariance = G * s.P_errors * G.transpose();
    lines.reverse.effects = lines.forward.effects = G * s.root;
    return lines;
  };
  out.joint = both(line(regress_line(s.reference, s.measured)), line(regress_line(s.measured, s.reference)),
                   line_effect(s, mean.reference, mean.errors));
  out.noise_ratio = ratio;
  out.both_noisy = line(regress_both_noisy(s.reference, s.measured, ratio));
  out.both_noisy.systematic_covariance = out.joint.reverse.systematic_covariance;
  out.both_noisy.effects = out.joint.reverse.effects;
  out.polynomial = if_determined([&] { return fit_polynomial(s); });
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
  const auto row = [i](const auto& of) -> Eigen::VectorXd { return of.row(i).transpose(); };
  return {.value = value(i),
          .sigma = std::sqrt(covariance(i, i)),
          .standard_error = std::sqrt(hac_covariance(i, i)),
          .dof = dof,
          .systematic = std::sqrt(systematic_covariance(i, i)),
          .averages = row(averages),
          .effects = row(effects)};
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
  return {Eigen::Vector2d(-bias / slope, -line.value(1) / slope),
          J * line.covariance * J.transpose(),
          J * line.hac_covariance * J.transpose(),
          J * line.systematic_covariance * J.transpose(),
          line.dof,
          J * line.averages,
          J * line.effects};
}

Term Coefficients::term(int i) const {
  Term out = regression.term(i);
  out.systematic = std::sqrt(systematic_covariance(i, i));
  if (effects.cols() > 0) out.effects = effects.row(i).transpose();
  return out;
}

BiasScale Coefficients::line(const Eigen::Matrix<double, 2, Eigen::Dynamic>& J) const {
  BiasScale out{J * regression.value, J * regression.covariance * J.transpose(),
                J * regression.hac_covariance * J.transpose(), J * systematic_covariance * J.transpose(),
                regression.dof};
  if (regression.averages.cols() > 0) out.averages = J * regression.averages;
  if (effects.cols() > 0) out.effects = J * effects;
  return out;
}

BiasScale MatrixFit::line(int axis) const {
  const Coefficients& of = axes[static_cast<std::size_t>(axis)];
  Eigen::Matrix<double, 2, Eigen::Dynamic> J = Eigen::MatrixXd::Zero(2, of.regression.value.size());
  J(0, kBias) = J(1, kGain + axis) = 1;
  return of.line(J);
}

Findings findings(const AlignedImus& imus, const Phases& phases, const FitOptions& options) {
  const ReferenceErrors errors(imus, options.alignment, options.reference);
  const auto rows = [&](const std::optional<Interval>& phase, std::string_view name) -> std::optional<Rows> {
    if (!phase) return std::nullopt;
    return usable_rows(imus, *phase, name);
  };
  const std::optional<Rows> before = rows(phases.before, "the rest before"), run = rows(phases.run, "the run"),
                            after = rows(phases.after, "the rest after");
  Findings out{phases, imus.low_pass, {}, {}, {}};
  for (int axis = 0; axis < 6; ++axis) {
    check_interruption();
    AxisFindings& a = out.axes[static_cast<std::size_t>(axis)];
    a.name = kAxes[static_cast<std::size_t>(axis)];
    if (axis >= 3) a.bias_block = Block::kGyroBias, a.scale_block = Block::kGyroScale;
    std::optional<Point> start, stop;
    std::optional<double> ratio;
    const auto rest = [&](const Rows& at) {
      const Signals s = signals(imus, errors, axis, at);
      if (!ratio) ratio = noise_ratio(s);
      Point point = mean_point(s);
      point.excess.averages = {};  // of other rows than those of the run
      return point;
    };
    if (before) start = rest(*before), a.before = start->excess;
    if (after) stop = rest(*after), a.after = stop->excess;
    if (start || stop) a.rest_signal = (start ? start : stop)->reference;
    if (start && stop) {
      a.change = difference(*a.after, *a.before);
      const ReferenceErrors::Row moved = stop->errors - start->errors;  // a bias of the reference cancels
      a.change->systematic = std::sqrt((moved * errors.covariance(axis) * moved.transpose()).value());
    }
    if (run) {
      std::optional<Point> point = start ? start : stop;
      if (point) let_drift(point->excess, options, axis < 3, *phases.run, start ? *phases.before : *phases.after);
      a.run = fit_run(signals(imus, errors, axis, *run), point, ratio.value_or(noise_ratio(options, axis < 3)));
    }
  }
  if (run) {
    const auto matrix = [&](bool force) {
      return if_determined([&] { return fit_matrix(imus, errors, force, !force && options.g_sensitivity, *run); });
    };
    out.accel_matrix = matrix(true);
    out.gyro_matrix = matrix(false);
  }
  return out;
}

}  // namespace piste
