// Known biases and scales come back, within intervals that hold them as often as they say, and where theory says that
// an estimate is wrong, it is wrong by what theory says.

#include "piste/fit/imu_fit.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>

#include "piste/condition/aligned_signals.h"
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
    const Findings found = findings(run.simulate(static_cast<std::uint64_t>(seed)), phases_of(run), {});
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
      hit("tangent's bias", a.run->polynomial->tangent.bias(), bias);
      hit("tangent's scale", a.run->polynomial->tangent.scale(), scale);
      formal += std::abs(a.run->joint.reverse.scale().value - scale) < 1.96 * a.run->joint.reverse.scale().sigma;
      count += 1;
    }
  }
  ASSERT_EQ(inside.size(), 10U);
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
    const Findings found = findings(low_passed(run.simulate(static_cast<std::uint64_t>(seed)), 12), phases_of(run), {});
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
  const Findings found = findings(run.simulate(1), phases_of(run), {});
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
    const Findings found = findings(run.simulate(3), phases_of(run), {});
    for (std::size_t i = 0; i < 6; ++i) {
      const RunFit& fit = *found.axes[i].run;
      const double scale = truth(run, i, true), noise = i < 3 ? run.accel_noise : run.gyro_noise;
      const double v = noise * noise, u = share * share * v;
      const double x = fit.rms * fit.rms - fit.mean * fit.mean - u, k = 1 + scale;
      const double forward = 1 / (k * x / (k * k * x + v)) - 1, reverse = k * x / (x + u) - 1;
      EXPECT_NEAR(fit.joint.forward.value(1), forward, 5 * fit.joint.forward.scale().standard_error);
      EXPECT_NEAR(fit.joint.reverse.value(1), reverse, 5 * fit.joint.reverse.scale().standard_error);
      EXPECT_GT(fit.joint.forward.value(1), scale);
      EXPECT_NEAR(fit.both_noisy.value(1), scale, 5 * fit.both_noisy.scale().standard_error);
      EXPECT_LT(fit.both_noisy.value(1), fit.joint.forward.value(1));
      if (share > 0) {
        EXPECT_LT(fit.joint.reverse.value(1), scale) << "the truth lies between";
        EXPECT_GT(fit.both_noisy.value(1), fit.joint.reverse.value(1));
        EXPECT_NEAR(fit.noise_ratio * share * share, 1, 0.1) << "as the rest says";
      } else {
        EXPECT_GT(fit.noise_ratio, 1e5) << "the reference is free of noise";
      }
    }
  }
}

TEST(ImuFit, BothNoisyHoldsTheTruth) {
  struct Case {
    double persistence, low_pass;
  };
  for (const Case& c : {Case{0.9, 0}, Case{0, 12}}) {
    test::AlignedRun run{.gyro_noise = 0.1, .accel_noise = 0.5, .persistence = c.persistence, .reference_noise = 0.7};
    run.rest = 30;
    double bias = 0, scale = 0, reverse = 0, count = 0;
    for (int seed = 1; seed <= 25; ++seed) {
      const Findings found =
          findings(low_passed(run.simulate(static_cast<std::uint64_t>(seed)), c.low_pass), phases_of(run), {});
      for (std::size_t i = 0; i < 6; ++i) {
        const auto hit = [](const Term& t, double right) { return std::abs(t.value - right) < t.half_width(0.95); };
        const RunFit& fit = *found.axes[i].run;
        bias += hit(fit.both_noisy.bias(), truth(run, i, false));
        scale += hit(fit.both_noisy.scale(), truth(run, i, true));
        reverse += hit(fit.joint.reverse.scale(), truth(run, i, true));
        count += 1;
      }
    }
    EXPECT_GT(bias / count, 0.9) << c.low_pass;
    EXPECT_LT(bias / count, 0.99) << c.low_pass;
    EXPECT_GT(scale / count, 0.9) << c.low_pass;
    EXPECT_LT(scale / count, 0.99) << c.low_pass;
    EXPECT_LT(reverse / count, 0.8) << c.low_pass;
    RecordProperty(fmt::format("both noisy, low-pass {}", c.low_pass),
                   fmt::format("{} {} {}", bias / count, scale / count, reverse / count));
  }
}

