#include "piste/analyse/study_estimates.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace piste {
namespace {

constexpr std::size_t kFewestRuns = 2;  // that tell how a scale changes from run to run

std::size_t at(int axis) { return static_cast<std::size_t>(axis); }

// A method's estimate from what `take` finds of each axis; nothing where it finds nothing at all.
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

KnownTriadErrors triad_of(const MethodEstimate& estimate, int first) {
  KnownTriadErrors out;
  for (int i = 0; i < 3; ++i) {
    const AxisEstimate& axis = estimate.axes[at(first + i)];
    if (axis.bias_alone) out.bias(i) = axis.bias_alone->value;
    if (!axis.line) continue;
    out.bias(i) = axis.line->value(0);
    out.gain(i, i) = axis.line->value(1);
  }
  return out;
}

Matrix3d gain_of(const ImuTruth::Triad& truth) {
  return (Matrix3d::Identity() + Matrix3d(truth.scale.asDiagonal())) * truth.misalignment - Matrix3d::Identity();
}

KnownTriadErrors triad_of(const ImuTruth::Triad& truth) {
  KnownTriadErrors out;
  const auto& phase = truth.run ? truth.run : truth.before;
  out.bias = truth.bias + (phase ? phase->drift : Vector3d::Zero());
  out.gain = gain_of(truth);
  return out;
}

// The phase that a method looks at.
const std::optional<ImuTruth::Phase>& phase_of(const ImuTruth::Triad& truth, Method method) {
  switch (method) {
    case Method::kRest:
    case Method::kOtherRuns:
      return truth.before;
    case Method::kScaleOnly:
      return truth.before ? truth.before : truth.after;
    case Method::kRestAfter:
      return truth.after;
    default:
      return truth.run;
  }
}

// Mean and standard deviation of what is expected of one more number.
struct Prediction {
  double mean, sigma, dof;
};

Prediction predict(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double mean = 0, squares = 0;
  for (const double value : values) mean += value / n;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / (n - 1) * (1 + 1 / n)), n - 1};
}

}  // namespace

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
  alone(Method::kBiasOnly, [](const AxisFindings& axis) -> std::optional<Term> {
    if (!axis.run) return std::nullopt;
    return axis.run->bias_only;
  });
  return out;
}

KnownErrors known_errors(const MethodEstimate& estimate, const std::optional<Findings>&) {
  return {.gyro = triad_of(estimate, 3), .accel = triad_of(estimate, 0)};
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
  for (SensorRun& result : study.results) {
    if (!result.findings) continue;
    MethodEstimate out{Method::kOtherRuns, {}};
    bool any = false;
    for (int axis = 0; axis < kSignals; ++axis) {
      const auto& before = result.findings->axes[at(axis)].before;
      std::vector<double> scales;
      for (const SensorRun& other : study.results) {
        if (other.run == result.run || other.sensor != result.sensor) continue;
        const AxisEstimate* noisy = other.estimate(Method::kJointBothNoisy, axis);
        if (noisy && noisy->line) scales.push_back(noisy->line->value(1));
      }
      if (!before || scales.size() < kFewestRuns) continue;
      const Prediction scale = predict(scales);
      const double signal = result.findings->axes[at(axis)].rest_signal;
      // bias = what the rest shows − scale · signal
      BiasScale line;
      line.value << before->value - scale.mean * signal, scale.mean;
      const Eigen::Vector2d of_scale(-signal, 1), of_rest(1, 0);
      const auto covariance = [&](double rest, double of) -> Eigen::Matrix2d {
        return rest * rest * of_rest * of_rest.transpose() + of * of * of_scale * of_scale.transpose();
      };
      line.covariance = covariance(before->sigma, scale.sigma);
      line.hac_covariance = covariance(before->standard_error, scale.sigma);
      line.systematic_covariance = covariance(before->systematic, 0);
      line.dof = std::min(before->dof, scale.dof);
      AxisEstimate& to = out.axes[at(axis)];
      to.line = line;
      const AxisEstimate* rest = result.estimate(Method::kRest, axis);
      const AxisEstimate* run = result.estimate(Method::kJointReverse, axis);
      if (rest && rest->true_bias && run && run->true_scale) {
        to.true_scale = run->true_scale;
        to.true_bias = *rest->true_bias - *run->true_scale * signal;
      }
      any = true;
    }
    if (any) result.estimates.push_back(std::move(out));
  }
}

}  // namespace piste
