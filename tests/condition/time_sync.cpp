// Alignments against the truth that they do not know, and logs that must be refused.

#include "piste/condition/time_sync.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>

#include "piste/core/error.h"
#include "piste/math/units.h"
#include "support/imu_pair.h"

namespace piste::test {
namespace {

/// One pair for all that is done to it afterwards.
const ImuPair& ski() {
  static const ImuPair kPair = simulate_pair(pair_scenario("ski", 1, 20, 60), 1);
  return kPair;
}

Alignment aligned(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference) {
  return align(body, reference, {.sensor = ski().setup.sensor, .name = "body.csv"});
}

/// All inside 4 of their sigmas, and these no larger than 0.02 ms of offset, 0.4 ppm of drift, 0.015 deg of boresight
/// and 0.4 mm of lever arm; of the drift, over the part of the log that is there.
void expect_right(const Alignment& a, const ImuSetup& truth, double part_of_log = 1) {
  const Eigen::Matrix<double, 8, 1> e = alignment_error(a, truth);
  Eigen::Matrix<double, 8, 1> largest;
  largest << 0.02e-3, 0.4e-6 / part_of_log, Vector3d::Constant(0.015 / kDegreesPerRadian), Vector3d::Constant(0.4e-3);
  for (int i = 0; i < 8; ++i) {
    EXPECT_LT(std::abs(e(i)), 4 * std::sqrt(a.variance(i))) << i;
    EXPECT_LT(std::sqrt(a.variance(i)), largest(i)) << i;
  }
}

void expect_refused(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                    const std::string& reason) {
  try {
    const Alignment a = aligned(body, reference);
    ADD_FAILURE() << "offset " << a.clock_offset << " ± " << std::sqrt(a.variance(0))
                  << ", should have said: " << reason;
  } catch (const DataError& e) {
    EXPECT_NE(std::string(e.what()).find(reason), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).rfind("body.csv: ", 0), 0U) << e.what();
  }
}

using Change = std::function<void(ImuSample&)>;
std::vector<ImuSample> changed(std::vector<ImuSample> imu, const Change& change) {
  for (ImuSample& s : imu) change(s);
  return imu;
}

/// Without the samples between two times after the first one.
std::vector<ImuSample> without(const std::vector<ImuSample>& imu, double from, double to) {
  std::vector<ImuSample> out;
  const double first = imu.front().time;
  for (const ImuSample& s : imu) {
    if (s.time - first < from || s.time - first >= to) out.push_back(s);
  }
  return out;
}

TEST(TimeSync, FindsWhatWasPutIn) { expect_right(aligned(ski().body, ski().reference), ski().setup); }

TEST(TimeSync, AnyOffset) {
  for (const double offset : {300.0, -300.0, 302400.0}) {
    ImuSetup truth = ski().setup;
    truth.clock_offset += offset;
    expect_right(aligned(changed(ski().body, [&](ImuSample& s) { s.time += offset; }), ski().reference), truth);
  }
}

TEST(TimeSync, LogsThatOverlapInPart) {
  // The body IMU was switched on during the run, the reference off.
  const auto body = without(ski().body, 0, 40);
  const auto reference = without(ski().reference, 75, 1e9);
  ImuSetup truth = ski().setup;
  truth.clock_offset += truth.clock_drift * (body.front().time - ski().body.front().time);
  expect_right(aligned(body, reference), truth, 0.3);
}

TEST(TimeSync, AnyMounting) {
  for (const Vector3d& turn : {Vector3d(0, 0, 90), Vector3d(0, 90, 0), Vector3d(-90, 0, 0), Vector3d(0, 0, 180),
                               Vector3d(180, 0, 0), Vector3d(0, 180, 0), Vector3d(100, -40, 60)}) {
    // A body turned by R: its readings are Rᵀ of those before, and so R_rb becomes R_rb R. Scales stay with their axes
    // only where R maps axes on axes; the others have a scale of their own that is not diagonal, of 1 %.
    const Quaterniond q = so3_exp(turn / kDegreesPerRadian);
    ImuSetup truth = ski().setup;
    truth.q_rb = truth.q_rb * q;
    const auto body = changed(ski().body, [&](ImuSample& s) {
      s.dtheta = q.conjugate() * s.dtheta;
      s.dvel = q.conjugate() * s.dvel;
    });
    const Alignment a = aligned(body, ski().reference);
    const double worst = alignment_error(a, truth).segment<3>(2).cwiseAbs().maxCoeff() * kDegreesPerRadian;
    EXPECT_LT(worst, turn.x() == 100 ? 0.5 : 0.03) << turn.transpose();
  }
}

TEST(TimeSync, ADroppedSecondThatTheTimeStampsShow) {
  // As conditioning gives it: a gap, filled with samples that are marked.
  for (const double at : {45.0, 10.0, 95.0}) {
    const double first = ski().body.front().time;
    const auto body = changed(ski().body, [&](ImuSample& s) {
      if (s.time - first < at || s.time - first > at + 1) return;
      s.gap = GapNoise{};
      s.dtheta.setZero();
      s.dvel.setZero();
    });
    expect_right(aligned(body, ski().reference), ski().setup);
  }
}

TEST(TimeSync, ADroppedSecondThatTheTimeStampsHide) {
  for (const double at : {35.0, 50.0, 65.0}) {
    auto body = without(ski().body, at, at + 1);
    for (ImuSample& s : body) {
      if (s.time - body.front().time >= at) s.time -= 1;
    }
    expect_refused(body, ski().reference, "jumps");
  }
}

TEST(TimeSync, AJumpOfMilliseconds) {
  auto body = ski().body;
  for (ImuSample& s : body) {
    if (s.time - body.front().time >= 50) s.time += 0.06;
  }
  expect_refused(body, ski().reference, "does not run evenly");
}

// In slow motion the rates of both still correlate well at an offset that is half a second wrong.
TEST(TimeSync, AJumpInSlowMotion) {
  for (const double at : {30., 60.}) {
    auto body = ski().body;
    for (ImuSample& s : body) {
      if (s.time - body.front().time >= at) s.time += 0.5;
    }
    expect_refused(body, ski().reference, "the clock of the body IMU jumps: between");
  }
}

TEST(TimeSync, AWrongSampleRate) {
  for (const double ratio : {1.1, 0.9, 1.02, 1.015}) {
    const double first = ski().body.front().time;
    const auto body = changed(ski().body, [&](ImuSample& s) {
      s.time = first + ratio * (s.time - first);
      s.interval *= ratio;
      s.dtheta *= ratio;  // rows are rates
      s.dvel *= ratio;
    });
    expect_refused(body, ski().reference, "% against that of the reference; a wrong sample rate");
    if (ratio == 1.015) expect_refused(body, ski().reference, "or did it jump by some 1.5 s?");
  }
}

TEST(TimeSync, NoMotion) {
  const auto body = without(ski().body, 18, 1e9);
  const auto reference = without(ski().reference, 18, 1e9);
  expect_refused(body, reference, "no motion in common");  // a body that stands sways, which is too little
  RandomStream noise(1, "noise");
  const auto still = [&](ImuSample& s) {
    s.dtheta = 1e-4 * noise.normal3();
    s.dvel = Vector3d(0, 0, -9.81) * s.interval + 1e-3 * noise.normal3();
  };
  expect_refused(changed(ski().body, still), changed(ski().reference, still), "no motion in common");
}

TEST(TimeSync, SaysWhatATurntableDoesNotTell) {
  // Turning about the vertical alone, r on the axis and b beside it: where r is north of b no rate tells, and where it
  // stands along the axis no force.
  RandomStream noise(1, "noise");
  const auto turned = [&](double radius, double start, double rate, double gyro_noise, double accel_noise) {
    std::vector<ImuSample> imu;
    const double dt = 1 / rate;
    for (int k = 1; k <= std::lround(60 * rate); ++k) {
      const double t = k * dt;
      const auto angle = [](double x) { return 2 * std::sin(0.9 * x) + std::sin(2.3 * x + 0.05 * x * x); };
      const double w = (angle(t) - angle(t - dt)) / dt;
      const double w_dot = (angle(t + dt / 2) - 2 * angle(t - dt / 2) + angle(t - 3 * dt / 2)) / (dt * dt);
      ImuSample s;
      s.time = start + t;
      s.interval = dt;
      s.dtheta = Vector3d(0, 0, w * dt) + gyro_noise * std::sqrt(dt) * noise.normal3();
      s.dvel = Vector3d(-w * w * radius, w_dot * radius, -9.81) * dt + accel_noise * std::sqrt(dt) * noise.normal3();
      imu.push_back(s);
    }
    return imu;
  };
  AlignmentOptions options{.sensor = ski().setup.sensor};
  options.reference.gyro.noise = 1e-5;
  options.reference.accel.noise = 3e-4;
  const Alignment a = align(turned(0.3, 1000, 100, 1e-3, 2e-3), turned(0, 50, 200, 1e-5, 3e-4), options);
  const double sigma = std::sqrt(a.variance(AlignmentLayout::kClockOffset));
  EXPECT_LT(std::abs(a.clock_offset - 950), 4 * sigma);
  EXPECT_LT(sigma, 0.02e-3);
  const auto open = [&](const std::string& name) {
    return std::find(a.undetermined.begin(), a.undetermined.end(), name) != a.undetermined.end();
  };
  EXPECT_TRUE(open("boresight z"));
  EXPECT_TRUE(open("lever arm z"));
  EXPECT_FALSE(open("boresight x"));
  EXPECT_TRUE(std::isinf(a.variance(AlignmentLayout::kBoresight + 2)));
  const double radius = a.p_rb_r.head<2>().norm();
  EXPECT_NEAR(radius, 0.3, 0.01);  // as a length it is there, but not where it points
  EXPECT_TRUE(open("lever arm x") || open("lever arm y"));
}

TEST(TimeSync, AnotherRun) {
  const ImuPair other = simulate_pair(pair_scenario("easy_ski", 7, 20, 60), 7);
  expect_refused(ski().body, other.reference, "the motion repeats itself");
}

TEST(TimeSync, MirroredAxes) {
  const auto body = changed(ski().body, [](ImuSample& s) {
    s.dtheta.y() *= -1;
    s.dvel.y() *= -1;
  });
  expect_refused(body, ski().reference, "left-handed");
}

}  // namespace
}  // namespace piste::test
