#pragma once
/// A study of a made-up campaign: three IMUs, nine runs, every method, small and plausible numbers.

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "piste/math/units.h"
#include "piste/study/study_findings.h"
#include "support/random.h"

namespace piste::test {

/// Estimates of one IMU in one run: its errors, with noise of the size typical for each method. kMarkovSmoothed
/// navigates best, by a wide margin; kRest second.
struct StudyCase {
  std::size_t runs = 9, sensors = 3;
  bool simulated = true;  ///< whether the truth is known
  bool failed = false;    ///< the last IMU in the last run, and the rest after the first run
  std::uint64_t seed = 1;

  /// Off-diagonal elements of the matrices of all sensors: those of accelerometers that define the axes, those of the
  /// gyroscopes, and the rotation of the boresight that a run has beside them.
  static Matrix3d accel_cross_axis() { return (Matrix3d() << 0, 0, 0, 0.004, 0, 0, -0.003, 0.002, 0).finished(); }
  static Matrix3d gyro_cross_axis() {
    return (Matrix3d() << 0, 0.005, -0.001, 0.003, 0, 0.006, 0.001, -0.004, 0).finished();
  }

  Study study() const {
    Random random(seed);
    Study out{"nine <runs> & more", 12, simulated, {}, {}, {}, {}};
    std::vector<Errors> errors;
    for (std::size_t s = 0; s < sensors; ++s) {
      out.sensors.push_back(fmt::format("MT-9A {}", s + 1));
      Errors e;
      for (std::size_t axis = 0; axis < kSignals; ++axis) {
        e.bias[axis] = random.gaussian(axis < 3 ? 0.05 : 0.5 / kDegreesPerRadian);
        e.scale[axis] = random.gaussian(axis < 3 ? 0.01 : 0.003);
      }
      errors.push_back(e);
    }
    for (std::size_t r = 0; r < runs; ++r) {
      StudyRun run;
      run.activity = r % 3 == 2 ? "bicycle" : "ski";
      run.name = fmt::format("{}-{}", run.activity, r + 1);
      run.phases = {Interval{1000, 1005}, Interval{1005, 1015}, Interval{1015, 1020}};
      run.sigma_attitude = Vector3d(0.02, 0.02, 0.05) / kDegreesPerRadian;
      run.sigma_position = 0.02;
      run.outages = 2;
      out.runs.push_back(run);
      for (std::size_t s = 0; s < sensors; ++s) {
        if (failed && s + 1 == sensors && r + 1 == runs) {
          SensorRun nothing;
          nothing.run = r;
          nothing.sensor = s;
          nothing.failure = "mt9a_3.csv:1: no sample";
          out.results.push_back(nothing);
          continue;
        }
        Errors e = errors[s];
        for (std::size_t axis = 0; axis < kSignals; ++axis) e.bias[axis] += random.gaussian(0.2 * bias_sigma(axis));
        out.results.push_back(sensor_run(random, r, s, e, run.phases));
        if (failed && r == 0) {
          std::erase_if(out.results.back().estimates, [](const auto& m) { return m.method == Method::kRestAfter; });
          std::erase_if(out.results.back().scores, [](const auto& m) { return m.method == Method::kRestAfter; });
        }
      }
    }
    if (!out.results.empty()) out.results.front().warnings.emplace_back("the plate flexes by 0.2°");
    return out;
  }

 private:
  struct Errors {
    std::array<double, kSignals> bias{}, scale{};
  };
  // Means of the reference's signals: at rest, and in the run.
  static constexpr std::array<double, kSignals> kRestMean{-6.5, -0.2, -7.2, 0, 0, 0};
  static constexpr std::array<double, kSignals> kRunMean{-6.4, -0.2, -7.1, 0.03, 0.08, 0.06};
  static constexpr std::array<double, kSignals> kRunSpread{1.9, 2.1, 1.5, 0.1, 0.15, 0.2};

  static double bias_sigma(std::size_t axis) { return axis < 3 ? 0.01 : 0.05 / kDegreesPerRadian; }

  static Term term(Random& random, double truth, double sigma) {
    return {truth + random.gaussian(sigma), 0.1 * sigma, 0.8 * sigma, 30, 0.6 * sigma};
  }

  // A line through the mean signal, with the sigma `sigma` there; its slope has sigma over the signal's spread.
  static BiasScale line(Random& random, const Errors& e, std::size_t axis, double sigma, double attenuation = 0) {
    const double mean = kRunMean[axis], slope_sigma = sigma / kRunSpread[axis];
    const double at_mean = random.gaussian(sigma), slope = random.gaussian(slope_sigma) + attenuation;
    BiasScale out;
    out.value << e.bias[axis] + at_mean - mean * slope, e.scale[axis] + slope;
    const Eigen::Matrix2d T = (Eigen::Matrix2d() << 1, -mean, 0, 1).finished();
    const Eigen::Matrix2d P =
        T * Eigen::Vector2d(sigma * sigma, slope_sigma * slope_sigma).asDiagonal() * T.transpose();
    out.covariance = 0.01 * P;
    out.hac_covariance = 0.64 * P;
    out.systematic_covariance = 0.36 * P;
    out.dof = 30;
    return out;
  }

  AxisEstimate estimate(Random& random, Method method, const Errors& e, std::size_t axis) const {
    AxisEstimate out;
    const double sigma = 0.3 * bias_sigma(axis), bias = e.bias[axis], scale = e.scale[axis];
    const bool rest = method == Method::kRest || method == Method::kRestAfter;
    if (rest || method == Method::kBiasOnly) {
      const double seen = bias + scale * (rest ? kRestMean[axis] : kRunMean[axis]);
      out.bias_alone = term(random, seen, sigma);
      if (simulated) out.true_bias = seen;
      return out;
    }
    out.line = line(random, e, axis, method == Method::kTruth ? 0 : sigma,
                    method == Method::kJoint ? (axis < 3 ? 0.01 : 0.002) : 0);
    if (simulated) {
      out.true_bias = bias;
      out.true_scale = scale;
    }
    return out;
  }

