// Rest, run, rest: from intervals, and from two IMUs alone.

#include "piste/fit/phases.h"

#include <gtest/gtest.h>

#include "piste/condition/aligned_signals.h"
#include "piste/condition/rest_detection.h"
#include "support/aligned_run.h"

namespace piste {
namespace {

void expect_interval(const std::optional<Interval>& found, double start, double end, double tolerance = 0) {
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->start, start, tolerance);
  EXPECT_NEAR(found->end, end, tolerance);
}

TEST(Phases, TheLongestRunAndTheLongestRestOnEitherSide) {
  // A stop of two seconds in the run, somebody who shifts his feet before, and one who walks off after.
  const Phases p = phases({{3, 60}, {64, 80}, {120, 122}, {170, 230}}, {0, 250});
  expect_interval(p.before, 3, 60);
  expect_interval(p.run, 80, 170);
  expect_interval(p.after, 170, 230);
}

TEST(Phases, DoesWithWhatThereIs) {
  Phases p = phases({}, {10, 100});
  EXPECT_FALSE(p.before || p.after);
  expect_interval(p.run, 10, 100);

  p = phases({{10, 100}}, {10, 100});
  EXPECT_FALSE(p.run || p.after);
  expect_interval(p.before, 10, 100);

  p = phases({{0, 40}, {95, 200}}, {20, 90});
  EXPECT_FALSE(p.after);
  expect_interval(p.before, 20, 40);
  expect_interval(p.run, 40, 90);

  EXPECT_FALSE(phases(AlignedImus{}).run);
}

TEST(Phases, FromTwoImusAlone) {
  const test::AlignedRun run{.gyro_bias = {0.5, 0, 0}, .reference_noise = 0.01};
  AlignedImus imus = run.simulate(1);
  const Phases p = phases(low_passed(imus, 12));
  expect_interval(p.before, run.before().start, run.before().end, 1);
  expect_interval(p.run, run.moving().start, run.moving().end, 1);
  expect_interval(p.after, run.after().start, run.after().end, 1);

  // Quantised forces of a tactical IMU are noise of 0.07 m/s² that is mostly high: the low-pass takes it away.
  test::Random random(4);
  Vector3d last = Vector3d::Zero();
  for (Vector3d& f : imus.reference_accel) {
    const Vector3d next = random.vector(0.1);
    f += next - last;
    last = next;
  }
  EXPECT_TRUE(detect_rest(imus).empty());
  expect_interval(phases(low_passed(imus, 12)).run, run.moving().start, run.moving().end, 1);

  // A reference that turns slowly and evenly does not rest.
  for (Vector3d& w : imus.reference_gyro) w.z() += 0.05;
  EXPECT_FALSE(phases(low_passed(imus, 12)).before);
}

TEST(Phases, SpanWhatIsUsable) {
  const test::AlignedRun run;
  AlignedImus imus = run.simulate(1);
  std::fill_n(imus.usable.begin(), 1000, std::uint8_t{0});
  expect_interval(phases(low_passed(imus, 12)).before, run.start + 10, run.before().end, 1);
}

TEST(AlignedSignals, StretchesEndAtGapsAndAtWhatIsNotUsable) {
  const test::AlignedRun run{.rest = 5, .run = 5};
  AlignedImus imus = run.simulate(1);
  imus.usable[300] = 0;
  for (std::size_t i = 800; i < imus.time.size(); ++i) imus.time[i] += 1;
  const auto stretches = usable_stretches(imus);
  ASSERT_EQ(stretches.size(), 3U);
  EXPECT_EQ(stretches[0].last, 300U);
  EXPECT_EQ(stretches[1].first, 301U);
  EXPECT_EQ(stretches[1].last, 800U);
  EXPECT_EQ(stretches[2].size(), 700U);
}

TEST(AlignedSignals, LowPassKeepsMotionTakesNoiseAndMixesNoStretches) {
  const test::AlignedRun run{.gyro_noise = 0.1};
  AlignedImus imus = run.simulate(1);
  for (std::size_t i = 2000; i < 2010; ++i) {
    imus.usable[i] = 0;
    imus.gyro[i].x() = 1e9;
  }
  for (const std::size_t i : {100, 110}) imus.usable[i] = 0;  // nine samples between are too few
  const AlignedImus smooth = low_passed(imus, 12);
  double noise = 0;
  for (std::size_t i = 200; i < 3900; ++i) {
    if (smooth.usable[i]) noise += (smooth.gyro[i] - run.gyro_bias).squaredNorm() / (3 * 3690);
  }
  EXPECT_NEAR(noise / 0.01, 0.23, 0.03) << "12 of 50 Hz";
  EXPECT_EQ(smooth.gyro[2005].x(), 1e9);
  for (std::size_t i = 101; i < 110; ++i) EXPECT_FALSE(smooth.usable[i]);
  EXPECT_EQ(low_passed(imus, 0).gyro, imus.gyro);
}

}  // namespace
}  // namespace piste
