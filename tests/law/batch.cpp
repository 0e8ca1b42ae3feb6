// The batch on a run that is as good as linear: then batch, smoother and filter are the same estimate.

#include "piste/batch/batch.h"

#include <gtest/gtest.h>

#include "smoother/relinearise.h"
#include "support/synthetic_log.h"

namespace piste {
namespace {

constexpr double kSmall = 3e-4;

// A body that stands, with errors so small that their products vanish, and one receiver that tells position and
// velocity.
test::SyntheticRun quiet_run() {
  constexpr double kLength = 20, kStep = 0.005;
  test::SyntheticRun run =
      test::synthetic_run(0.1, {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift, Block::kAccelDrift});
  test::Random random(1);
  test::WildMotion motion;
  motion.begin = 1e9;  // later than any time
  const double start = run.start.time;
  for (TriadErrors* errors : {&run.options.sensor.gyro, &run.options.sensor.accel}) {
    errors->noise *= kSmall;
    errors->bias *= kSmall;
    errors->drift.sigma *= kSmall;
    errors->drift.density *= kSmall;
    errors->scale = 0;  // it is not estimated, and the batch would do so
  }
  run.options.gnss = {{.name = "", .lever_arm = run.options.gnss[0].lever_arm, .drift = {}}};
  run.options.attitude.clear();
  run.log = {};
  run.log.world = motion.world;
  run.log.gnss.resize(1);
  for (ImuSample s : motion.samples(start, start + kLength, kStep)) {
    const Vector3d gyro = random.vector(kSmall * 0.02 * kStep), accel = random.vector(kSmall * 0.1 * kStep);
    s.dtheta += gyro;
    s.dvel += accel;
    run.log.imu.push_back(s);
  }
  for (double t = 0.0537; t < kLength; t += 0.1) {
    GnssFix fix = motion.fix(start + t, run.options.gnss[0].lever_arm);
    fix.sigma_position *= kSmall;
    fix.velocity->sigma *= kSmall;
    fix.position += random.vector(1).cwiseProduct(fix.sigma_position);
    fix.velocity->value += random.vector(1).cwiseProduct(fix.velocity->sigma);
    // The same noise of the steps counts little beside these: how each sums it within a step differs by 1e-4.
    fix.sigma_position.setConstant(0.03);
    fix.velocity->sigma.setConstant(0.05);
    run.log.gnss[0].push_back(fix);
  }
  const auto truth = motion.at(start);
  run.start.covariance *= kSmall * kSmall;
  const Eigen::Matrix<double, 9, 1> sigma = run.start.covariance.diagonal().cwiseSqrt();
  FullError error = FullError::Zero();
  for (int k = 0; k < 9; ++k) error(k) = sigma(k) * random.gaussian();
  run.start.x.q_wb = truth.q_wb;
  run.start.x.v_wb = truth.v_wb;
  run.start.x.p_wb = truth.p_wb;
  run.start.x = boxplus(run.start.x, error);
  return run;
}

TEST(BatchLaw, IsFilterAndSmootherOfALinearRun) {
  const test::SyntheticRun s = quiet_run();
  const FoundStart found{s.start, "given"};
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  const Solution smoothed = smooth_rts(relinearised(s.log, s.options, s.start, run));
  const Solution batch = run_batch(s.log, s.options, found, run, {.loss = BatchLoss::kSquared})->solution();
  ASSERT_EQ(batch.size(), smoothed.size());
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const FullError e = boxminus(smoothed.estimate(i), batch.estimate(i));
    EXPECT_LT(e.cwiseAbs().maxCoeff(), 1e-8) << i;  // m, m/s, rad, rad/s, m/s²
    const Sigmas a = smoothed.sigmas(i), b = batch.sigmas(i);
    EXPECT_TRUE(a.position.isApprox(b.position, 1e-4)) << i;
    EXPECT_TRUE(a.velocity.isApprox(b.velocity, 1e-4)) << i;
  }
  const std::size_t last = batch.size() - 1;
  EXPECT_LT(boxminus(run.solution.estimate(last), batch.estimate(last)).cwiseAbs().maxCoeff(), 1e-8);
}

}  // namespace
}  // namespace piste
