#include "study/study_estimates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "piste/fit/known_errors_of.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr std::size_t kFewestRuns = 2;  // from this number on, the spread of a scale between runs is computed

std::size_t at(int axis) { return static_cast<std::size_t>(axis); }

// The estimate of a method from the results of `take` for each axis. Nothing if all of them are empty.
template <class Take>
void add(std::vector<MethodEstimate>& to, Method method, const Findings& findings, Take&& take) {
  MethodEstimate out{method, {}};
  bool any = false;
  for (int axis = 0; axis < kSignals; ++axis) {
    AxisEstimate& estimate = out.axes[at(axis)];
    take(findings.axes[at(axis)], estimate);
    any = any || !estimate.empty();
  }
  if (any) to.push_back(std::move(out));
}

KnownTriadErrors triad_of(const ImuTruth::Triad& truth) {
  KnownTriadErrors out;
  const auto& phase = truth.run ? truth.run : truth.before;
  out.bias = truth.bias + (phase ? phase->drift : Vector3d::Zero());
  out.gain = gain_of(truth);
  return out;
}

// The phase that a method uses.
const std::optional<ImuTruth::Phase>& phase_of(const ImuTruth::Triad& truth, Method method) {
  switch (method) {
    case Method::kRest:
    case Method::kOtherRuns:
      return truth.before;
    case Method::kRestAfter:
      return truth.after;
    default:
      return truth.run;
  }
}

// The prediction of one more number.
struct Prediction {
  double mean, sigma, dof;
};

Prediction predict(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  return {mean(values), standard_deviation(values) * std::sqrt(1 + 1 / n), n - 1};
}

// The line through the mean point of the rest, with the slope of the IMU's other runs. Nothing without a rest, or with
// too few other runs.
AxisEstimate from_other_runs(const std::vector<SensorRun>& results, const SensorRun& result, int axis) {
  const AxisFindings& found = result.findings->axes[at(axis)];
  std::vector<double> scales;
  for (const SensorRun& other : results) {
    if (other.run == result.run || other.sensor != result.sensor) continue;
    const AxisEstimate* noisy = other.estimate(Method::kJointBothNoisy, axis);
    if (noisy && noisy->line) scales.push_back(noisy->line->value(1));
  }
  if (!found.before || scales.size() < kFewestRuns) return {};
  const Term& rest = *found.before;
  const Prediction scale = predict(scales);
  const double signal = found.rest_signal;
  const Eigen::Vector2d of_scale(-signal, 1), of_rest(1, 0);
  const auto covariance = [&](double rest_sigma, double scale_sigma) -> Eigen::Matrix2d {
    return rest_sigma * rest_sigma * of_rest * of_rest.transpose() +
           scale_sigma * scale_sigma * of_scale * of_scale.transpose();
  };
  AxisEstimate out;
  out.line = BiasScale{{rest.value - scale.mean * signal, scale.mean},
                       covariance(rest.sigma, scale.sigma),
                       covariance(rest.standard_error, scale.sigma),
                       covariance(rest.systematic, 0),
                       std::min(rest.dof, scale.dof)};
  const AxisEstimate *shown = result.estimate(Method::kRest, axis), *run = result.estimate(Method::kJointReverse, axis);
  if (shown && shown->true_bias && run && run->true_scale) {
    out.true_scale = run->true_scale;
    out.true_bias = *shown->true_bias - *run->true_scale * signal;
  }
  return out;
}

void add_other_runs(std::vector<SensorRun>& results) {
  for (SensorRun& result : results) {
    MethodEstimate out{Method::kOtherRuns, {}};
    bool any = false;
    for (int axis = 0; axis < kSignals; ++axis) {
      AxisEstimate& to = out.axes[at(axis)];
      if (result.findings) to = from_other_runs(results, result, axis);
      any = any || !to.empty();
    }
    if (any) result.estimates.push_back(std::move(out));
  }
}

}  // namespace

Matrix3d gain_of(const ImuTruth::Triad& truth) {
  return (Matrix3d::Identity() + Matrix3d(truth.scale.asDiagonal())) * truth.misalignment - Matrix3d::Identity();
}

