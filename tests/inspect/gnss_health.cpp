#include "piste/inspect/gnss_health.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

#include "piste/math/earth.h"
#include "piste/math/units.h"

namespace piste::test {
namespace {

struct Receiver {
  double interval = 0.2, noise = 0.02, sigma = 0.02, velocity_noise = 0.02, delay = 0;
  bool velocity = true;
  unsigned seed = 1;
};

// Ten seconds of rest, then a winding track of 80 s at 8 m/s that climbs and falls, and ten seconds of rest.
Vector3d place(double t) {
  const double s = std::clamp(t - 10, 0.0, 80.0);
  return {60 * std::sin(s / 8), 60 * std::cos(s / 8) + 3 * s, 10 * std::sin(s / 10)};
}

Vector3d velocity(double t) {
  constexpr double kStep = 1e-4;
  return (place(t + kStep) - place(t - kStep)) / (2 * kStep);
}

GnssRecording drive(const Receiver& r) {
  std::mt19937 random(r.seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Vector3d(sigma * Vector3d(x, y, z));
  };
  const World world({46 * kDegree, 7 * kDegree, 500});
  GnssRecording gnss;
  for (int i = 0; i * r.interval < 100; ++i) {
    const double t = i * r.interval;
    GeodeticFix f;
    f.time = 1000 + t;
    f.position = world.to_geodetic(place(t) + noise(r.noise));
    f.sigma_position = Vector3d::Constant(r.sigma);
    if (r.velocity) {
      f.velocity = {.value = velocity(t - r.delay) + noise(r.velocity_noise),
                    .sigma = Vector3d::Constant(r.velocity_noise)};
    }
    f.quality = FixQuality::kFixed;
    gnss.fixes.push_back(f);
  }
  return gnss;
}

bool names(const std::vector<Suspicion>& all, LogFault fault) {
  return std::any_of(all.begin(), all.end(), [fault](const Suspicion& s) { return s.fault == fault; });
}

TEST(GnssHealth, FiguresOfAGoodReceiver) {
  for (const bool velocity : {true, false}) {
    const GnssHealth h = gnss_health(drive({.velocity = velocity}));
    EXPECT_EQ(h.sampling.rows, 500U);
    EXPECT_NEAR(h.sampling.interval, 0.2, 1e-9);
    EXPECT_EQ(h.qualities[static_cast<std::size_t>(FixQuality::kFixed)], 500U);
    EXPECT_EQ(h.velocities, velocity ? 500U : 0U);
    ASSERT_EQ(h.rest.size(), 2U);
    EXPECT_NEAR(h.rest[0].end, 1010, 1);
    EXPECT_NEAR(h.rest[1].start, 1090, 1);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(h.noise(axis), 0.02, velocity ? 0.003 : 0.005);
      EXPECT_NEAR(h.rest_scatter(axis), 0.02, 0.007);
    }
    EXPECT_NEAR(h.speed, 8, 1);
    EXPECT_NEAR(h.highest - h.lowest, 20, 0.5);
    EXPECT_EQ(h.quantum, Vector3d::Zero());
    EXPECT_TRUE(h.jumps.empty());
    EXPECT_TRUE(h.repeated.empty());
    EXPECT_EQ(h.velocity.has_value(), velocity);
    if (h.velocity) {
      EXPECT_TRUE(h.velocity->as_given());
      EXPECT_LT(std::abs(h.velocity->delay), 4 * h.velocity->sigma_delay);
      EXPECT_LT(h.velocity->sigma_delay, 0.01);
    }
    const std::vector<Suspicion> found = suspicions(h, {}, "gnss");
    EXPECT_EQ(found.size(), velocity ? 0U : 1U);
    EXPECT_EQ(names(found, LogFault::kNoVelocity), !velocity);
  }
}

TEST(GnssHealth, DelayOfTheVelocities) {
  for (const double delay : {0.125, -0.2}) {
    const GnssHealth h = gnss_health(drive({.delay = delay}));
    ASSERT_TRUE(h.velocity);
    EXPECT_NEAR(h.velocity->delay, delay, 0.015);
    EXPECT_LT(std::abs(h.velocity->delay - delay), 5 * h.velocity->sigma_delay);
    EXPECT_LT(h.velocity->sigma_delay, 0.01);
    const std::vector<Suspicion> found = suspicions(h, {}, "gnss");
    ASSERT_EQ(found.size(), 1U);
    EXPECT_FALSE(is_severe(found.front().fault));
    ASSERT_TRUE(h.velocity->known_delay());
    EXPECT_NE(found.front().remedy.find(fmt::format("velocity_delay: {:.3f} s", h.velocity->delay)), std::string::npos);
  }
}

// At 5 Hz with the positions of RTK, and at 1 Hz with those of a phone: the sigma is careful, by a factor of two to
// three, as the noise of a position that ends one window and begins another cancels.
TEST(GnssHealth, TheSigmaOfTheDelayIsCareful) {
  for (const Receiver& kind : {Receiver{.delay = 0.13},
                               Receiver{.interval = 1, .noise = 1, .sigma = 3, .velocity_noise = 0.3, .delay = 0.25}}) {
    constexpr int kSeeds = 40;
    double squares = 0, sum = 0;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      Receiver r = kind;
      r.seed = seed;
      const GnssHealth h = gnss_health(drive(r));
      ASSERT_TRUE(h.velocity);
      const double error = (h.velocity->delay - r.delay) / h.velocity->sigma_delay;
      squares += error * error / kSeeds;
      sum += h.velocity->sigma_delay / kSeeds;
    }
    std::printf("%.1f Hz: sigma %.4f s, errors of %.2f sigma\n", 1 / kind.interval, sum, std::sqrt(squares));
    EXPECT_LT(std::sqrt(squares), 1.2);
    EXPECT_GT(std::sqrt(squares), 0.2);
  }
}

