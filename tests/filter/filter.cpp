// What a caller of the filter may rely on: arrival order, copies, lateness.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "piste/core/error.h"
#include "piste/filter/run.h"
#include "support/synthetic_log.h"

namespace piste {
namespace {

using test::Random;
using test::SyntheticRun;

// One measurement on its way to the filter.
struct Arrival {
  double time, arrives;
  std::function<void(Filter&)> deliver;
};

std::vector<Arrival> arrivals_of(const Log& log) {
  std::vector<Arrival> all;
  for (std::size_t r = 0; r < log.gnss.size(); ++r) {
    for (const GnssFix& fix : log.gnss[r]) {
      all.push_back({fix.time, fix.time, [fix, r](Filter& f) { f.add(static_cast<int>(r), fix); }});
    }
  }
  for (std::size_t r = 0; r < log.attitude.size(); ++r) {
    for (const AttitudeFix& fix : log.attitude[r]) {
      all.push_back({fix.time, fix.time, [fix, r](Filter& f) { f.add(static_cast<int>(r), fix); }});
    }
  }
  for (const MagneticSample& m : log.magnetic) all.push_back({m.time, m.time, [m](Filter& f) { f.add(0, m); }});
  return all;
}

void expect_same(const Estimate& a, const Estimate& b) {
  EXPECT_TRUE(a.q_wb.coeffs() == b.q_wb.coeffs());
  EXPECT_TRUE(a.q_rb.coeffs() == b.q_rb.coeffs());
  EXPECT_TRUE(a.v_wb == b.v_wb);
  for (const BlockInfo& row : kBlocks) {
    if (is_rotation(row.block)) {
      EXPECT_TRUE(rotation(a, row.block).coeffs() == rotation(b, row.block).coeffs()) << row.name;
      continue;
    }
    EXPECT_TRUE(additive(a, row.block) == additive(b, row.block)) << row.name;
  }
}

void expect_same(const Filter& a, const Filter& b) {
  EXPECT_EQ(a.time(), b.time());
  expect_same(a.estimate(), b.estimate());
  EXPECT_TRUE(a.covariance() == b.covariance());
}

// Feeds the log one sample at a time, measurements at the sample before which they arrive, less the time by which those
// that come late must be known before, and compares every epoch with the batch run.
void expect_batch(const SyntheticRun& s, std::vector<Arrival> arrivals) {
  const FilterRun batch = run_filter(s.log, s.options, s.start);
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.arrives < b.arrives; });
  Filter filter(s.options, s.log.world, s.start);
  std::size_t next = 0, row = 0;
  const auto compare = [&] {
    EXPECT_EQ(filter.time(), batch.solution.time(row));
    const Estimate x = batch.solution.estimate(row);
    expect_same(filter.estimate(), x);
    const Sigmas is = sigmas_of(s.log.world, filter.estimate(), filter.layout(), filter.covariance()),
                 was = batch.solution.sigmas(row);
    EXPECT_TRUE(is.position == was.position && is.velocity == was.velocity && is.euler == was.euler);
    ++row;
  };
  for (const ImuSample& sample : s.log.imu) {
    for (; next < arrivals.size() && arrivals[next].arrives <= sample.time + filter.look_ahead(); ++next)
      arrivals[next].deliver(filter);
    if (filter.add(sample)) compare();
  }
  if (filter.finish()) compare();
  EXPECT_EQ(row, batch.solution.size());
  EXPECT_EQ(filter.late(), 0U);
  ASSERT_EQ(filter.innovations().size(), batch.solution.innovations.size());
  for (std::size_t i = 0; i < filter.innovations().size(); ++i) {
    EXPECT_EQ(filter.innovations()[i].nis, batch.solution.innovations[i].nis);
    EXPECT_EQ(filter.innovations()[i].source, batch.solution.innovations[i].source);
  }
}

TEST(Filter, StreamingIsBatchToTheByte) {
  const SyntheticRun s = test::synthetic_run(6, test::all_blocks());
  expect_batch(s, arrivals_of(s.log));
}

TEST(Filter, AdaptingIsTheSameStreamed) {
  SyntheticRun s = test::synthetic_run(6, test::all_blocks());
  s.options.adapt = AdaptationOptions{};
  expect_batch(s, arrivals_of(s.log));
}

TEST(Filter, ADisputeIsTheSameStreamed) {
  SyntheticRun s = test::synthetic_run(6, {Block::kGyroBias, Block::kAccelBias});
  for (GnssFix& fix : s.log.gnss[0]) {
    if (fix.time > s.start.time + 3 && fix.time < s.start.time + 5) fix.position.x() += 50;
  }
  expect_batch(s, arrivals_of(s.log));
}

TEST(Filter, ArrivalOrderDoesNotMatter) {
  const SyntheticRun s = test::synthetic_run(6, test::all_blocks());
  Random random(1);
  std::vector<Arrival> arrivals = arrivals_of(s.log);
  // Up to half a second early, hence in any order; some as late as the sample that follows.
  for (Arrival& a : arrivals) a.arrives -= 0.5 * random.uniform();
  std::reverse(arrivals.begin(), arrivals.end());
  expect_batch(s, arrivals);
  for (Arrival& a : arrivals) a.arrives = 0;  // everything known from the start
  expect_batch(s, arrivals);
}

