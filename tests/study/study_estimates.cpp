#include "study/study_estimates.h"

#include <gtest/gtest.h>

#include <cmath>

namespace piste {
namespace {

Term term(double value, double error) { return {value, error / 2, error, 50, 0}; }

BiasScale line(double bias, double scale) {
  BiasScale out;
  out.value << bias, scale;
  out.covariance = out.hac_covariance = Eigen::Vector2d(1e-4, 1e-6).asDiagonal();
  out.dof = 50;
  return out;
}

// Findings of fx alone.
Findings findings_of_fx() {
  Findings out;
  AxisFindings& fx = out.axes[0];
  fx.before = term(0.3, 0.01);
  fx.rest_signal = -7;
  fx.run.emplace();
  fx.run->bias_only = term(0.25, 0.02);
  fx.run->joint = {line(0.1, -0.02), line(0.11, -0.021)};
  fx.run->both_noisy = line(0.105, -0.0205);
  return out;
}

TEST(StudyEstimates, MethodsThatFindNothingAreLeftOut) {
  const std::vector<MethodEstimate> found = signal_estimates(findings_of_fx());
  std::vector<Method> methods;
  for (const MethodEstimate& e : found) methods.push_back(e.method);
  EXPECT_EQ(methods, (std::vector{Method::kRest, Method::kJoint, Method::kJointReverse, Method::kJointBothNoisy,
                                  Method::kBiasOnly}));
  EXPECT_EQ(found[0].axes[0].bias_alone->value, 0.3);
  EXPECT_EQ(found[1].axes[0].line->value(1), -0.021) << "the article's direction: reference on IMU";
  EXPECT_EQ(found[2].axes[0].line->value(1), -0.02);
  EXPECT_TRUE(found[1].axes[1].empty());
}

TEST(StudyEstimates, WhatAReplayTakesForKnown) {
  const Findings findings = findings_of_fx();
  const std::vector<MethodEstimate> found = signal_estimates(findings);
  const KnownErrors rest = known_errors(found[0], findings), joint = known_errors(found[2], findings);
  EXPECT_EQ(rest.accel.bias, Vector3d(0.3, 0, 0));
  EXPECT_TRUE(rest.accel.gain.isZero(0));
  EXPECT_EQ(joint.accel.bias, Vector3d(0.1, 0, 0));
  EXPECT_EQ(joint.accel.gain(0, 0), -0.02);
  EXPECT_TRUE(joint.gyro.bias.isZero(0));
}

ImuTruth truth() {
  ImuTruth out;
  out.accel = {.bias = {0.1, 0.2, 0.3},
               .scale = {0.01, 0.02, 0.03},
               .misalignment = Matrix3d::Identity(),
               .before = ImuTruth::Phase{{0.001, 0, 0}, {-7, 0, -7}},
               .run = ImuTruth::Phase{{0.002, 0, 0}, {-6, 1, -8}},
               .after = {}};
  out.accel.misalignment(0, 2) = 0.005;
  out.gyro = out.accel;
  return out;
}

TEST(StudyEstimates, TruthAsTheMethodCouldSeeIt) {
  MethodEstimate rest{Method::kRest, {}}, run{Method::kBiasOnly, {}}, joint{Method::kJoint, {}};
  rest.axes[0].bias_alone = run.axes[0].bias_alone = term(0, 1);
  joint.axes[0].line = line(0, 0);
  for (MethodEstimate* e : {&rest, &run, &joint}) hold_against(truth(), *e);
  // measured − true = bias + drift + scale · fx + misalignment · (1 + scale) · fz
  EXPECT_NEAR(*rest.axes[0].true_bias, 0.101 - 7 * 0.01 - 7 * 0.005 * 1.01, 1e-12);
  EXPECT_NEAR(*run.axes[0].true_bias, 0.102 - 6 * 0.01 - 8 * 0.005 * 1.01, 1e-12);
  EXPECT_FALSE(rest.axes[0].true_scale);
  EXPECT_NEAR(*joint.axes[0].true_bias, 0.102, 1e-12);
  EXPECT_NEAR(*joint.axes[0].true_scale, 0.01, 1e-12);
  EXPECT_FALSE(joint.axes[1].true_bias) << "nothing was estimated";
  MethodEstimate after{Method::kRestAfter, {}};
  after.axes[0].bias_alone = term(0, 1);
  hold_against(truth(), after);
  EXPECT_FALSE(after.axes[0].true_bias) << "there was no rest after";
}

TEST(StudyEstimates, ScalesOfTheOtherRunsAreAPrediction) {
  Study study;
  study.sensors = {"a"};
  study.runs.resize(4);
  for (std::size_t run = 0; run < 4; ++run) {
    SensorRun result;
    result.run = run;
    result.findings = findings_of_fx();
    result.findings->axes[0].run->both_noisy.value(1) = 0.01 * static_cast<double>(run);  // 0, .01, .02, .03
    result.estimates = signal_estimates(*result.findings);
    study.results.push_back(std::move(result));
  }
  add_other_runs(study);
  const AxisEstimate* last = study.results[3].estimate(Method::kOtherRuns, 0);
  ASSERT_TRUE(last && last->line);
  EXPECT_NEAR(last->line->value(1), 0.01, 1e-12) << "without its own .03";
  EXPECT_NEAR(last->line->value(0), 0.3 + 7 * 0.01, 1e-12) << "what the rest shows, less scale · signal";
  EXPECT_NEAR(last->line->scale().standard_error, 0.01 * std::sqrt(1 + 1.0 / 3), 1e-12);
  EXPECT_NEAR(last->line->bias().standard_error, std::hypot(0.01, 7 * 0.01 * std::sqrt(1 + 1.0 / 3)), 1e-12);
  EXPECT_EQ(last->line->dof, 2);

  study.results.resize(2);
  for (SensorRun& r : study.results) r.estimates = signal_estimates(*r.findings);
  add_other_runs(study);
  EXPECT_EQ(study.results[0].estimate(Method::kOtherRuns, 0), nullptr) << "one other run has no spread";
}

}  // namespace
}  // namespace piste