TEST(ImuFit, WithoutARestTheDensitiesSayHowNoisyEachIs) {
  const test::AlignedRun run{.reference_noise = 0.5};
  const AlignedImus imus = low_passed(run.simulate(1), 12);
  const Phases phases{std::nullopt, run.moving(), std::nullopt};
  ImuSensor body, reference;
  body.gyro.noise = 6e-4, reference.gyro.noise = 3e-4;
  body.accel.noise = 3e-3, reference.accel.noise = 1e-3;
  Findings found = findings(imus, phases, {.reference = &reference, .sensor = &body});
  EXPECT_NEAR(found.axes[0].run->noise_ratio, 9, 1e-12);
  EXPECT_NEAR(found.axes[5].run->noise_ratio, 4, 1e-12);
  found = findings(imus, phases, {.reference = &reference});
  const RunFit& fit = *found.axes[0].run;
  EXPECT_EQ(fit.noise_ratio, 1e6) << "nobody knows of noise in the reference";
  EXPECT_TRUE(fit.both_noisy.value.isApprox(fit.joint.reverse.value, 1e-4));
  EXPECT_TRUE(fit.both_noisy.hac_covariance.isApprox(fit.joint.reverse.hac_covariance, 1e-3));
}

// c_2 and c_3 times powers of the true signal, which the reference is, added to a run.
AlignedImus bent(AlignedImus imus, double gyro2, double gyro3, double accel2, double accel3) {
  for (std::size_t i = 0; i < imus.time.size(); ++i) {
    const auto w = imus.reference_gyro[i].array(), f = imus.reference_accel[i].array();
    imus.gyro[i].array() += w * w * (gyro2 + gyro3 * w);
    imus.accel[i].array() += f * f * (accel2 + accel3 * f);
  }
  return imus;
}

TEST(ImuFit, PolynomialHasTheOrderThatItNeeds) {
  test::AlignedRun run{.persistence = 0.9};
  run.rest = 10;
  run.run = 60;
  std::array<double, 4> on_line{}, on_cubic{};
  std::map<std::string, double> inside;
  double count = 0, cubics = 0;
  for (int seed = 1; seed <= 25; ++seed) {
    const AlignedImus imus = run.simulate(static_cast<std::uint64_t>(seed));
    const Findings line = findings(imus, phases_of(run), {});
    const Findings cubic = findings(bent(imus, 0.1, 0.4, 5e-3, 0.02), phases_of(run), {});
    for (std::size_t i = 0; i < 6; ++i) {
      count += 1;
      const PolynomialFit& straight = *line.axes[i].run->polynomial;
      on_line.at(static_cast<std::size_t>(straight.order)) += 1;
      EXPECT_LT(straight.effective_samples, 6001);
      const BiasScale& joint = line.axes[i].run->joint.reverse;
      if (straight.order == 1) {
        EXPECT_TRUE(straight.tangent.value.isApprox(joint.value, 1e-9));
        EXPECT_TRUE(straight.tangent.covariance.isApprox(joint.covariance, 1e-9));
        EXPECT_TRUE(straight.tangent.hac_covariance.isApprox(joint.hac_covariance, 1e-6));
      }
      const RunFit& fit = *cubic.axes[i].run;
      on_cubic.at(static_cast<std::size_t>(fit.polynomial->order)) += 1;
      if (fit.polynomial->order < 3) continue;
      cubics += 1;
      const double c0 = truth(run, i, false), c1 = truth(run, i, true), c2 = i < 3 ? 5e-3 : 0.1,
                   c3 = i < 3 ? 0.02 : 0.4, x = fit.mean;
      const auto hit = [&](const char* name, const Term& term, double right) {
        inside[name] += std::abs(term.value - right) < term.half_width(0.95);
      };
      const Coefficients& c = fit.polynomial->coefficients;
      hit("c0", c.term(0), c0);
      hit("c1", c.term(1), c1);
      hit("c2", c.term(2), c2);
      hit("c3", c.term(3), c3);
      hit("tangent's bias", fit.polynomial->tangent.bias(), c0 - c2 * x * x - 2 * c3 * x * x * x);
      hit("tangent's scale", fit.polynomial->tangent.scale(), c1 + 2 * c2 * x + 3 * c3 * x * x);
    }
  }
  EXPECT_GT(on_line[1] / count, 0.9);
  EXPECT_GT(on_cubic[3] / count, 0.95);
  ASSERT_EQ(inside.size(), 6U);
  for (const auto& [name, hits] : inside) {
    EXPECT_GT(hits / cubics, 0.9) << name;
    EXPECT_LT(hits / cubics, 0.99) << name;
    RecordProperty(name, std::to_string(hits / cubics));
  }
  RecordProperty("line taken for a line", std::to_string(on_line[1] / count));
  RecordProperty("cubic taken for a cubic", std::to_string(on_cubic[3] / count));
}

