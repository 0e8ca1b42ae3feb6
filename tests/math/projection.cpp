#include "math/projection.h"

#include <gtest/gtest.h>

#include <GeographicLib/UTMUPS.hpp>
#include <cmath>
#include <string>

#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste::test {
namespace {

std::string refusal(int code) {
  try {
    const Projection projection(code);
    return "none";
  } catch (const NoProjection& e) {
    return e.what();
  }
}

// GeographicLib's series are another way to the same numbers.
TEST(Projection, UtmIsThatOfGeographicLib) {
  if (!has_projections()) GTEST_SKIP() << "built without PROJ";
  const Projection utm(32632);
  for (const auto& [latitude, longitude] : {std::pair{46.1, 7.23}, {0.5, 11.9}, {71.0, 6.1}, {83.9, 9.0}}) {
    int zone = 0;
    bool north = true;
    Eigen::Vector2d expected;
    GeographicLib::UTMUPS::Forward(latitude, longitude, zone, north, expected.x(), expected.y(), 32);
    const Eigen::Vector2d found = utm.easting_northing({latitude * kDegree, longitude * kDegree, 2480});
    EXPECT_LT((found - expected).norm(), 1e-6) << latitude;
  }
}

// Swisstopo's approximation of CH1903+ / LV95, good to about a metre in Switzerland (Formulas and constants for the
// calculation of the Swiss conformal cylindrical projection, 2016, 4.2).
TEST(Projection, SwissIsThatOfSwisstopo) {
  if (!has_projections()) GTEST_SKIP() << "built without PROJ";
  const Projection swiss(2056);
  for (const auto& [latitude, longitude] : {std::pair{46.0973, 7.2286}, {47.2, 8.9}, {46.2, 6.1}}) {
    const double phi = (latitude * 3600 - 169028.66) / 10000, lambda = (longitude * 3600 - 26782.5) / 10000;
    const Eigen::Vector2d expected(2600072.37 + 211455.93 * lambda - 10938.51 * lambda * phi -
                                       0.36 * lambda * square(phi) - 44.54 * std::pow(lambda, 3),
                                   1200147.07 + 308807.95 * phi + 3745.25 * square(lambda) + 76.63 * square(phi) -
                                       194.56 * square(lambda) * phi + 119.79 * std::pow(phi, 3));
    const Eigen::Vector2d found = swiss.easting_northing({latitude * kDegree, longitude * kDegree, 500});
    EXPECT_LT((found - expected).norm(), 1.5) << latitude;
  }
}

TEST(Projection, SaysWhatItCannotDo) {
  if (!has_projections()) {
    EXPECT_NE(refusal(2056).find("libproj-dev"), std::string::npos) << refusal(2056);
    GTEST_SKIP() << "built without PROJ";
  }
  EXPECT_EQ(refusal(2056), "none");
  EXPECT_EQ(refusal(999999), "PROJ knows no EPSG:999999");
  EXPECT_EQ(refusal(4326), "EPSG:4326 (WGS 84) is no projection in metres");
  EXPECT_NE(refusal(2225).find("is no projection in metres"), std::string::npos) << refusal(2225);  // feet
  EXPECT_NE(refusal(5773).find("is no projection in metres"), std::string::npos) << refusal(5773);  // heights
}

TEST(Projection, OutsideIsInfinite) {
  if (!has_projections()) GTEST_SKIP() << "built without PROJ";
  const Projection utm(32632);
  EXPECT_FALSE(std::isfinite(utm.easting_northing({0, 99 * kDegree, 0}).y()));
}

}  // namespace
}  // namespace piste::test
