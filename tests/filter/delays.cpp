// Fixes that come late: by a known delay, by one that is estimated, and in real time.

#include <gtest/gtest.h>

#include "filter/recent_motion.h"
#include "piste/filter/run.h"
#include "support/synthetic_log.h"
#include "walker/own_times.h"

namespace piste::test {
namespace {

constexpr double kPositionLate = 0.08, kVelocityLate = 0.2, kAttitudeLate = 0.0155;  // s

// A run whose positions and velocities belong to other times: by two receivers, each of which measures one of them and
// is on time; and by one receiver that is late with both.
struct Twins {
  SyntheticRun on_time, late;
};

Twins twins(double duration, const std::vector<Block>& estimate) {
  Twins t{synthetic_run(duration, estimate), synthetic_run(duration, estimate)};
  Log &on_time = t.on_time.log, &late = t.late.log;
  WildMotion motion;
  motion.begin = late.rest.front().end;
  const GnssOptions receiver{.name = "", .lever_arm = t.late.start.x.lever_arm};
  t.on_time.options.gnss = {receiver, receiver};
  t.on_time.options.gnss[0].use_velocity = t.on_time.options.gnss[1].use_position = false;
  t.late.options.gnss = {receiver};
  t.late.options.gnss[0].delay = kPositionLate;
  t.late.options.gnss[0].velocity_delay = kVelocityLate;
  t.late.options.attitude[0].delay = kAttitudeLate;
  on_time.gnss.assign(2, {});
  late.gnss.assign(1, {});
  Random random(5);
  for (double time = late.imu.front().time + 0.3037; time < late.imu.back().time - 0.3; time += 0.1) {
    GnssFix fix = motion.fix(time, receiver.lever_arm), then = fix;
    fix.position += random.vector(1).cwiseProduct(fix.sigma_position);
    then.time = time + kPositionLate - kVelocityLate;
    then.velocity = motion.fix(then.time, receiver.lever_arm).velocity;
    then.velocity->value += random.vector(1).cwiseProduct(then.velocity->sigma);
    on_time.gnss[0].push_back(fix);
    on_time.gnss[1].push_back(then);
    late.gnss[0].push_back({time + kPositionLate, fix.position, fix.sigma_position, then.velocity});
  }
  for (AttitudeFix& fix : late.attitude[0]) fix.time += kAttitudeLate;
  return t;
}

void expect_near(const Estimate& a, const Estimate& b, double tolerance) {
  EXPECT_LT(boxminus(a, b).cwiseAbs().maxCoeff(), tolerance);
}

TEST(Delays, AKnownDelayIsNone) {
  const Twins t = twins(6, {Block::kGyroBias, Block::kAccelBias, Block::kGyroScale, Block::kBoresight});
  const FilterRun a = run_filter(t.on_time.log, t.on_time.options, t.on_time.start);
  const FilterRun b = run_filter(t.late.log, t.late.options, t.late.start);
  ASSERT_EQ(a.solution.size(), b.solution.size());
  ASSERT_EQ(a.solution.innovations.size(), b.solution.innovations.size());
  for (std::size_t i = 0; i < a.solution.size(); ++i) {
    expect_near(a.solution.estimate(i), b.solution.estimate(i), 1e-6);  // times to rounding
    ASSERT_LT((a.solution.sigmas(i).position - b.solution.sigmas(i).position).norm(), 1e-7);
  }
  EXPECT_EQ(b.solution.gnss_late, 0U);
  const Innovation& last = b.solution.innovations.back();
  EXPECT_NEAR(last.late, last.source == 0 ? kPositionLate : last.source == 1 ? kVelocityLate : 0, 0.02);
}

// Velocities that are means over 0.4 s: of the motion's swings at 1.7 Hz they show less than half. Where the run knows
// it, its innovations are those of velocities of the moment; else they are swings.
TEST(Delays, AVelocityThatIsAMean) {
  constexpr double kMean = 0.4;
  SyntheticRun run = synthetic_run(12, {Block::kGyroBias, Block::kAccelBias}, 3);
  WildMotion motion;
  motion.begin = run.log.rest.front().end;
  const GnssOptions receiver{.name = "", .lever_arm = run.start.x.lever_arm};
  run.options.gnss = {receiver};
  run.log.gnss.assign(1, {});
  run.log.attitude.assign(1, {});
  Random random(8);
  for (double time = run.log.imu.front().time + 0.5037; time < run.log.imu.back().time - 0.5; time += 0.1) {
    GnssFix fix = motion.fix(time, receiver.lever_arm);
    const auto place = [&](double t) { return motion.fix(t, receiver.lever_arm).position; };
    fix.velocity->value = (place(time + kMean / 2) - place(time - kMean / 2)) / kMean +
                          random.vector(1).cwiseProduct(fix.velocity->sigma);
    fix.position += random.vector(1).cwiseProduct(fix.sigma_position);
    run.log.gnss[0].push_back(fix);
  }
  const auto mean_square = [&](double averaging, double late) {
    run.options.gnss[0].velocity_averaging = averaging;
    run.options.gnss[0].velocity_delay = late;
    for (GnssFix& fix : run.log.gnss[0]) fix.time += late;
    run.options.gnss[0].delay = late;
    const FilterRun found = run_filter(run.log, run.options, run.start);
    for (GnssFix& fix : run.log.gnss[0]) fix.time -= late;
    double sum = 0, count = 0;
    for (const Innovation& v : found.solution.innovations) {
      if (found.solution.sources[static_cast<std::size_t>(v.source)] != "gnss[0].velocity" ||
          v.time + v.late < motion.begin + 3)
        continue;
      sum += v.nis / v.dof;
      ++count;
    }
    EXPECT_GT(count, 50);
    return sum / count;
  };
  EXPECT_NEAR(mean_square(kMean, 0), 1, 0.25);
  EXPECT_NEAR(mean_square(kMean, 0.3), 1, 0.25) << "and late besides";
  EXPECT_GT(mean_square(0, 0), 5);
}

TEST(Delays, OneThatNobodyKnowsShows) {
  Twins t = twins(6, {Block::kGyroBias, Block::kAccelBias});
  const Estimate right = run_filter(t.late.log, t.late.options, t.late.start).solution.estimate(500);
  t.late.options.gnss[0].velocity_delay = 0;
  const Estimate wrong = run_filter(t.late.log, t.late.options, t.late.start).solution.estimate(500);
  EXPECT_GT((right.v_wb - wrong.v_wb).norm(), 0.05);
}

// Each fix is added when the samples have reached its own time, and so after those to which it belongs.
TEST(Delays, InRealTimeAFixIsCarriedBack) {
  const Twins t = twins(8, {Block::kGyroBias, Block::kAccelBias});
  const FilterRun batch = run_filter(t.late.log, t.late.options, t.late.start);
  Filter live(t.late.options, t.late.log.world, t.late.start);
  EXPECT_NEAR(live.look_ahead(), kVelocityLate, 1e-5);
  std::size_t fix = 0, attitude = 0, magnetic = 0;
  const auto& fields = t.late.log.magnetic;
  for (const ImuSample& sample : t.late.log.imu) {
    const auto& fixes = t.late.log.gnss[0];
    const auto& attitudes = t.late.log.attitude[0];
    for (; fix < fixes.size() && fixes[fix].time <= sample.time; ++fix) live.add(0, fixes[fix]);
    for (; attitude < attitudes.size() && attitudes[attitude].time <= sample.time; ++attitude)
      live.add(0, attitudes[attitude]);
    for (; magnetic < fields.size() && fields[magnetic].time <= sample.time; ++magnetic) live.add(0, fields[magnetic]);
    live.add(sample);
  }
  live.finish();
  EXPECT_EQ(live.late(), 0U);
  EXPECT_EQ(live.innovations().size(), batch.solution.innovations.size());
  const Estimate& a = live.estimate();
  const Estimate b = batch.solution.estimate(batch.solution.size() - 1);
  EXPECT_LT((a.p_wb - b.p_wb).norm(), 0.05);
  EXPECT_LT((a.v_wb - b.v_wb).norm(), 0.1);
  EXPECT_LT(a.q_wb.angularDistance(b.q_wb), 0.01);
}

TEST(Delays, AreFoundFromFarAway) {
  const std::vector<Block> blocks{Block::kGyroBias,  Block::kAccelBias,     Block::kBoresight,
                                  Block::kGnssDelay, Block::kVelocityDelay, Block::kAttitudeDelay};
  Twins t = twins(30, blocks);
  FilterOptions& o = t.late.options;
  o.priors.gnss_delay = o.priors.velocity_delay = 0.3;
  o.gnss[0].delay = 0;
  o.gnss[0].velocity_delay = kVelocityLate - 0.3;
  o.attitude[0].delay = 0;
  set_known(t.late.start.x, o);
  EXPECT_EQ(t.late.start.x.velocity_delay, kVelocityLate - 0.3);
  const FilterRun run = run_filter(t.late.log, o, t.late.start);
  const Estimate x = run.solution.estimate(run.solution.size() - 1);
  const Sigmas s = run.solution.sigmas(run.solution.size() - 1);
  const auto expect_found = [&](Block block, double found, double truth) {
    const double sigma = s.blocks(full_offset(block));
    EXPECT_NEAR(found, truth, 4 * sigma) << info(block).name;
    EXPECT_LT(sigma, 0.005) << info(block).name;
    EXPECT_GT(sigma, 1e-6) << info(block).name;
  };
  expect_found(Block::kGnssDelay, x.gnss_delay, kPositionLate);
  expect_found(Block::kVelocityDelay, x.velocity_delay, kVelocityLate);
  expect_found(Block::kAttitudeDelay, x.attitude_delay, kAttitudeLate);
}

// Where only the delay of the positions is estimated, the velocities follow; a second receiver keeps its distance.
TEST(Delays, OfOneReceiverAreThoseOfAll) {
  FilterOptions o;
  o.gnss.resize(2);
  o.gnss[0].delay = 0.1;
  o.gnss[0].velocity_delay = 0.3;
  o.gnss[1].delay = 0.05;
  Estimate x;
  x.gnss_delay = 0.11;
  x.velocity_delay = 0.5;
  const auto delay = [&](const std::vector<Block>& blocks, int sensor, int channel) {
    return GnssReceivers::delay(o, StateLayout(blocks), sensor, channel, x, 0).value;
  };
  EXPECT_EQ(delay({}, 0, 0), 0.1);
  EXPECT_EQ(delay({}, 0, 1), 0.3);
  EXPECT_EQ(delay({}, 1, 1), 0.05) << "without a delay of its own the velocity has that of the position";
  EXPECT_NEAR(delay({Block::kGnssDelay}, 0, 1), 0.31, 1e-12);
  EXPECT_NEAR(delay({Block::kGnssDelay}, 1, 0), 0.06, 1e-12);
  EXPECT_NEAR(delay({Block::kGnssDelay, Block::kVelocityDelay}, 1, 1), 0.25, 1e-12);
  EXPECT_NEAR(delay({Block::kVelocityDelay}, 0, 0), 0.1, 1e-12);
  x.clock_drift = 1e-4;
  const FixDelay drifted = GnssReceivers::delay(o, StateLayout(std::vector<Block>{Block::kClockDrift}), 0, 0, x, 200);
  EXPECT_NEAR(drifted.value, 0.08, 1e-12) << "a clock that gains has the fix later";
  EXPECT_EQ(drifted.by_clock_drift, -200);
}

// The same uncertainty of a delay, as one of its own, as one by the drift of the IMU's clock since long ago, or half
// of each: fixes are compared with the same, and so believed the same, whatever they have shown of it before.
TEST(Delays, AreAsUncertainAsTheirPartsTogether) {
  constexpr double kUnsure = 0.2, kLongAgo = 1e5;  // s
  struct Part {
    std::vector<Block> blocks;
    double own, by_drift;
  };
  std::vector<std::vector<Innovation>> all;
  for (const Part& part : {Part{{Block::kGnssDelay}, kUnsure, 0}, Part{{Block::kClockDrift}, 0, kUnsure},
                           Part{{Block::kGnssDelay, Block::kClockDrift}, 0.6 * kUnsure, 0.8 * kUnsure}}) {
    SyntheticRun s = synthetic_run(8, part.blocks);
    s.log.attitude[0].clear();  // whose delay is another one
    s.log.magnetic.clear();
    s.options.priors.gnss_delay = part.own;
    s.options.priors.clock_drift = part.by_drift / kLongAgo;
    s.options.clock_from = s.start.time - kLongAgo;
    all.push_back(run_filter(s.log, s.options, s.start).solution.innovations);
  }
  double without = 0;
  for (std::size_t i = 0; i < all[0].size(); ++i) {
    const Innovation& own = all[0][i];
    for (const auto& others : {all[1], all[2]}) {
      ASSERT_EQ(others.size(), all[0].size());
      EXPECT_EQ(others[i].source, own.source);
      // The drift acts over a time that grows by a ten thousandth.
      EXPECT_LT((others[i].residual - own.residual).cwiseQuotient(own.sigma).norm(), 0.01) << own.time;
      EXPECT_LT((others[i].sigma - own.sigma).cwiseQuotient(own.sigma).norm(), 0.001) << own.time;
    }
    without = std::max(without, own.sigma.norm());
  }
  EXPECT_GT(without, 0.5) << "the delay counts";
}

// A body with 2 g and 1 rad/s, carried back over 80 ms.
TEST(Delays, APositionIsCarriedBackToAMillimetre) {
  const World world({0.8, 0.1, 500});
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const double tau = 0.08;
    Estimate x;
    x.q_wb = random.rotation();
    x.v_wb = random.vector(20);
    x.lever_arm = random.vector(0.5);
    const Gravity gravity = world.gravity(x.p_wb);
    const Vector3d a = 2 * kStandardGravity * random.vector().normalized(), rate = random.vector().normalized();
    AntennaMotion motion;
    motion.mean.force = x.q_wb.conjugate() * (a - gravity.value + 2 * world.earth_rate().cross(x.v_wb));
    motion.now.rate = motion.mean.rate = rate;
    const Quaterniond then = so3_exp(tau * world.earth_rate()) * x.q_wb * so3_exp(-tau * rate);
    const Vector3d place = x.p_wb - tau * x.v_wb + 0.5 * tau * tau * a + then * x.lever_arm;
    const GnssFix fix{0, place, Vector3d::Ones(), {}};
    const auto residual = [&](const Lag& lag) {
      return linearize_position(fix, {}, x, motion, world.earth_rate(), gravity, lag).residual;
    };
    EXPECT_LT(residual({tau}).norm(), 1e-3);
    // A delay that is not known adds the half of its variance times the acceleration, and the spread of that.
    const Linearization unsure =
        linearize_position(fix, {}, x, motion, world.earth_rate(), gravity, {tau, Block::kGnssDelay, 0.09});
    EXPECT_LT((unsure.residual - residual({tau}) + 0.045 * a).norm(), 1e-9);
    EXPECT_NEAR(unsure.covariance.trace() - 3, 0.5 * 0.09 * 0.09 * a.squaredNorm(), 1e-9);
  }
}

// Fixes of an antenna 1.5 m away that come after their samples, as in real time, against the same fixes in time.
TEST(Delays, AFixThatComesLateFitsLikeOneInTime) {
  const WildMotion motion;
  const double start = 200, length = 30, dt = 0.01;
  const Vector3d arm(0.3, -0.2, -1.45);
  Random random(5);
  FilterOptions o;
  o.sensor.gyro = {.noise = 1e-4, .bias = 1e-4, .drift = {}};
  o.sensor.accel = {.noise = 1e-3, .bias = 1e-3, .drift = {}};
  o.gnss = {{.name = "", .lever_arm = arm}};
  Start known;
  const auto truth = motion.at(start);
  known.time = start;
  known.x.q_wb = truth.q_wb;
  known.x.p_wb = truth.p_wb;
  known.x.v_wb = truth.v_wb;
  known.x.lever_arm = arm;
  known.covariance = Eigen::Matrix<double, 9, 9>::Identity() * 1e-6;
  std::vector<GnssFix> fixes;
  for (double t = start + 0.5037; t < start + length - 0.2; t += 0.1) {
    GnssFix fix = motion.fix(t, arm);
    fix.position += random.vector(1).cwiseProduct(fix.sigma_position);
    fix.velocity->value += random.vector(1).cwiseProduct(fix.velocity->sigma);
    fixes.push_back(fix);
  }
  // Stamped `delay` after their time, and added before the samples pass that time, or at their stamp.
  const auto rms_of = [&](double delay, bool in_time) {
    o.gnss[0].delay = delay;
    Filter filter(o, motion.world, known);
    std::size_t next = 0;
    for (const ImuSample& s : motion.samples(start, start + length, dt)) {
      const double until = in_time ? s.time + filter.look_ahead() + dt : s.time;
      for (; next < fixes.size() && fixes[next].time + delay < until; ++next) {
        GnssFix stamped = fixes[next];
        stamped.time += delay;
        filter.add(0, AnyFix(stamped));
      }
      filter.add(s);
    }
    double square = 0, count = 0;
    for (const Innovation& v : filter.innovations()) {
      if (filter.sources()[static_cast<std::size_t>(v.source)] != "gnss[0].velocity") continue;
      square += v.residual.squaredNorm();
      ++count;
    }
    EXPECT_GT(count, 250);
    return std::sqrt(square / count);
  };
  for (const double delay : {0.05, 0.1}) {
    const double in_time = rms_of(delay, true);
    EXPECT_LT(rms_of(delay, false), 1.1 * in_time) << delay << " s; in time " << in_time;
  }
}

TEST(OwnTimes, AreThoseOfThePositions) {
  std::vector<GnssFix> fixes;
  for (int i = 0; i < 5; ++i) {
    const double t = 10 + i;
    fixes.push_back({t, Vector3d(t, 0, 0), Vector3d::Ones(), FixVelocity{Vector3d(t - 0.6, 1, 0), Vector3d::Ones()}});
  }
  const GnssOptions late{.name = "", .delay = 0.1, .velocity_delay = 0.6};  // so that the velocity at t is t
  const std::vector<GnssFix> own = at_own_times(fixes, late);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(own[i].time, fixes[i].time - 0.1, 1e-12);
    ASSERT_TRUE(own[i].velocity);
    EXPECT_NEAR(own[i].velocity->value.x(), own[i].time, 1e-12);
  }
  EXPECT_FALSE(own[4].velocity) << "the next one, which would tell, is not there";
  GnssOptions velocities = late;
  velocities.use_position = false;
  EXPECT_NEAR(at_own_times(fixes, velocities)[0].time, 9.4, 1e-12);
  EXPECT_EQ(at_own_times(fixes, velocities)[0].velocity->value, fixes[0].velocity->value);
  EXPECT_EQ(at_own_times(fixes, GnssOptions{.name = "", .delay = 0.2})[4].velocity->value, fixes[4].velocity->value);
}

