// What a start is made of, fix by fix; whether headings are found is scenario/heading's to tell.

#include "piste/start/start.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "piste/core/error.h"
#include "start/start_motion.h"
#include "support/synthetic_log.h"
#include "support/text_file.h"

namespace piste {
namespace {

using Source = InitialHeading::Source;
using test::contains;
using test::message_of;
using test::SyntheticRun;

/// A run of two seconds of rest and six of motion, or of the motion alone.
SyntheticRun run_of(bool rest) {
  SyntheticRun s = test::synthetic_run(8, {Block::kGyroBias, Block::kAccelBias});
  if (rest) return s;
  const double begin = s.start.time + 4;
  std::erase_if(s.log.imu, [&](const ImuSample& i) { return i.time <= begin + 1e-6; });
  for (auto& fixes : s.log.gnss) std::erase_if(fixes, [&](const GnssFix& f) { return f.time < begin - 1e-6; });
  s.log.rest.clear();
  return s;
}

/// The heading of the truth, given.
InitialHeading given(const SyntheticRun& s) {
  test::WildMotion motion;
  motion.begin = s.start.time + 2;
  const double begin = s.log.imu.front().time - s.log.imu.front().interval;
  return {Source::kValue, to_euler(motion.at(begin).q_wb).z(), 0.02};
}

Start start_of(const SyntheticRun& s) { return find_start(s.log, s.options, given(s)).start; }

test::WildMotion::State truth_of(const SyntheticRun& s, double time) {
  test::WildMotion motion;
  motion.begin = s.start.time + 2;
  return motion.at(time);
}

/// Position and velocity within 4 of the sigmas that the start claims, which are a metre or three of the fix's, and two
/// metres a second at most.
void expect_placed(const Start& start, const SyntheticRun& s) {
  const auto truth = truth_of(s, start.time);
  const Vector3d position = start.covariance.diagonal().head<3>().cwiseSqrt(),
                 velocity = start.covariance.diagonal().segment<3>(3).cwiseSqrt();
  EXPECT_LT((truth.p_wb - start.x.p_wb).cwiseQuotient(position).cwiseAbs().maxCoeff(), 4);
  EXPECT_LT((truth.v_wb - start.x.v_wb).cwiseQuotient(velocity).cwiseAbs().maxCoeff(), 4);
  EXPECT_LE(position.maxCoeff(), 1.5);
  EXPECT_LE(velocity.maxCoeff(), 2);
}

TEST(Start, SaysWhatIsMissing) {
  SyntheticRun s = run_of(true);
  SyntheticRun none = s;
  none.log.imu.clear();
  EXPECT_TRUE(contains(message_of<DataError>([&] { find_start(none.log, none.options, {}); }), "no IMU sample"));
  none = s;
  for (auto& fixes : none.log.gnss) fixes.clear();
  EXPECT_TRUE(contains(message_of<DataError>([&] { find_start(none.log, none.options, {}); }), "no GNSS fix"));
  none = s;
  none.log.attitude[0].clear();
  EXPECT_TRUE(
      contains(message_of<DataError>([&] { find_start(none.log, none.options, {.source = Source::kAttitude}); }),
               "from_attitude needs an attitude log"));
  none = s;
  none.log.magnetic.clear();
  EXPECT_TRUE(
      contains(message_of<DataError>([&] { find_start(none.log, none.options, {.source = Source::kMagnetometer}); }),
               "from_magnetometer needs the columns"));
}

// Its azimuth would be taken for the heading without a word.
TEST(Start, RefusesAMagneticFieldThatIsNotTheEarths) {
  SyntheticRun s = run_of(true);
  const InitialHeading magnetic{.source = Source::kMagnetometer};
  EXPECT_NO_THROW(find_start(s.log, s.options, magnetic));
  SyntheticRun wrong = s;
  for (MagneticSample& sample : wrong.log.magnetic) sample.field = -sample.field;
  EXPECT_TRUE(contains(message_of<DataError>([&] { find_start(wrong.log, wrong.options, magnetic); }), "dips by -"));
  for (MagneticSample& sample : wrong.log.magnetic) sample.field.setZero();
  EXPECT_TRUE(contains(message_of<DataError>([&] { find_start(wrong.log, wrong.options, magnetic); }), "is zero"));
}

TEST(Start, TriesAsManyHeadingsAsTheOptionsSay) {
  SyntheticRun s = run_of(false);
  const auto headings = [&] {
    const Receiver receiver = first_receiver(s.log, s.options);
    return heading_hypotheses(s.log, s.options, receiver, beginning(s.log, receiver, s.options.behaviour.start).time);
  };
  EXPECT_EQ(headings().size(), 12u);
  s.options.behaviour.start.hypotheses = 8;
  const std::vector<Start> eight = headings();
  ASSERT_EQ(eight.size(), 8u);
  EXPECT_NEAR(std::sqrt(eight[3].covariance(8, 8)), 22.5 * kDegree, 1e-9);
}

TEST(Start, IsThatOfTheFirstReceiverWithFixes) {
  SyntheticRun s = run_of(true);
  s.log.gnss[0].clear();
  s.options.gnss[0].lever_arm = Vector3d(5, 5, 5);
  const Start start = start_of(s);
  EXPECT_EQ(start.x.lever_arm, s.options.gnss[1].lever_arm);
  expect_placed(start, s);
}

TEST(Start, AtRestStandsStill) {
  const SyntheticRun s = run_of(true);
  const Start start = start_of(s);
  EXPECT_EQ(start.time, s.start.time);
  EXPECT_EQ(start.x.v_wb, Vector3d::Zero());
  EXPECT_LT(start.covariance(3, 3), 0.0101);
  expect_placed(start, s);
  EXPECT_LT(so3_log(truth_of(s, start.time).q_wb * start.x.q_wb.conjugate()).norm(), 0.01) << "levelled by the rest";
}

TEST(Start, OnTheMoveBeginsWithAFixAndItsVelocity) {
  const SyntheticRun s = run_of(false);
  const Start start = start_of(s);
  EXPECT_GT(start.x.v_wb.norm(), 2);
  EXPECT_GT(start.covariance(3, 3), 0.2);
  expect_placed(start, s);
}

// A sample is longer than the second over which the force is averaged.
TEST(Start, OnTheMoveWithSamplesLongerThanASecond) {
  SyntheticRun s = run_of(false);
  std::vector<ImuSample> slow;
  for (std::size_t i = 0; i < s.log.imu.size(); ++i) {
    const ImuSample& part = s.log.imu[i];
    if (slow.empty() || slow.back().interval > 1.2 - 1e-6) {
      slow.push_back(part);
      continue;
    }
    slow.back().time = part.time;
    slow.back().interval += part.interval;
    slow.back().dtheta += part.dtheta;
    slow.back().dvel += part.dvel;
  }
  s.log.imu = std::move(slow);
  EXPECT_NO_THROW(start_of(s));
}

TEST(Start, WithoutVelocitiesTakesThatOfTwoFixes) {
  SyntheticRun s = run_of(false);
  const Vector3d told = start_of(s).x.v_wb;
  for (GnssFix& fix : s.log.gnss[0]) fix.velocity.reset();
  const Start start = start_of(s);
  expect_placed(start, s);
  EXPECT_NE(start.x.v_wb, told);

  // Of a velocity without down, down is that of the positions.
  s = run_of(false);
  for (GnssFix& fix : s.log.gnss[0]) {
    fix.velocity->value.z() = 0;
    fix.velocity->sigma.z() = std::numeric_limits<double>::infinity();
  }
  const Start horizontal = start_of(s);
  EXPECT_LT(horizontal.covariance(3, 3), 0.5 * horizontal.covariance(5, 5));
  expect_placed(horizontal, s);
}

TEST(Start, PassesAnOutlierInTheFirstFix) {
  for (const bool rest : {true, false}) {
    SyntheticRun s = run_of(rest);
    s.log.gnss[0].front().position += Vector3d(500, 0, 0);
    expect_placed(start_of(s), s);
  }
}

TEST(Start, NothingIsKnownBeforeTheFirstFixOfABodyThatMoves) {
  SyntheticRun s = run_of(false);
  const double first = s.log.imu.front().time + 1;
  std::erase_if(s.log.gnss[0], [&](const GnssFix& f) { return f.time < first; });
  const Start start = start_of(s);
  EXPECT_EQ(start.time, s.log.gnss[0].front().time);
}

/// How far the start's attitude is from the truth [rad].
double turned(const Start& start, const SyntheticRun& s) {
  return truth_of(s, start.time).q_wb.angularDistance(start.x.q_wb);
}

TEST(Start, TakesTheHeadingOfTheReference) {
  const InitialHeading reference{.source = Source::kAttitude};
  for (const bool rest : {true, false}) {
    SyntheticRun s = run_of(rest);
    const FoundStart found = find_start(s.log, s.options, reference);
    EXPECT_EQ(found.how, "heading at the start from the reference attitude");
    EXPECT_LT(turned(found.start, s), 0.01);
    expect_placed(found.start, s);

    // Its first fix comes late: the gyroscopes carry it back, and the heading is less sure.
    std::erase_if(s.log.attitude[0], [&](const AttitudeFix& f) { return f.time < found.start.time + 2.5; });
    const FoundStart later = find_start(s.log, s.options, reference);
    EXPECT_LT(turned(later.start, s), 0.02);
    EXPECT_GT(later.start.covariance(8, 8), found.start.covariance(8, 8));

    // The first source without fixes is passed over.
    s.log.attitude.insert(s.log.attitude.begin(), std::vector<AttitudeFix>{});
    s.options.attitude.insert(s.options.attitude.begin(), AttitudeOptions{.name = "", .drift = {}});
    EXPECT_EQ(turned(find_start(s.log, s.options, reference).start, s), turned(later.start, s));
  }
}

// All fixes are before the start, which waits for a receiver: the last one counts.
TEST(Start, TakesTheLastAttitudeWhereNoneFollows) {
  SyntheticRun s = run_of(false);
  const double first = s.log.imu.front().time + 0.3;
  std::erase_if(s.log.gnss[0], [&](const GnssFix& f) { return f.time < first; });
  for (GnssFix& f : s.log.gnss[1]) f.time += 1000;
  AttitudeFix last = s.log.attitude[0].front();
  last.q_wr = truth_of(s, s.log.gnss[0].front().time).q_wb;
  s.log.attitude[0] = {last};
  const FoundStart found = find_start(s.log, s.options, {.source = Source::kAttitude});
  EXPECT_GT(found.start.time, last.time);
  EXPECT_LT(turned(found.start, s), 1e-6);
}

TEST(Start, FindsTheBoresightOfTheReferenceFromTheRatesOfBoth) {
  SyntheticRun s = run_of(true);
  s.options.estimate.push_back(Block::kBoresight);
  const Quaterniond q_rb = from_euler({0.4, -1, 2});
  for (AttitudeFix& f : s.log.attitude[0]) f.q_wr = f.q_wr * q_rb.conjugate();
  const FoundStart found = find_start(s.log, s.options, {.source = Source::kAttitude});
  EXPECT_TRUE(contains(found.how, ", through the boresight from the rates of both")) << found.how;
  EXPECT_LT(turned(found.start, s), 0.02);
}

TEST(Start, TakesABoresightForSmallOnlyWhereGravityAgrees) {
  SyntheticRun s = run_of(true);
  s.options.estimate.push_back(Block::kBoresight);
  // The reference is silent once the body moves.
  std::erase_if(s.log.attitude[0], [&](const AttitudeFix& f) { return f.time > s.log.rest[0].end; });
  const InitialHeading reference{.source = Source::kAttitude};
  const FoundStart found = find_start(s.log, s.options, reference);
  EXPECT_TRUE(contains(found.how, ", the boresight taken for small")) << found.how;
  EXPECT_LT(turned(found.start, s), 0.01);
  EXPECT_NEAR(std::sqrt(found.start.covariance(8, 8)), 3 * s.options.priors.boresight,
              0.3 * s.options.priors.boresight);
  const Quaterniond q_rb = from_euler({60 * kDegree, 0, 0});
  for (AttitudeFix& f : s.log.attitude[0]) f.q_wr = f.q_wr * q_rb.conjugate();
  const std::string refused = message_of<DataError>([&] { find_start(s.log, s.options, reference); });
  EXPECT_TRUE(contains(refused, "gravity says that it sits some 59 deg off the reference")) << refused;
}

TEST(Start, TakesTheLastFieldWhereNoneFollows) {
  SyntheticRun s = run_of(false);
  const double first = s.log.imu.front().time + 0.3;
  for (auto& fixes : s.log.gnss) std::erase_if(fixes, [&](const GnssFix& f) { return f.time < first; });
  const double begin = s.log.gnss[0].front().time;
  MagneticSample last = s.log.magnetic.front();
  last.time = begin - 0.1;
  last.field = truth_of(s, begin).q_wb.conjugate() * last.earth;
  s.log.magnetic = {last};
  const FoundStart found = find_start(s.log, s.options, {.source = Source::kMagnetometer, .sigma = 0.02});
  EXPECT_EQ(found.how, "heading at the start from the magnetometer");
  EXPECT_NEAR(to_euler(found.start.x.q_wb).z(), to_euler(truth_of(s, begin).q_wb).z(), 0.3) << "by its level";
}

/// The run of a body without another source of its attitude.
SyntheticRun lone_run_of(bool rest) {
  SyntheticRun s = run_of(rest);
  s.log.attitude[0].clear();
  s.log.magnetic.clear();
  return s;
}

/// A run until `seconds` after its begin.
SyntheticRun cut(SyntheticRun s, double seconds) {
  const double end = s.start.time + seconds + 1e-6;
  std::erase_if(s.log.imu, [&](const ImuSample& i) { return i.time > end; });
  for (auto& fixes : s.log.gnss) std::erase_if(fixes, [&](const GnssFix& f) { return f.time > end; });
  return s;
}

double heading_error(const Start& start, const SyntheticRun& s) {
  return std::abs(so3_log(truth_of(s, start.time).q_wb * start.x.q_wb.conjugate()).z());
}

TEST(Start, FindsTheHeadingFromTheMotion) {
  for (const bool rest : {true, false}) {
    const SyntheticRun s = lone_run_of(rest);
    const FoundStart found = find_start(s.log, s.options, {});
    EXPECT_TRUE(contains(found.how, "from the motion until t = ")) << found.how;
    ASSERT_TRUE(found.aligned);
    const double sigma = std::sqrt(found.start.covariance(8, 8));
    EXPECT_LT(heading_error(found.start, s), 4 * sigma);
    EXPECT_LT(sigma, 0.3);
    EXPECT_EQ(found.start.time, rest ? s.start.time : s.log.gnss[0].front().time);
  }
}

TEST(Start, SaysThatTheMotionDoesNotTellTheHeading) {
  const SyntheticRun still = cut(lone_run_of(true), 2);
  EXPECT_TRUE(contains(message_of<DataError>([&] { find_start(still.log, still.options, {}); }),
                       "the body does not leave its place while GNSS is there"));
}

// By coarse positions alone, on a walk that is shorter than what they state in all directions.
TEST(Start, FindsTheHeadingByCoarsePositions) {
  SyntheticRun s = cut(lone_run_of(true), 5);
  for (auto& fixes : s.log.gnss) {
    for (GnssFix& f : fixes) {
      f.velocity.reset();
      f.sigma_position.setConstant(3);
    }
  }
  const FoundStart found = find_start(s.log, s.options, {});
  ASSERT_TRUE(found.aligned) << found.how;
  EXPECT_LT(heading_error(found.start, s), 0.3);
  EXPECT_EQ(found.start.time, s.start.time) << "that of the rest before it";
}

TEST(Start, SaysThatTheFilterDivergesWithEveryHeading) {
  SyntheticRun s = lone_run_of(true);
  for (ImuSample& i : s.log.imu) {
    if (i.time > s.start.time + 2.05) i.dvel *= 1e160;
  }
  EXPECT_TRUE(contains(message_of<DataError>([&] { find_start(s.log, s.options, {}); }),
                       "the filter diverges with every heading"));
}

}  // namespace
}  // namespace piste
