// Known biases and scales come back, within intervals that hold them as often as they say, and where theory says that
// an estimate is wrong, it is wrong by what theory says.

#include "piste/analyse/imu_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "piste/core/error.h"
#include "support/aligned_run.h"

namespace piste {
namespace {

Phases phases_of(const test::AlignedRun& run) { return {run.before(), run.moving(), run.after()}; }

double truth(const test::AlignedRun& run, std::size_t axis, bool scale) {
  const auto i = static_cast<Eigen::Index>(axis % 3);
  if (axis < 3) return scale ? run.accel_scale(i) : run.accel_bias(i);
  return scale ? run.gyro_scale(i) : run.gyro_bias(i);
}

TEST(ImuFit, IntervalsHoldTheTruthUnderNoiseThatLasts) {
  test::AlignedRun run{.persistence = 0.9};
  run.rest = 20;
  run.run = 30;
  std::map<std::string, double> inside;
  double formal = 0, count = 0;
  constexpr int kSeeds = 40;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Findings found = findings(run.simulate(static_cast<std::uint64_t>(seed)), phases_of(run), {.low_pass = 0});
    for (std::size_t i = 0; i < 6; ++i) {
      const AxisFindings& a = found.axes[i];
      const auto hit = [&](const char* name, const Term& term, double right) {
        inside[name] += std::abs(term.value - right) < term.half_width(0.95);
      };
      const double bias = truth(run, i, false), scale = truth(run, i, true);
      const double gravity = i < 3 ? Vector3d(-2, 0.1, -9.6)(static_cast<Eigen::Index>(i)) : 0;
      hit("rest before", *a.before, bias + scale * gravity);
      hit("rest after", *a.after, bias + scale * gravity);
      hit("change", *a.change, 0);
      hit("joint bias", a.run->joint.reverse.bias(), bias);
      hit("joint scale", a.run->joint.reverse.scale(), scale);
      hit("scale only", a.run->scale_only->reverse.scale(), scale);
      hit("its bias", a.run->scale_only->reverse.bias(), bias);
      hit("bias only", a.run->bias_only, bias + scale * a.run->mean);
      formal += std::abs(a.run->joint.reverse.scale().value - scale) < 1.96 * a.run->joint.reverse.scale().sigma;
      count += 1;
    }
  }
  ASSERT_EQ(inside.size(), 8U);
  for (const auto& [name, hits] : inside) {
    EXPECT_GT(hits / count, 0.9) << name;
    EXPECT_LT(hits / count, name == "bias only" ? 1.01 : 0.99) << name;  // it takes scale · motion for noise
    RecordProperty(name, std::to_string(hits / count));
  }
  EXPECT_LT(formal / count, 0.6) << "the formal sigma takes every sample for a new one";
}

TEST(ImuFit, LowPassedSignalsGiveTheSameAnswerAndTrueIntervals) {
  test::AlignedRun run;
  run.rest = 20;
  run.run = 30;
  double inside = 0, count = 0;
  for (int seed = 1; seed <= 40; ++seed) {
    const Findings found = findings(run.simulate(static_cast<std::uint64_t>(seed)), phases_of(run), {.low_pass = 12});
    for (std::size_t i = 0; i < 6; ++i) {
      for (const bool scale : {false, true}) {
        const BiasScale& joint = found.axes[i].run->joint.reverse;
        const Term term = scale ? joint.scale() : joint.bias();
        inside += std::abs(term.value - truth(run, i, scale)) < term.half_width(0.95);
        count += 1;
      }
    }
  }
  EXPECT_GT(inside / count, 0.9);
  EXPECT_LT(inside / count, 0.99);
}

// Without noise every estimate is exact, and the identity that links the article's tables holds: b of bias only is
// b of the joint fit + scale · mean signal.
TEST(ImuFit, ExactWithoutNoise) {
  const test::AlignedRun run{.gyro_noise = 0, .accel_noise = 0};
  const Findings found = findings(run.simulate(1), phases_of(run), {.low_pass = 0});
  for (std::size_t i = 0; i < 6; ++i) {
    const RunFit& fit = *found.axes[i].run;
    const double bias = truth(run, i, false), scale = truth(run, i, true);
    for (const BothDirections& both : {fit.joint, *fit.scale_only}) {
      for (const BiasScale& line : {both.forward, both.reverse}) {
        EXPECT_NEAR(line.value(0), bias, 1e-9) << found.axes[i].name;
        EXPECT_NEAR(line.value(1), scale, 1e-9) << found.axes[i].name;
      }
    }
    EXPECT_NEAR(fit.bias_only.value, bias + scale * fit.mean, 1e-9);
    EXPECT_NEAR(fit.joint.reverse.correlation(), -fit.mean / fit.rms, 1e-9);
    EXPECT_LT(fit.residual, 1e-9);
    EXPECT_EQ(found.axes[i].name, std::string_view("fxfyfzwxwywz").substr(2 * i, 2));
  }
}

// Noise v of the IMU flattens the forward line by var(x) / (var(x) + var(v)); a reference without noise keeps the
// reverse one right. Noise of the reference does the opposite. The truth lies between.
TEST(ImuFit, NoiseFlattensTheLineThatHasItUnderneath) {
  test::AlignedRun run{.gyro_noise = 0.1, .accel_noise = 0.5};
  run.rest = 100;
  run.run = 400;
  for (const double share : {0.0, 0.7}) {
    run.reference_noise = share;
    const Findings found = findings(run.simulate(3), phases_of(run), {.low_pass = 0});
    for (std::size_t i = 0; i < 6; ++i) {
      const RunFit& fit = *found.axes[i].run;
      const double scale = truth(run, i, true), noise = i < 3 ? run.accel_noise : run.gyro_noise;
      const double v = noise * noise, u = share * share * v;
      const double x = fit.rms * fit.rms - fit.mean * fit.mean - u, k = 1 + scale;
      const double forward = 1 / (k * x / (k * k * x + v)) - 1, reverse = k * x / (x + u) - 1;
      EXPECT_NEAR(fit.joint.forward.value(1), forward, 5 * fit.joint.forward.scale().standard_error);
      EXPECT_NEAR(fit.joint.reverse.value(1), reverse, 5 * fit.joint.reverse.scale().standard_error);
      EXPECT_GT(fit.joint.forward.value(1), scale);
      if (share > 0) {
        EXPECT_LT(fit.joint.reverse.value(1), scale) << "the truth lies between";
      }
    }
  }
}

// A residual timing error looks like a scale factor: 1 − cos(2π f d) of each frequency.
TEST(ImuFit, TimingErrorLooksLikeAScaleFactor) {
  test::AlignedRun run{.gyro_scale = {0, 0, 0}, .gyro_noise = 1e-5, .accel_noise = 1e-5};
  run.delay = 0.015;
  const Findings found = findings(run.simulate(1), phases_of(run), {.low_pass = 0});
  const BothDirections& wx = found.axes[3].run->joint;
  const double expected = 1 - std::cos(1.9 * run.delay);
  EXPECT_NEAR(wx.reverse.value(1), -expected, 0.2 * expected);
  EXPECT_NEAR(wx.forward.value(1), expected, 0.2 * expected);
}

TEST(ImuFit, CorrectionIsItsOwnInverseAndTheArticlesSign) {
  const test::AlignedRun run;
  const AlignedImus imus = run.simulate(5);
  const BiasScale line = findings(imus, phases_of(run), {}).axes[2].run->joint.reverse;
  const BiasScale article = correction(line), back = correction(article);
  EXPECT_TRUE(back.value.isApprox(line.value, 1e-12));
  EXPECT_TRUE(back.covariance.isApprox(line.covariance, 1e-9));
  EXPECT_TRUE(back.hac_covariance.isApprox(line.hac_covariance, 1e-9));
  // measured → true by both.
  const double measured = 7;
  const double by_subtraction = (measured - line.value(0)) / (1 + line.value(1));
  EXPECT_NEAR((1 + article.value(1)) * measured + article.value(0), by_subtraction, 1e-12);
  // Its covariance against that of a small change of the line.
  const double step = 1e-6;
  BiasScale moved = line;
  moved.value += step * Eigen::Vector2d(0.3, -0.5);
  const Eigen::Vector2d change = (correction(moved).value - article.value) / step;
  BiasScale along = line;
  along.covariance = Eigen::Vector2d(0.3, -0.5) * Eigen::RowVector2d(0.3, -0.5);
  EXPECT_TRUE(correction(along).covariance.isApprox(change * change.transpose(), 1e-4));
}

TEST(ImuFit, DoesWithWhatThereIs) {
  const test::AlignedRun run;
  AlignedImus imus = run.simulate(2);
  Findings found = findings(imus, {std::nullopt, run.moving(), run.after()}, {});
  EXPECT_FALSE(found.axes[0].before || found.axes[0].change);
  EXPECT_TRUE(found.axes[0].run->scale_only) << "by the rest after";
  found = findings(imus, {std::nullopt, run.moving(), std::nullopt}, {});
  EXPECT_FALSE(found.axes[0].run->scale_only);
  found = findings(imus, {run.before(), std::nullopt, std::nullopt}, {});
  EXPECT_FALSE(found.axes[0].run);
  EXPECT_THROW(findings(imus, {Interval{0, 1}, run.moving(), std::nullopt}, {}), DataError);

  // What is not usable is not used.
  for (std::size_t i = 5000; i < 6000; ++i) {
    imus.usable[i] = 0;
    imus.gyro[i] = imus.accel[i] = Vector3d(1e6, 1e6, 1e6);
  }
  found = findings(imus, phases_of(run), {});
  EXPECT_EQ(found.axes[0].run->samples, 5001);
  for (std::size_t i = 0; i < 6; ++i) {
    const Term scale = found.axes[i].run->joint.reverse.scale();
    EXPECT_NEAR(scale.value, truth(run, i, true), 5 * scale.standard_error);
  }
}

}  // namespace
}  // namespace piste
