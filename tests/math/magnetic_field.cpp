// The World Magnetic Model at the places and times of its published test values, as the package of its authors gives
// them (wmm-calculator 1.4.4).

#include "math/magnetic_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "piste/math/units.h"

namespace piste {
namespace {

struct TestValue {
  double year, height_km, latitude, longitude;
  double north, east, down;  // nT
};

constexpr TestValue kPublished[] = {
    {2025.0, 0, 80, 0, 6521.60, 145.89, 54791.51},         {2025.0, 0, 0, 120, 39677.76, -109.61, -10580.17},
    {2025.0, 0, -80, 240, 6117.55, 15751.91, -52022.52},   {2025.0, 100, 80, 0, 6216.02, 92.44, 52598.83},
    {2025.0, 100, 0, 120, 37688.58, -96.23, -10152.07},    {2025.0, 100, -80, 240, 5907.59, 14780.26, -49540.71},
    {2027.5, 0, 80, 0, 6500.83, 294.53, 54869.36},         {2027.5, 0, 0, 120, 39701.62, -167.37, -10381.78},
    {2027.5, 0, -80, 240, 6200.73, 15730.29, -51783.65},   {2027.5, 100, 80, 0, 6196.74, 233.78, 52670.47},
    {2027.5, 100, 0, 120, 37711.54, -148.70, -9969.78},    {2027.5, 100, -80, 240, 5983.98, 14760.14, -49317.67},
    {2026.5, 1.2, 46.3, 7.1, 22181.35, 1257.09, 42480.37},
};

TEST(MagneticField, IsThatOfThePublishedTestValues) {
  for (const TestValue& value : kPublished) {
    const Vector3d field =
        1e3 * magnetic_field({value.latitude * kDegree, value.longitude * kDegree, 1e3 * value.height_km}, value.year);
    EXPECT_LT((field - Vector3d(value.north, value.east, value.down)).norm(), 0.02) << value.latitude;
  }
}

// At the poles north is along the meridian of the longitude that is asked for.
TEST(MagneticField, IsFiniteAtThePoles) {
  const Vector3d pole = magnetic_field({90 * kDegree, 0, 0}, 2026),
                 beside = magnetic_field({89.999 * kDegree, 0, 0}, 2026);
  EXPECT_LT((pole - beside).norm(), 0.01);
}

}  // namespace
}  // namespace piste
