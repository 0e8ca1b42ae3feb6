// The batch against the smoother of Rauch, Tung and Striebel: two ways to the same solution, and how it weighs fixes.

#include "piste/batch/batch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "smoother/relinearise.h"
#include "support/synthetic_log.h"

namespace piste {
namespace {

using test::SyntheticRun;

struct Both {
  Solution smoothed, batch;
};

Both both(const SyntheticRun& s, const BatchOptions& options = {}) {
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  const FoundStart found{s.start, "given"};
  const FilterRun again = relinearised(s.log, s.options, s.start, run);
  std::vector<AttitudeLag> lags;
  Both out{smooth_rts(again, {}, nullptr, &lags), run_batch(s.log, s.options, found, run, options)->solution()};
  out.smoothed.attitude_correlation_time = correlation_time(lags);
  return out;
}

// Largest difference of estimates, in sigmas, and of sigmas, as a part.
struct Apart {
  double values = 0, sigmas = 0;
};

Apart apart(const Solution& a, const Solution& b) {
  Apart out;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const FullError e = boxminus(a.estimate(i), b.estimate(i));
    const Sigmas sa = a.sigmas(i), sb = b.sigmas(i);
    for (const Block block : a.layout().blocks()) {
      if (is_navigation(block)) continue;
      for (int k = 0; k < info(block).size; ++k) {
        const int row = full_offset(block) + k;
        out.values = std::max(out.values, std::abs(e(row)) / sb.blocks(row));
        out.sigmas = std::max(out.sigmas, std::abs(sa.blocks(row) / sb.blocks(row) - 1));
      }
    }
    out.values = std::max(out.values, (e.head<3>().cwiseQuotient(sb.position)).cwiseAbs().maxCoeff());
    out.sigmas = std::max(out.sigmas, (sa.position.cwiseQuotient(sb.position).array() - 1).abs().maxCoeff());
    out.sigmas = std::max(out.sigmas, (sa.velocity.cwiseQuotient(sb.velocity).array() - 1).abs().maxCoeff());
  }
  return out;
}

TEST(Batch, IsTheSmootherWhereTheRunIsNearlyLinear) {
  SyntheticRun s = test::synthetic_run(
      20, {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift, Block::kAccelDrift, Block::kLeverArm});
  s.options.sensor.gyro.scale = s.options.sensor.accel.scale = 0;  // considered they would be estimated by the batch
  const Both b = both(s, {.loss = BatchLoss::kSquared});           // with the fixes that the filter used
  ASSERT_EQ(b.batch.size(), b.smoothed.size());
  ASSERT_TRUE(b.batch.batch);
  EXPECT_TRUE(b.batch.batch->converged);
  const Apart a = apart(b.batch, b.smoothed);
  EXPECT_LT(a.values, 0.005);
  EXPECT_LT(a.sigmas, 0.005);
  // Of other pairs of epochs.
  const double tau = b.smoothed.attitude_correlation_time;
  EXPECT_NEAR(b.batch.attitude_correlation_time, tau, 0.2 * tau);
  EXPECT_GT(tau, 0);
}

// What it leaves where laying the run out anew moves it but little.
TEST(Batch, StopsWithinAThousandthOfASigma) {
  const SyntheticRun s = test::synthetic_run(60, {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift,
                                                  Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale});
  const FilterRun run = run_filter(s.log, s.options, s.start);
  const auto solved = [&](const BatchOptions& options) {
    return run_batch(s.log, s.options, {s.start, "given"}, run, options)->solution();
  };
  const Solution as_usual = solved({}), to_the_end = solved({.tolerance = 1e-9});
  EXPECT_GT(to_the_end.batch->rounds, as_usual.batch->rounds);
  const Apart a = apart(as_usual, to_the_end);
  EXPECT_LT(a.values, 1e-3);
  EXPECT_LT(a.sigmas, 1e-3);
}

// Every fifth position is 23 m off, and a filter that was fooled says that it used all of them. The batch is then as it
// would be if those positions told nothing.
TEST(Batch, FixesFarOffDoNotPull) {
  SyntheticRun s = test::synthetic_run(20, {Block::kGyroBias, Block::kAccelBias});
  s.log.magnetic.clear();  // with them another fix lies at its bound, and only one of the two leaves it out
  const FoundStart found{s.start, "given"};
  const auto solved = [&](const FilterRun& run, BatchLoss loss) {
    return run_batch(s.log, s.options, found, run, {.loss = loss})->solution();
  };
  std::size_t wrong = 0;
  const auto spoil = [&](auto&& fix) {
    wrong = 0;
    for (auto& receiver : s.log.gnss) {
      for (std::size_t i = 3; i < receiver.size(); i += 5, ++wrong) fix(receiver[i]);
    }
  };
  // Both begin with all fixes, so that they have the same way to go.
  const auto fooled = [&] {
    FilterRun run = run_filter(s.log, s.options, s.start);
    for (Innovation& i : run.solution.innovations) i.outcome = Outcome::kUsed;
    return run;
  };
  const SyntheticRun whole = s;
  spoil([](GnssFix& fix) { fix.sigma_position.setConstant(1e4); });
  const Solution clean = solved(fooled(), BatchLoss::kTruncated);
  s = whole;
  spoil([](GnssFix& fix) { fix.position += Vector3d(20, -5, 10); });
  const auto off = [&](const Solution& a) {
    double most = 0;  // m
    for (std::size_t i = 0; i < clean.size(); ++i) {
      most = std::max(most, boxminus(a.estimate(i), clean.estimate(i)).head<3>().norm());
    }
    return most;
  };
  const Solution truncated = solved(fooled(), BatchLoss::kTruncated), barron = solved(fooled(), BatchLoss::kBarron);
  EXPECT_GE(truncated.batch->left_out, wrong);
  const double sigma = clean.sigmas(clean.size() / 2).position.norm();
  EXPECT_LT(off(truncated), 0.5 * sigma);
  EXPECT_LT(off(barron), 3 * sigma);
  EXPECT_GT(off(solved(fooled(), BatchLoss::kSquared)), 30 * sigma);
}

TEST(Batch, RowsThatAreAskedForAreThoseOfTheWhole) {
  const SyntheticRun s = test::synthetic_run(4, {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift});
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  const std::unique_ptr<BatchRun> batch = run_batch(s.log, s.options, {s.start, "given"}, run);
  const Solution whole = batch->solution();
  const std::vector<std::size_t> rows{0, 17, 18, whole.size() - 1};
  const std::vector<SmoothedState> states = batch->states(rows);
  ASSERT_EQ(states.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_TRUE(boxminus(states[i].x, whole.estimate(rows[i])).isZero(0));
    EXPECT_TRUE(sigmas_of(whole.world(), states[i].x, whole.layout(), states[i].P).position ==
                whole.sigmas(rows[i]).position);
  }
}

// Long enough that every thread has several stretches of it.
TEST(Batch, ThreadsDoNotChangeABit) {
  const SyntheticRun s = test::synthetic_run(
      70, {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift, Block::kAccelDrift, Block::kGyroScale});
  const FilterRun run = run_filter(s.log, s.options, s.start);
  const auto solved = [&](std::size_t threads) {
    return run_batch(s.log, s.options, {s.start, "given"}, run, {}, {}, threads);
  };
  const std::unique_ptr<BatchRun> alone = solved(1);
  const std::vector<std::size_t> rows{0, 2000, 3501, 6999};
  const std::vector<SmoothedState> expected = alone->states(rows);
  for (const std::size_t threads : {2U, 5U}) {
    const std::unique_ptr<BatchRun> together = solved(threads);
    EXPECT_EQ(together->summary().cost, alone->summary().cost) << threads;
    EXPECT_EQ(together->summary().iterations, alone->summary().iterations) << threads;
    const std::vector<SmoothedState> states = together->states(rows);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_TRUE(boxminus(states[i].x, expected[i].x).isZero(0)) << threads;
      EXPECT_TRUE(states[i].P == expected[i].P) << threads;
    }
  }
}