TEST(ImuFit, PolynomialOfASquareIsOfOrderTwo) {
  const test::AlignedRun run;
  const Findings found = findings(bent(run.simulate(4), 0.1, 0, 0.01, 0), phases_of(run), {});
  for (const AxisFindings& a : found.axes) {
    const PolynomialFit& fit = *a.run->polynomial;
    EXPECT_EQ(fit.order, 2) << a.name;
    EXPECT_LT(fit.bic[1], fit.bic[0]);
    EXPECT_LT(fit.bic[1], fit.bic[2]);
  }
}

TEST(ImuFit, MatrixFindsMisalignmentAndGSensitivity) {
  test::AlignedRun run{.persistence = 0.9};
  run.rest = 10;
  Matrix3d gyro, accel, sensitivity;
  gyro << 0, 0.01, -0.02, 0.005, 0, 0.015, -0.008, 0.004, 0;
  accel << 0, -0.003, 0.006, 0.01, 0, -0.012, 0.002, 0.007, 0;
  sensitivity << 1e-3, -5e-4, 3e-4, 2e-4, -1e-3, 6e-4, 8e-4, 0, -4e-4;
  std::map<std::string, double> inside, count;
  for (int seed = 1; seed <= 25; ++seed) {
    AlignedImus imus = run.simulate(static_cast<std::uint64_t>(seed));
    for (std::size_t i = 0; i < imus.time.size(); ++i) {
      imus.gyro[i] += gyro * imus.reference_gyro[i] + sensitivity * imus.reference_accel[i];
      imus.accel[i] += accel * imus.reference_accel[i];
    }
    const Findings found = findings(imus, phases_of(run), {});
    const MatrixFit &g = *found.gyro_matrix, &a = *found.accel_matrix;
    ASSERT_TRUE(g.has_g_sensitivity() && !a.has_g_sensitivity());
    const auto hit = [&](const std::string& name, const Term& t, double right) {
      inside[name] += std::abs(t.value - right) < t.half_width(0.95);
      count[name] += 1;
    };
    for (int k = 0; k < 3; ++k) {
      hit("gyro bias", g.bias(k), run.gyro_bias(k));
      hit("accel bias", a.bias(k), run.accel_bias(k));
      EXPECT_EQ(a.line(k).scale().value, a.gain(k, k).value);
      EXPECT_EQ(a.line(k).bias().standard_error, a.bias(k).standard_error);
      EXPECT_GT(a.axes[0].regression.inflation(MatrixFit::kGain + 2), 5) << "gravity is on that axis, as the bias is";
      for (int j = 0; j < 3; ++j) {
        hit(j == k ? "gyro scale" : "gyro misalignment", g.gain(k, j), gyro(k, j) + (j == k ? run.gyro_scale(k) : 0));
        hit(j == k ? "accel scale" : "accel misalignment", a.gain(k, j),
            accel(k, j) + (j == k ? run.accel_scale(k) : 0));
        hit("g-sensitivity", g.g_sensitivity(k, j), sensitivity(k, j));
        EXPECT_LT(g.g_sensitivity(k, j).total(), 6e-4);
      }
    }
  }
  ASSERT_EQ(inside.size(), 7U);
  for (const auto& [name, hits] : inside) {
    EXPECT_GT(hits / count[name], 0.9) << name;
    EXPECT_LT(hits / count[name], 0.99) << name;
    RecordProperty(name, std::to_string(hits / count[name]));
  }
}

