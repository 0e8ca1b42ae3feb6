#include "piste/math/units.h"

#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

namespace piste {
namespace {

struct Case {
  std::string_view text;
  Dimension dimension;
  double value;
};

TEST(Units, DatasheetTextBecomesSi) {
  const Case cases[] = {
      {"0.05 deg/s/sqrt(Hz)", dimension::kGyroNoise, 0.05 * kDegree},
      {"0.3 deg/sqrt(h)", dimension::kGyroNoise, 0.3 * kDegree / 60},
      {"1e-3 rad/s/sqrt(Hz)", dimension::kGyroNoise, 1e-3},
      {"6 deg/h/sqrt(Hz)", dimension::kGyroNoise, 6 * kDegree / 3600},
      {"200 ug/sqrt(Hz)", dimension::kAccelNoise, 200e-6 * 9.80665},
      {"0.2 mg/sqrt(Hz)", dimension::kAccelNoise, 200e-6 * 9.80665},
      {"0.6 m/s/sqrt(h)", dimension::kAccelNoise, 0.01},
      {"0.002 m/s^2/sqrt(Hz)", dimension::kAccelNoise, 0.002},
      {"4e-5 deg/s^2/sqrt(Hz)", dimension::kGyroDrift, 4e-5 * kDegree},
      {"4e-5 m/s^3/sqrt(Hz)", dimension::kAccelDrift, 4e-5},
      {"90 deg/h", dimension::kAngularRate, 90 * kDegree / 3600},
      {"300deg/s", dimension::kAngularRate, 300 * kDegree},
      {"+2 g", dimension::kAcceleration, 19.6133},
      {"  50 mg ", dimension::kAcceleration, 0.4903325},
      {"10000 ppm", dimension::kRatio, 0.01},
      {"2 %", dimension::kRatio, 0.02},
      {"0.5", dimension::kRatio, 0.5},
      {"36 km/h", dimension::kVelocity, 10},
      {"90 deg", dimension::kAngle, std::numbers::pi / 2},
      {"2 min", dimension::kTime, 120},
      {"0 s", dimension::kTime, 0},
      {"12 Hz", dimension::kFrequency, 12},
      {"48 uT", dimension::kMagneticField, 48e-6},
      {"-3 cm", dimension::kLength, -0.03},
  };
  for (const Case& c : cases)
    EXPECT_NEAR(parse_quantity(c.text, c.dimension), c.value, 1e-14 * std::abs(c.value)) << c.text;
}

// Both sides are one quantity.
TEST(Units, OfOneKindAreMultiplesOfOneAnother) {
  struct Equal {
    std::string_view one, other;
    Dimension dimension;
  };
  const Equal equals[] = {
      {"1 deg", "60 arcmin", dimension::kAngle},
      {"1 arcmin", "60 arcsec", dimension::kAngle},
      {"1 rad", "1000 mrad", dimension::kAngle},
      {"1 km", "1000 m", dimension::kLength},
      {"1 m", "1000 mm", dimension::kLength},
      {"1 hr", "60 min", dimension::kTime},
      {"1 h", "3600 s", dimension::kTime},
      {"1 s", "1e6 us", dimension::kTime},
      {"1 ms", "1000 us", dimension::kTime},
      {"1 T", "1e6 uT", dimension::kMagneticField},
      {"1 mT", "1e6 nT", dimension::kMagneticField},
      {"1 Gal", "1000 mGal", dimension::kAcceleration},
      {"1 Gal", "0.01 m/s^2", dimension::kAcceleration},
      {"1 g", "1e6 ug", dimension::kAcceleration},
      {"1 %", "10000 ppm", dimension::kRatio},
      {"3 m/s^2", "3 m*s^-2", dimension::kAcceleration},
      {"3 m/s^2", "3 m/s/s", dimension::kAcceleration},
      {"3 m/s^2", "3 m*Hz^2", dimension::kAcceleration},
      {"1 deg/s/√(Hz)", "1 deg/sqrt(s)", dimension::kGyroNoise},
      {"1 deg/s/sqrt(Hz)", "1 sqrt(deg^2/s)", dimension::kGyroNoise},
      {"2 1", "2", dimension::kRatio},
  };
  for (const Equal& e : equals) {
    const double other = parse_quantity(e.other, e.dimension);
    EXPECT_NEAR(parse_quantity(e.one, e.dimension), other, 1e-14 * other) << e.one << " and " << e.other;
  }
}

TEST(Units, AVectorIsThreeNumbersAndOneUnit) {
  EXPECT_TRUE(parse_vector("-0.06 0.03 -0.42 m", dimension::kLength).isApprox(Eigen::Vector3d(-0.06, 0.03, -0.42)));
  EXPECT_THROW(parse_vector("1 2 m", dimension::kLength), std::invalid_argument);
  EXPECT_THROW(parse_vector("1 2 3 4 m", dimension::kLength), std::invalid_argument);
  EXPECT_THROW(parse_vector("1 2 3", dimension::kLength), std::invalid_argument);
}

TEST(Units, WhatIsWrongSaysWhatWouldBeRight) {
  const std::pair<std::string_view, Dimension> wrong[] = {
      {"0.05", dimension::kGyroNoise},
      {"0.05 deg/s", dimension::kGyroNoise},
      {"0.05 furlong", dimension::kLength},
      {"abc", dimension::kTime},
      {"1 2 s", dimension::kTime},
      {"nan s", dimension::kTime},
      {"inf s", dimension::kTime},
      {"1 rad", dimension::kLength},
      {"1 deg/", dimension::kAngle},
      {"1 sqrt(s", dimension::kTime},
      {"1 s^x", dimension::kTime},
      {"", dimension::kTime},
      {"1 sqrt(sqrt(Hz))", dimension::kTime},
      {"1e999 s", dimension::kTime},
      {"1e308 km", dimension::kLength},
      {"1 m^-2147483648", dimension::kRatio},
      {"1 s^10", dimension::kTime},
      {"1 m)", dimension::kLength},
      {"1 sqrt(sqrt(sqrt(sqrt(sqrt(m)))))", dimension::kLength},
  };
  for (const auto& [text, expected] : wrong) {
    try {
      parse_quantity(text, expected);
      ADD_FAILURE() << text << " was taken";
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string_view(e.what()).find("such as"), std::string_view::npos) << e.what();
    }
  }
}

TEST(Units, TextRoundTrip) {
  for (const double value : {0.0, 0.05 * kDegree, 1.0 / 3, -12.25, 6.02e23}) {
    EXPECT_EQ(parse_quantity(format_quantity(value, "deg/s", dimension::kAngularRate), dimension::kAngularRate), value);
  }
  EXPECT_EQ(format_quantity(0.05 * kDegree, "deg/s", dimension::kAngularRate), "0.05 deg/s");
  // Multiplied by a degree, no number gives these.
  for (const double value : {5 * kDegree / 3600, 4.5e-308}) {
    const std::string text = format_quantity(value, "deg/s", dimension::kAngularRate);
    EXPECT_NEAR(parse_quantity(text, dimension::kAngularRate), value, 2e-16 * value + 1e-323) << text;
  }
}

TEST(Units, PartsStandInParentheses) {
  EXPECT_DOUBLE_EQ(unit_factor("deg/(s*sqrt(Hz))", dimension::kGyroNoise), kDegree);
  EXPECT_DOUBLE_EQ(unit_factor("m/(s^2)", dimension::kAcceleration), 1);
  EXPECT_DOUBLE_EQ(unit_factor("deg s^-1", dimension::kAngularRate), kDegree);
  EXPECT_DOUBLE_EQ(unit_factor("deg.s^-1", dimension::kAngularRate), kDegree);
  EXPECT_THROW(unit_factor("m/(s^2", dimension::kAcceleration), std::invalid_argument);
  EXPECT_THROW(unit_factor("(((((m)))))", dimension::kLength), std::invalid_argument);
}

TEST(Units, AUnitMeasuresItsDimensionAlone) {
  EXPECT_TRUE(measures("deg/s", dimension::kAngularRate));
  EXPECT_FALSE(measures("deg/s", dimension::kAngle));
  EXPECT_FALSE(measures("furlong", dimension::kLength));
  EXPECT_FALSE(measures("", dimension::kRatio)) << "no unit";
  EXPECT_DOUBLE_EQ(unit_factor("G", dimension::kAcceleration), kStandardGravity);
  EXPECT_DOUBLE_EQ(unit_factor("G", dimension::kMagneticField), 1e-4);
}

}  // namespace
}  // namespace piste