TEST(Filter, ACopyGoesOnTheSame) {
  const SyntheticRun s = test::synthetic_run(4, test::all_blocks());
  Filter filter(s.options, s.log.world, s.start);
  for (const Arrival& a : arrivals_of(s.log)) a.deliver(filter);
  const std::size_t half = s.log.imu.size() / 2;
  for (std::size_t i = 0; i < half; ++i) filter.add(s.log.imu[i]);
  Filter copy = filter;
  for (std::size_t i = half; i < s.log.imu.size(); ++i) filter.add(s.log.imu[i]);
  filter.finish();
  EXPECT_LT(copy.time(), filter.time());  // untouched by the original
  for (std::size_t i = half; i < s.log.imu.size(); ++i) copy.add(s.log.imu[i]);
  copy.finish();
  expect_same(filter, copy);
}

TEST(Filter, RefusesASampleThatCannotBeAndGoesOn) {
  const SyntheticRun s = test::synthetic_run(3, {});
  Filter filter(s.options, s.log.world, s.start), twin = filter;
  const auto refused = [&](std::size_t i, const std::function<void(ImuSample&)>& change) {
    ImuSample sample = s.log.imu[i];
    change(sample);
    EXPECT_THROW(filter.add(sample), DataError);
  };
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  refused(0, [](ImuSample& x) { x.time = kNone; });
  for (std::size_t i = 0; i < 50; ++i) {
    filter.add(s.log.imu[i]);
    twin.add(s.log.imu[i]);
    refused(i, [](ImuSample&) {});  // once more
    refused(i + 1, [](ImuSample& x) { x.interval = 0; });
    refused(i + 1, [](ImuSample& x) { x.dtheta.y() = kNone; });
    refused(i + 1, [](ImuSample& x) { x.dvel.z() = kNone; });
  }
  expect_same(filter, twin);
}

TEST(Filter, ALateFixIsCountedAndLeftOut) {
  const SyntheticRun s = test::synthetic_run(3, {});
  Filter filter(s.options, s.log.world, s.start), twin = filter;
  for (std::size_t i = 0; i < 200; ++i) {
    filter.add(s.log.imu[i]);
    twin.add(s.log.imu[i]);
  }
  GnssFix late = s.log.gnss[0].front();
  late.time = filter.time() - 0.001;
  filter.add(0, late);
  EXPECT_EQ(filter.late(), 1U);
  for (std::size_t i = 200; i < 250; ++i) {
    filter.add(s.log.imu[i]);
    twin.add(s.log.imu[i]);
  }
  EXPECT_TRUE(filter.innovations().size() == twin.innovations().size());
  expect_same(filter, twin);
}

TEST(Filter, AnEarlyFixWaitsForItsTime) {
  const SyntheticRun s = test::synthetic_run(3, {});
  Filter filter(s.options, s.log.world, s.start);
  const GnssFix& fix = s.log.gnss[0][7];
  filter.add(0, fix);
  for (const ImuSample& sample : s.log.imu) {
    if (!filter.add(sample)) continue;
    const auto innovations = filter.innovations();
    const bool used =
        std::any_of(innovations.begin(), innovations.end(), [](const Innovation& i) { return i.source == 0; });
    EXPECT_EQ(used, fix.time <= filter.time() + 1e-9);
  }
}

// The estimate stays honest on a run whose truth is known: a first look, the statistics are tested elsewhere.
TEST(Filter, FollowsTheMotion) {
  const SyntheticRun s = test::synthetic_run(10, {Block::kGyroBias, Block::kAccelBias});
  const FilterRun run = run_filter(s.log, s.options, s.start);
  test::WildMotion motion;
  motion.begin = s.start.time + 2;
  const std::size_t last = run.solution.size() - 1;
  const auto truth = motion.at(run.solution.time(last));
  const Estimate x = run.solution.estimate(last);
  const Sigmas sigma = run.solution.sigmas(last);
  EXPECT_LT((truth.p_wb - x.p_wb).norm(), 5 * sigma.position.norm());
  EXPECT_LT((truth.v_wb - x.v_wb).norm(), 5 * sigma.velocity.norm());
  EXPECT_LT(so3_log(truth.q_wb * x.q_wb.conjugate()).norm(), 5 * sigma.euler.norm());
  EXPECT_LT(sigma.position.norm(), 0.05);
  EXPECT_LT(sigma.velocity.norm(), 0.1);
  EXPECT_LT(sigma.euler.norm(), 0.02);
}