  // How much worse than the truth a replay with these errors is.
  static double badness(Method method) {
    static const std::map<Method, double> kKnown{{Method::kNothing, 3},       {Method::kTruth, 1},
                                                 {Method::kInTheFilter, 1.3}, {Method::kMarkovSmoothed, 1.05},
                                                 {Method::kRest, 1.4},        {Method::kOtherRuns, 1.5}};
    const auto found = kKnown.find(method);
    return found == kKnown.end() ? 1.6 + 0.03 * static_cast<double>(method) : found->second;
  }

  SensorRun sensor_run(Random& random, std::size_t run, std::size_t sensor, const Errors& e,
                       const Phases& phases) const {
    SensorRun out;
    out.run = run;
    out.sensor = sensor;
    out.clock_offset = 2.5 + random.gaussian(0.1);
    out.clock_drift = 20e-6;
    out.boresight = random.vector(0.01);
    out.sigma_boresight.setConstant(5e-4);
    out.lever_arm = {0.07, 0.05 * static_cast<double>(sensor), -0.01};
    for (const MethodInfo& m : kMethods) {
      if (m.estimates.empty() || (m.method == Method::kTruth && !simulated)) continue;
      MethodEstimate estimates{m.method, {}};
      for (std::size_t axis = 0; axis < kSignals; ++axis) {
        estimates.axes[axis] = estimate(random, m.method, e, axis);
      }
      out.estimates.push_back(estimates);
    }
    const double hardness = std::exp(random.gaussian(0.2));
    for (const MethodInfo& m : kMethods) {
      if (m.method == Method::kTruth && !simulated) continue;
      const double size = hardness * badness(m.method) * std::exp(random.gaussian(0.05));
      out.scores.push_back({m.method, 0.4 * size, 0.1 * size, 0.3 / kDegreesPerRadian * size, 4 * size});
    }
    out.findings = found(out, phases);
    for (const double delay : {-0.02, -0.01, -0.005, 0.0, 0.005, 0.01, 0.02}) {
      TimingEffect effect{delay, {}, {}};
      for (std::size_t axis = 0; axis < kSignals; ++axis) {
        const double lost = 200 * delay * delay * (1 + random.gaussian(0.05));
        effect.forward[axis] = e.scale[axis] + lost;
        effect.reverse[axis] = e.scale[axis] - lost;
      }
      out.timing.push_back(effect);
    }
    if (sensor == 0) out.picture = picture(random, e, phases);
    return out;
  }

  static MatrixFit matrix(const Matrix3d& gains) {
    MatrixFit out;
    for (int axis = 0; axis < 3; ++axis) {
      Coefficients& c = out.axes[static_cast<std::size_t>(axis)];
      c.regression.value.setZero(4);
      c.regression.value.tail<3>() = gains.row(axis).transpose();
      c.regression.covariance = c.regression.hac_covariance = 1e-8 * Eigen::MatrixXd::Identity(4, 4);
      c.regression.inflation.setOnes(4);
      c.regression.dof = 12;
      c.systematic_covariance = 1e-8 * Eigen::MatrixXd::Identity(4, 4);
    }
    return out;
  }

  static Findings found(const SensorRun& run, const Phases& phases) {
    Findings out{phases, 12, {}, {}, {}};
    const Matrix3d turned = skew(0.1 * run.boresight);
    out.accel_matrix = matrix(accel_cross_axis() + turned);
    out.gyro_matrix = matrix(gyro_cross_axis() + turned);
    for (int axis = 0; axis < kSignals; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      AxisFindings& a = out.axes[at];
      a.name = kSignalNames[at];
      if (axis >= 3) a.bias_block = Block::kGyroBias, a.scale_block = Block::kGyroScale;
      a.before = run.estimate(Method::kRest, axis)->bias_alone;
      a.after = run.estimate(Method::kRestAfter, axis)->bias_alone;
      a.change = difference(*a.after, *a.before);
      RunFit fit;
      fit.samples = 1000;
      fit.mean = kRunMean[at];
      fit.rms = std::hypot(kRunMean[at], kRunSpread[at]);
      fit.residual = bias_sigma(at);
      fit.bias_only = *run.estimate(Method::kBiasOnly, axis)->bias_alone;
      fit.joint = {*run.estimate(Method::kJointReverse, axis)->line, *run.estimate(Method::kJoint, axis)->line};
      const BiasScale& scale_only = *run.estimate(Method::kScaleOnly, axis)->line;
      fit.scale_only = BothDirections{scale_only, scale_only};
      a.run = fit;
    }
    return out;
  }

  static SignalPicture picture(Random& random, const Errors& e, const Phases& phases) {
    SignalPicture out;
    for (double t = phases.before->start; t < phases.after->end; t += 0.1) {
      out.time.push_back(t);
      for (std::size_t axis = 0; axis < kSignals; ++axis) {
        const double motion = 1.4 * kRunSpread[axis] * std::sin(2 * t + static_cast<double>(axis));
        const double reference = phases.run->contains(t) ? kRunMean[axis] + motion : kRestMean[axis];
        out.reference[axis].push_back(reference);
        out.measured[axis].push_back((1 + e.scale[axis]) * reference + e.bias[axis] +
                                     random.gaussian(bias_sigma(axis)));
      }
    }
    return out;
  }
};

}  // namespace piste::test