// It begins where a filter has lost its way. From half a radian it comes back; from further off steps do not settle, a
// trust region is called, and if that does not come back either it is not said to have converged.
TEST(Batch, FromFarOffItEndsWhereItAlwaysDoesOrSaysSo) {
  const SyntheticRun s = test::synthetic_run(4, {Block::kGyroBias, Block::kAccelBias, Block::kGyroScale});
  const FilterRun run = run_filter(s.log, s.options, s.start);
  const auto solved = [&](const FilterRun& from) {
    return run_batch(s.log, s.options, {s.start, "given"}, from, {.loss = BatchLoss::kSquared})->solution();
  };
  const Solution near = solved(run);
  for (const double far : {0.5, 0.9, 2.0}) {
    FilterRun lost = run;
    test::Random random(1);
    Vector3d turn = random.vector(far), place = random.vector(30);
    for (std::size_t i = 0; i < lost.solution.size(); ++i) {
      Estimate x = lost.solution.estimate(i);
      x.q_wb = so3_exp(turn) * x.q_wb;
      x.p_wb += place;
      x.v_wb += turn;
      lost.solution.set(i, lost.solution.time(i), x, lost.solution.sigmas(i));
      if (i % 50 != 0) continue;
      turn = random.vector(far);
      place = random.vector(30);
    }
    const Solution back = solved(lost);
    EXPECT_GT(back.batch->iterations, near.batch->iterations);
    EXPECT_TRUE(back.batch->converged || far > 0.6);
    if (!back.batch->converged) continue;
    const Apart a = apart(back, near);
    EXPECT_LT(a.values, 1e-3) << far;
    EXPECT_LT(a.sigmas, 1e-3) << far;
  }
}

// What a receiver repeats is no measurement; what the filter refused may be taken back; and who waits hears how
// far it is.
TEST(Batch, TakesBackWhatTheFilterRefusedForNothing) {
  const SyntheticRun s = test::synthetic_run(6, {Block::kGyroBias, Block::kAccelBias});
  FilterRun run = run_filter(s.log, s.options, s.start);
  std::vector<double> done;
  const BatchSolver solver = batch_solver();
  const auto solve = [&] {
    return solver(s.log, s.options, {s.start, "given"}, run, [&](double part) { done.push_back(part); });
  };
  const BatchSummary before = solve()->summary();
  EXPECT_EQ(before.taken_back, 0U);
  ASSERT_FALSE(done.empty());
  EXPECT_TRUE(std::ranges::is_sorted(done));
  std::vector<Innovation*> positions;
  for (Innovation& v : run.solution.innovations) {
    if (v.source == 0) positions.push_back(&v);
  }
  positions[30]->outcome = positions[40]->outcome = Outcome::kRejected;
  EXPECT_EQ(solve()->summary().taken_back, 2U);
  positions[40]->outcome = Outcome::kRepeated;
  const BatchSummary after = solve()->summary();
  EXPECT_EQ(after.taken_back, 1U);
  EXPECT_EQ(after.fixes, before.fixes - 1);
  done.clear();
  solve()->solution([&](double part) { done.push_back(part); });
  EXPECT_GE(done.size(), 2U);
}

}  // namespace
}  // namespace piste