// A receiver that tells no vertical velocity: what it does not tell is not believed.
TEST(Filter, FollowsTheMotionByHorizontalVelocity) {
  SyntheticRun s = test::synthetic_run(10, {Block::kGyroBias, Block::kAccelBias});
  for (GnssFix& fix : s.log.gnss.at(0)) {
    fix.velocity->value.z() = 0;
    fix.velocity->sigma.z() = std::numeric_limits<double>::infinity();
  }
  const FilterRun run = run_filter(s.log, s.options, s.start);
  test::WildMotion motion;
  motion.begin = s.start.time + 2;
  double largest_down = 0;
  for (std::size_t i = run.solution.size() / 2; i < run.solution.size(); ++i) {
    const auto truth = motion.at(run.solution.time(i));
    const Vector3d error = truth.v_wb - run.solution.estimate(i).v_wb;
    EXPECT_LT(error.norm(), 5 * run.solution.sigmas(i).velocity.norm());
    EXPECT_LT(run.solution.sigmas(i).velocity.norm(), 0.2);
    largest_down = std::max(largest_down, std::abs(truth.v_wb.z()));
  }
  EXPECT_GT(largest_down, 1);
  std::size_t velocities = 0;
  for (const Innovation& v : run.solution.innovations) {
    if (run.solution.sources[static_cast<std::size_t>(v.source)] != "gnss[0].velocity") continue;
    EXPECT_EQ(v.dof, 2);
    EXPECT_EQ(v.outcome, Outcome::kUsed);
    ++velocities;
  }
  EXPECT_GT(velocities, 10u);
}

// The last sample is not filtered yet; the prediction is where it leads.
TEST(Filter, PredictsToTheNewestSample) {
  const SyntheticRun s = test::synthetic_run(4, {Block::kGyroBias, Block::kAccelBias});
  Filter filter(s.options, s.log.world, s.start);
  expect_same(filter.predicted(), filter.estimate());
  for (const ImuSample& sample : s.log.imu) filter.add(sample);
  const Estimate predicted = filter.predicted();
  EXPECT_GT((predicted.p_wb - filter.estimate().p_wb).norm(), 0.01);
  filter.finish();
  EXPECT_LT(boxminus(predicted, filter.estimate()).head<9>().cwiseAbs().maxCoeff(), 1e-4);
}

// What stands still may well repeat its fix; what moves cannot. It is reported once for position and velocity.
TEST(Filter, ARepeatedFixIsLeftOutWhileTheBodyMoves) {
  SyntheticRun s = test::synthetic_run(6, {Block::kGyroBias, Block::kAccelBias});
  s.log.gnss[1].clear();
  auto& fixes = s.log.gnss[0];
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    if (i % 10 == 0)
      fixes[i] = {fixes[i].time, fixes[i - 1].position, fixes[i - 1].sigma_position, fixes[i - 1].velocity};
  }
  const FilterRun run = run_filter(s.log, s.options, s.start);
  std::size_t repeated = 0;
  for (const Innovation& v : run.solution.innovations) {
    if (v.outcome != Outcome::kRepeated) continue;
    ++repeated;
    EXPECT_EQ(run.solution.sources[static_cast<std::size_t>(v.source)], "gnss[0].position");
    EXPECT_FALSE(s.log.rest[0].contains(v.time)) << v.time;
  }
  EXPECT_EQ(repeated, 3U) << "at 3, 4 and 5 s; it moves off at 2 s";
}

// A receiver that states other sigmas than before may have another slow error: as much of its variance as may have
// changed is unknown again, and never more than was unknown at first.
TEST(Filter, ASlowErrorIsForgottenWhereItMayHaveChanged) {
  const Block block = position_drift_block(0, true);
  const auto sigma_after = [&](const Vector3d& change, std::optional<PositionDrift> drift) {
    SyntheticRun s = test::synthetic_run(6, {});
    s.log.attitude[0].clear();
    s.options.gnss[0].drift = std::move(drift);
    s.options.estimate = {block};
    for (GnssFix& fix : s.log.gnss[0]) fix.sigma_position *= 20;  // so that the slow part is known from the other one
    s.log.gnss[0].back().slow_change = change;
    const FilterRun run = run_filter(s.log, s.options, s.start);
    return Vector3d(run.solution.sigmas(run.solution.size() - 1).blocks.segment<3>(full_offset(block)));
  };
  const auto share = PositionDrift::of_share(Vector3d::Constant(0.7), 1000);
  const Vector3d before = sigma_after(Vector3d::Zero(), share);
  EXPECT_LT(before.maxCoeff(), 0.5);
  const Vector3d more = sigma_after(Vector3d(0.2, 0, 0), share), all = sigma_after(Vector3d(50, 50, 50), share);
  EXPECT_GT(more.x(), before.x() * 1.02);
  EXPECT_NEAR(more.y() / before.y(), 1, 0.01);
  EXPECT_GT(all.x(), more.x());
  EXPECT_LE(all.maxCoeff(), 0.7 + 1e-9);
}

TEST(Filter, SaysWhenItDiverges) {
  SyntheticRun s = test::synthetic_run(2, {});
  s.start.x.p_wb = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  try {
    run_filter(s.log, s.options, s.start);
    FAIL() << "nothing was thrown";
  } catch (const DataError& e) {
    EXPECT_TRUE(std::string(e.what()).find("the filter diverged at gnss[") != std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace piste