TEST(GnssHealth, ADelayIsKnownOnlyBeyondDoubt) {
  const auto known = [](double delay, double sigma) {
    VelocityFit fit;
    fit.delay = delay;
    fit.sigma_delay = sigma;
    return fit.known_delay();
  };
  EXPECT_EQ(known(-0.1, 0.01), -0.1);
  EXPECT_FALSE(known(0.1, 0.04));
  EXPECT_FALSE(known(0.008, 0.001)) << "which a receiver's smoothing may make";
  VelocityFit swapped;
  swapped.delay = 0.2;
  swapped.scale = 3.6;
  EXPECT_FALSE(swapped.known_delay()) << "the velocities are wrong otherwise";
}

TEST(GnssHealth, ReadingsOfTheVelocities) {
  const auto spoil = [](const auto& change) {
    GnssRecording gnss = drive({});
    for (GeodeticFix& f : gnss.fixes) change(f.velocity->value);
    return gnss_health(gnss).velocity.value();
  };
  const VelocityFit up = spoil([](Vector3d& v) { v.z() = -v.z(); });
  EXPECT_TRUE(up.axes == Matrix3d(Vector3d(1, 1, -1).asDiagonal()));
  EXPECT_EQ(up.scale, 1);
  const VelocityFit miles = spoil([](Vector3d& v) { v *= 3600 / 1609.344; });
  EXPECT_TRUE(miles.axes.isIdentity());
  EXPECT_EQ(miles.scale, 3600 / 1609.344);
  const VelocityFit both = spoil([](Vector3d& v) { v = 3.6 * Vector3d(v.y(), v.x(), -v.z()); });
  EXPECT_TRUE(both.axes * Vector3d(1, 2, 3) == Vector3d(2, 1, -3));
  EXPECT_EQ(both.scale, 3.6);
  EXPECT_LT(both.residual, 0.3);
  GnssRecording other = drive({});
  for (GeodeticFix& f : other.fixes) std::swap(f.position.latitude, f.position.longitude);
  const VelocityFit interchanged = gnss_health(other).velocity.value();
  EXPECT_TRUE(interchanged.interchanged);
  EXPECT_TRUE(interchanged.axes.isIdentity());
}

TEST(GnssHealth, JumpsAreCountedOnce) {
  for (const bool velocity : {true, false}) {
    GnssRecording gnss = drive({.velocity = velocity});
    for (const std::size_t i : {100U, 200U, 201U, 333U}) gnss.fixes[i].position.height += 12;
    const GnssHealth h = gnss_health(gnss);
    ASSERT_GE(h.jumps.size(), 3U);
    EXPECT_LE(h.jumps.size(), 4U);  // there and back, of two fixes in a row
    EXPECT_EQ(h.jumps.front().time, gnss.fixes[100].time);
    EXPECT_NEAR(h.jumps.front().distance, 12, 0.5);
    EXPECT_EQ(suspicions(h, {}, "gnss").front().fault, LogFault::kPositionJumps);
    // What a receiver admits is no jump.
    for (GeodeticFix& f : gnss.fixes) f.sigma_position.setConstant(5);
    EXPECT_TRUE(gnss_health(gnss).jumps.empty());
  }
}