TEST(ImuFit, LeavesOutWhatTheMotionDoesNotDetermine) {
  const test::AlignedRun run;
  AlignedImus imus = run.simulate(2);
  for (Vector3d& f : imus.reference_accel) f.z() = 2 * f.x();
  for (Vector3d& w : imus.reference_gyro) w.x() = w.x() > 0 ? 0.5 : -0.5;
  Findings found = findings(imus, phases_of(run), {});
  EXPECT_FALSE(found.accel_matrix || found.gyro_matrix) << "two axes of the force are one";
  EXPECT_FALSE(found.axes[3].run->polynomial) << "two values of the signal";
  EXPECT_TRUE(found.axes[4].run->polynomial);
  found = findings(imus, phases_of(run), {.g_sensitivity = false});
  EXPECT_TRUE(found.gyro_matrix && !found.gyro_matrix->has_g_sensitivity());
  EXPECT_FALSE(findings(imus, {run.before(), std::nullopt, std::nullopt}, {}).gyro_matrix);
}

// A residual timing error looks like a scale factor: 1 − cos(2π f d) of each frequency.
TEST(ImuFit, TimingErrorLooksLikeAScaleFactor) {
  test::AlignedRun run{.gyro_scale = {0, 0, 0}, .gyro_noise = 1e-5, .accel_noise = 1e-5};
  run.delay = 0.015;
  const Findings found = findings(run.simulate(1), phases_of(run), {});
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

// What two methods of a run share are their whole errors, so that nothing but their difference is left.
TEST(ImuFit, MethodsOfOneRunShareItsNoiseAndTheErrorsOfItsReference) {
  const test::AlignedRun run{.reference_noise = 0.5};
  ImuSensor reference;
  reference.gyro = reference.accel = {.noise = 0, .bias = 1e-3, .drift = {}, .scale = 1e-4};
  const Phases phases{run.before(), run.moving(), std::nullopt};
  const Findings found = findings(run.simulate(1), phases, {.reference = &reference});
  for (const AxisFindings& axis : found.axes) {
    const RunFit& fit = *axis.run;
    const auto whole = [&](const Term& t) {
      EXPECT_NEAR(t.averages.norm() / t.standard_error, 1, 1e-9) << axis.name;
      EXPECT_NEAR(t.effects.norm() / t.systematic, 1, 1e-9) << axis.name;
    };
    for (const BiasScale& line : {fit.joint.reverse, fit.joint.forward, fit.both_noisy, fit.polynomial->tangent}) {
      whole(line.bias());
      whole(correction(line).scale());
    }
    whole(fit.bias_only);
    EXPECT_EQ(axis.before->averages.size(), 0) << "of rows of its own";
    const Term apart = paired_difference(fit.joint.reverse.scale(), fit.both_noisy.scale());
    EXPECT_LT(apart.systematic, 1e-6 * fit.joint.reverse.scale().systematic);
    EXPECT_LT(apart.standard_error, difference(fit.joint.reverse.scale(), fit.both_noisy.scale()).standard_error);
  }
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
  found = findings(low_passed(imus, 12), phases_of(run), {});
  EXPECT_EQ(found.axes[0].run->samples, 5001);
  for (std::size_t i = 0; i < 6; ++i) {
    const Term scale = found.axes[i].run->joint.reverse.scale();
    EXPECT_NEAR(scale.value, truth(run, i, true), 5 * scale.standard_error);
  }
}

}  // namespace
}  // namespace piste
