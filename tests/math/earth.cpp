#include "piste/math/earth.h"

#include <gtest/gtest.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <numbers>

#include "piste/math/units.h"
#include "support/random.h"

namespace piste {
namespace {

using test::Random;

TEST(World, PlacesComeBack) {
  Random random(1);
  for (const double latitude : {-1.5, -0.6, 0.0, 0.81, 1.55}) {
    const World world({latitude, 2.9, 300});
    EXPECT_LT(world.from_geodetic(world.origin()).norm(), 1e-8);
    for (int i = 0; i < 20; ++i) {
      const Vector3d p = random.vector(20000);
      EXPECT_LT((world.from_geodetic(world.to_geodetic(p)) - p).norm(), 1e-8);
    }
  }
}

// From the deepest mine to a satellite, near the poles and far from the origin, as GeographicLib has it.
TEST(World, PlacesAreThoseOfGeographicLib) {
  Random random(3);
  for (const double latitude : {-89.9999, -40.0, 0.0, 0.001, 46.0, 89.0}) {
    const GeographicLib::LocalCartesian local(latitude, 170, 300);
    const World world({latitude * kDegree, 170 * kDegree, 300});
    for (const double size : {10.0, 1e4, 3e5}) {
      for (const double up : {-1e4, 0.0, 1e4, 2e7}) {
        const Vector3d p = random.vector(size) - Vector3d(0, 0, up);
        Geodetic expected;
        local.Reverse(p.y(), p.x(), -p.z(), expected.latitude, expected.longitude, expected.height);
        const auto [place, R_wn] = world.local_level(p);
        EXPECT_NEAR(place.latitude, expected.latitude * kDegree, 2e-15);
        EXPECT_NEAR(place.longitude, expected.longitude * kDegree, 2e-15 / std::cos(place.latitude));
        EXPECT_NEAR(place.height, expected.height, 1e-8);
        EXPECT_EQ(R_wn, world.rotation_wn(p));
      }
    }
  }
}

TEST(World, AxesAreNorthEastDown) {
  const Geodetic origin{0.8, 0.1, 500};
  const World world(origin);
  constexpr double kAngle = 1e-6;
  const Vector3d north = world.from_geodetic({origin.latitude + kAngle, origin.longitude, origin.height});
  const Vector3d east = world.from_geodetic({origin.latitude, origin.longitude + kAngle, origin.height});
  const Vector3d up = world.from_geodetic({origin.latitude, origin.longitude, origin.height + 1});
  EXPECT_LT((north.normalized() - Vector3d::UnitX()).norm(), 1e-5);
  EXPECT_LT((east.normalized() - Vector3d::UnitY()).norm(), 1e-5);
  EXPECT_LT((up + Vector3d::UnitZ()).norm(), 1e-8);
  // Radii of WGS84 at this latitude.
  const double s = std::sin(origin.latitude), e2 = 0.00669437999014, w = 1 - e2 * s * s;
  EXPECT_NEAR(north.norm() / kAngle, 6378137 * (1 - e2) / std::pow(w, 1.5) + 500, 5);
  EXPECT_NEAR(east.norm() / kAngle, (6378137 / std::sqrt(w) + 500) * std::cos(origin.latitude), 5);
}

TEST(World, LocalAxesTurnWithThePlace) {
  const World world({0.8, 0.1, 0});
  EXPECT_LT((world.rotation_wn(Vector3d::Zero()) - Matrix3d::Identity()).norm(), 1e-9);
  Random random(2);
  for (int i = 0; i < 10; ++i) {
    const Vector3d p = random.vector(50000);
    const Geodetic here = world.to_geodetic(p);
    // A metre up, and small steps north and east, of that place.
    constexpr double kAngle = 1e-6;
    const auto moved = [&](double latitude, double longitude, double height) -> Vector3d {
      return world.from_geodetic({here.latitude + latitude, here.longitude + longitude, here.height + height}) -
             world.from_geodetic({here.latitude - latitude, here.longitude - longitude, here.height - height});
    };
    const Matrix3d R = world.rotation_wn(p);
    EXPECT_LT((moved(kAngle, 0, 0).normalized() - R.col(0)).norm(), 1e-7);
    EXPECT_LT((moved(0, kAngle, 0).normalized() - R.col(1)).norm(), 1e-7);
    EXPECT_LT((moved(0, 0, 1).normalized() + R.col(2)).norm(), 1e-7);
  }
}

TEST(World, EarthTurnsAboutItsAxis) {
  for (const double latitude : {-1.2, 0.0, 0.8, std::numbers::pi / 2}) {
    const World world({latitude, 0.1, 0});
    EXPECT_NEAR(world.earth_rate().norm(), 7.292115e-5, 1e-18);
    // Its component along up is that of the latitude, its north one positive.
    EXPECT_NEAR(-world.earth_rate().z(), 7.292115e-5 * std::sin(latitude), 1e-18);
    EXPECT_GE(world.earth_rate().x(), 0);
    EXPECT_EQ(world.earth_rate().y(), 0);
  }
}

TEST(Gravity, AtPoleAndEquator) {
  const auto down = [](double latitude) { return World({latitude, 0.3, 0}).gravity(Vector3d::Zero()).value; };
  EXPECT_NEAR(down(std::numbers::pi / 2).z(), 9.8321849, 1e-6);
  EXPECT_NEAR(down(0).z(), 9.7803253, 1e-6);
  EXPECT_LT(down(0.8).head<2>().norm(), 1e-8);
  // The plumb line leans with height only.
  EXPECT_NEAR(World({0.8, 0.3, 3000}).gravity(Vector3d::Zero()).value.x(), -2.4e-5, 0.3e-5);
}

TEST(Gravity, GradientIsTheDifference) {
  const World world({0.8, 0.1, 1000});
  Random random(3);
  for (int i = 0; i < 10; ++i) {
    const Vector3d p = random.vector(5000);
    const Gravity g = world.gravity(p);
    for (const double distance : {100.0, 300.0}) {
      const Vector3d q = p + distance * random.vector().normalized();
      // What is left is of second order: 3 g / a² d².
      EXPECT_LT((g.at(q) - world.gravity(q).value).norm(), 1e-12 * distance * distance + 1e-12);
    }
    EXPECT_NEAR(g.gradient.trace(), 2 * kEarthRate * kEarthRate, 1e-11);  // Poisson
    EXPECT_LT((g.gradient - g.gradient.transpose()).norm(), 1e-11);
  }
}

}  // namespace
}  // namespace piste