TEST(GnssHealth, RepeatedFixesOnlyInMotion) {
  GnssRecording gnss = drive({});
  const auto repeat = [&](std::size_t from, std::size_t count) {
    for (std::size_t i = 1; i <= count; ++i) gnss.fixes[from + i].position = gnss.fixes[from].position;
  };
  repeat(5, 30);  // at rest
  EXPECT_TRUE(gnss_health(gnss).repeated.empty());
  repeat(200, 15);
  const GnssHealth h = gnss_health(gnss);
  ASSERT_EQ(h.repeated.size(), 1U);
  EXPECT_EQ(h.repeated[0].start, gnss.fixes[200].time);
  EXPECT_EQ(h.repeated[0].end, gnss.fixes[215].time);
  EXPECT_TRUE(h.jumps.empty());
  EXPECT_EQ(suspicions(h, {}, "gnss").front().fault, LogFault::kRepeatedFix);
}

// A receiver that begins with the place where it was switched off, kilometres away, and repeats it until it has a fix.
TEST(GnssHealth, AJumpBesideRepeatedFixesIsOne) {
  for (const bool velocity : {true, false}) {
    GnssRecording gnss = drive({.velocity = velocity});
    const World world(gnss.fixes[0].position);
    for (std::size_t i = 200; i < 215; ++i) gnss.fixes[i].position = world.to_geodetic({20000, 30000, 0});
    EXPECT_TRUE(names(suspicions(gnss_health(gnss), {}, "gnss"), LogFault::kPositionJumps));
  }
}

TEST(GnssHealth, SigmasAgainstScatter) {
  const auto named = [](double noise, double sigma, LogFault fault) {
    return names(suspicions(gnss_health(drive({.noise = noise, .sigma = sigma})), {}, "gnss"), fault);
  };
  EXPECT_TRUE(named(0.5, 0.05, LogFault::kSigmaTooSmall));
  EXPECT_FALSE(named(0.5, 0.3, LogFault::kSigmaTooSmall));
  EXPECT_FALSE(named(0.02, 0.05, LogFault::kSigmaTooLarge));
  EXPECT_TRUE(named(0.02, 1, LogFault::kSigmaTooLarge));
  EXPECT_TRUE(named(0.02, 0, LogFault::kSigmaTooSmall));
}

TEST(GnssHealth, RoundingOfCoordinates) {
  const auto rounded = [](double unit) {
    GnssRecording gnss = drive({});
    for (GeodeticFix& f : gnss.fixes) {
      f.position.latitude = std::round(f.position.latitude / unit) * unit;
      f.position.longitude = std::round(f.position.longitude / unit) * unit;
    }
    return gnss_health(gnss);
  };
  const GnssHealth decimal = rounded(1e-5 * kDegree);
  EXPECT_NEAR(decimal.quantum.x(), 1.11, 0.01);
  EXPECT_NEAR(decimal.quantum.y(), 1.11 * std::cos(46 * kDegree), 0.01);
  EXPECT_EQ(suspicions(decimal, {}, "gnss").front().fault, LogFault::kCoordinatesRounded);
  const GnssHealth minutes = rounded(1e-4 / 60 * kDegree);  // NMEA with four decimals
  EXPECT_NEAR(minutes.quantum.x(), 0.185, 0.002);
  EXPECT_TRUE(names(suspicions(minutes, {}, "gnss"), LogFault::kCoordinatesRounded));
  const GnssHealth fine = rounded(1e-7 * kDegree);  // as receivers have it in binary
  EXPECT_NEAR(fine.quantum.x(), 0.011, 0.001);
  EXPECT_FALSE(names(suspicions(fine, {}, "gnss"), LogFault::kCoordinatesRounded));
}

TEST(GnssHealth, OfNothingAndOfNoMotion) {
  EXPECT_EQ(suspicions(gnss_health({}), {}, "gnss").front().fault, LogFault::kEmpty);
  GnssRecording gnss = drive({});
  gnss.fixes.resize(45);
  gnss.without_fix = 7;
  const std::vector<Suspicion> found = suspicions(gnss_health(gnss), {}, "gnss");
  EXPECT_TRUE(names(found, LogFault::kNoMotion));
  EXPECT_TRUE(names(found, LogFault::kNoFix));
  EXPECT_FALSE(is_severe(found.front().fault));
}

}  // namespace
}  // namespace piste::test
