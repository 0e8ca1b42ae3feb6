// Undulations that others publish.

#include "math/geoid.h"

#include <gtest/gtest.h>

#include "piste/math/units.h"

namespace piste {
namespace {

double undulation(double latitude, double longitude) {
  return geoid_undulation({latitude * kDegree, longitude * kDegree, 0});
}

// The example of GeographicLib's GeoidEval, and values of NGA's calculator of EGM96.
TEST(Geoid, IsEgm96) {
  ASSERT_TRUE(has_geoid());
  constexpr double kGrid = 0.3;  // m: what half a degree leaves out where it is smooth
  EXPECT_NEAR(undulation(16.775833, -3.009444), 28.7068, kGrid);
  EXPECT_NEAR(undulation(0, 0), 17.16, kGrid);
  EXPECT_NEAR(undulation(90, 0), 13.606, kGrid);
  EXPECT_NEAR(undulation(-90, 0), -29.535, kGrid);
  EXPECT_NEAR(undulation(38.6281550, 269.7791550), -31.628, kGrid);
}

TEST(Geoid, GoesOnOverTheDateLineAndThePoles) {
  EXPECT_NEAR(undulation(10, 179.9999), undulation(10, -179.9999), 1e-3);
  EXPECT_NEAR(undulation(10, 359.9999), undulation(10, 0.0001), 1e-3);
  EXPECT_NEAR(undulation(89.9999, 20), undulation(89.9999, 200), 1e-2);
}

}  // namespace
}  // namespace piste