std::vector<MethodEstimate> signal_estimates(const Findings& findings) {
  std::vector<MethodEstimate> out;
  const auto alone = [&](Method method, auto&& term) {
    add(out, method, findings, [&](const AxisFindings& axis, AxisEstimate& to) { to.bias_alone = term(axis); });
  };
  const auto line = [&](Method method, auto&& of_run) {
    add(out, method, findings, [&](const AxisFindings& axis, AxisEstimate& to) {
      if (axis.run) to.line = of_run(*axis.run);
    });
  };
  alone(Method::kRest, [](const AxisFindings& axis) { return axis.before; });
  alone(Method::kRestAfter, [](const AxisFindings& axis) { return axis.after; });
  line(Method::kScaleOnly, [](const RunFit& run) -> std::optional<BiasScale> {
    if (!run.scale_only) return std::nullopt;
    return run.scale_only->reverse;
  });
  line(Method::kJoint, [](const RunFit& run) { return run.joint.forward; });
  line(Method::kJointReverse, [](const RunFit& run) { return run.joint.reverse; });
  line(Method::kJointBothNoisy, [](const RunFit& run) { return run.both_noisy; });
  alone(Method::kBiasOnly, [](const AxisFindings& axis) -> std::optional<Term> {
    if (!axis.run) return std::nullopt;
    return axis.run->bias_only;
  });
  line(Method::kPolynomial, [](const RunFit& run) -> std::optional<BiasScale> {
    if (!run.polynomial) return std::nullopt;
    return run.polynomial->tangent;
  });
  MethodEstimate matrix{Method::kMisalignment, {}};
  for (int axis = 0; axis < kSignals; ++axis) {
    const auto& triad = axis < 3 ? findings.accel_matrix : findings.gyro_matrix;
    if (triad) matrix.axes[at(axis)].line = triad->line(axis % 3);
  }
  if (findings.accel_matrix || findings.gyro_matrix) out.push_back(std::move(matrix));
  return out;
}

KnownErrors known_errors(const MethodEstimate& estimate, const std::optional<Findings>& findings) {
  if (estimate.method == Method::kMisalignment)
    return errors_of_matrices(findings->accel_matrix, findings->gyro_matrix);
  if (estimate.method == Method::kPolynomial) {
    std::array<std::optional<PolynomialFit>, kSignals> polynomials;
    for (std::size_t axis = 0; axis < polynomials.size(); ++axis) {
      if (const auto& run = findings->axes[axis].run) polynomials[axis] = run->polynomial;
    }
    return errors_of_polynomials(polynomials);
  }
  std::array<std::optional<BiasScale>, kSignals> lines;
  for (std::size_t axis = 0; axis < lines.size(); ++axis) {
    const AxisEstimate& found = estimate.axes[axis];
    lines[axis] = found.line;
    if (found.bias_alone) lines[axis] = BiasScale{.value = {found.bias_alone->value, 0}};
  }
  return errors_of_lines(lines);
}

KnownErrors known_errors(const ImuTruth& truth) {
  return {.gyro = triad_of(truth.gyro), .accel = triad_of(truth.accel)};
}

void hold_against(const ImuTruth& truth, MethodEstimate& estimate) {
  for (int axis = 0; axis < kSignals; ++axis) {
    const ImuTruth::Triad& triad = axis < 3 ? truth.accel : truth.gyro;
    const int i = axis % 3;
    const auto& phase = phase_of(triad, estimate.method);
    AxisEstimate& to = estimate.axes[at(axis)];
    if (!phase || to.empty()) continue;
    const Matrix3d gain = gain_of(triad);
    to.true_bias = triad.bias(i) + phase->drift(i) + (to.bias_alone ? gain.row(i).dot(phase->signal) : 0);
    if (to.line) to.true_scale = gain(i, i);
  }
}

void add_other_runs(Study& study) {
  add_other_runs(study.results);
  add_other_runs(study.as_one);
}

}  // namespace piste