TEST(MotionMean, HasNoLagAndTheNoiseThatItStates) {
  ImuSensor sensor;
  sensor.gyro.noise = 0.01;
  sensor.accel.noise = 0.1;
  static constexpr double kStep = 0.01;
  Random random(3);
  const Quaterniond q = random.rotation();
  const auto step = [](const Vector3d& rate, const Vector3d& force) {
    return ImuStep{kStep, kStep * rate, kStep * force, Vector3d::Zero(), Vector3d::Zero()};
  };
  MotionMean ramp;
  for (int i = 1; i <= 300; ++i) ramp.add(step({0.5 * i * kStep, 0, 0}, {0, 3.0 * i * kStep, 0}), q);
  EXPECT_NEAR(ramp.at(q, sensor).rate.x(), 1.5, 0.01);
  EXPECT_NEAR(ramp.at(q, sensor).force.y(), 9, 0.05);
  EXPECT_NEAR(ramp.at(q, sensor).force_change.y(), 3, 0.3);

  MotionMean noise;
  double force = 0;
  constexpr int kCount = 40000;
  for (int i = 0; i < kCount; ++i) {
    const double root = std::sqrt(kStep);
    noise.add(step(random.vector(sensor.gyro.noise / root), random.vector(sensor.accel.noise / root)), q);
    force += noise.at(q, sensor).force.squaredNorm();
  }
  EXPECT_NEAR(force / (3 * kCount) / noise.at(q, sensor).force_variance, 1, 0.15);
}

TEST(BeyondNoise, NothingIsLeftOfNoise) {
  EXPECT_EQ(beyond_noise({0.1, 0, 0}, 0.01), Vector3d::Zero());
  EXPECT_EQ(beyond_noise({3, 4, 0}, 0), Vector3d(3, 4, 0));
  EXPECT_NEAR(beyond_noise({10, 0, 0}, 1).x(), 9.7, 1e-12);
}

}  // namespace
}  // namespace piste::test
