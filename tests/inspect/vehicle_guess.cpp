// What tells a car from those who lean into turns: on recorded and simulated logs.

#include "piste/inspect/vehicle_guess.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "support/datasets.h"
#include "support/places.h"
#include "support/simulated_case.h"

namespace piste::test {
namespace {

VehicleGuess guess(const ImuRecording& imu, const GnssRecording& gnss) {
  const GnssHealth health = gnss_health(gnss);
  VehicleGuess g = guess_vehicle(imu, gnss, health, match(imu, gnss, health));
  fmt::print("{}; axes {:.2f}, unlike {:.2f}\n", g.why(), g.handed, g.unlike);
  return g;
}

// One motion, at 12 m/s through bends both ways: `lean` 1 is in balance as on a bicycle, 0 upright as a car.
VehicleGuess guess_simulated(double lean, double slide_deg) {
  Case c = make_case("bicycle", 20, 1, [&](Scenario& s) {
    s.imus[0].clock_offset = s.imus[0].clock_drift = 0;
    s.q_tr = Quaterniond::Identity();
    MotionOptions& m = s.motion;
    m.run = 240;
    m.rest_after = 20;
    m.speed = 12;
    m.net_turn = 250 * kDegree;
    m.turn = 30 * kDegree;
    m.cycle = 25;
    m.lean = lean;
    m.turning_rate = 0;
    m.balance_rate = Vector3d(0, 0, slide_deg * kDegree);
  });
  return guess(c.simulation.imus[0].recording, c.simulation.gnss[0]);
}

TEST(VehicleGuess, WhoLeansIsNoCar) {
  const VehicleGuess car = guess_simulated(0, 0), half = guess_simulated(0.6, 0), bicycle = guess_simulated(1, 0);
  EXPECT_TRUE(car.is_car());
  EXPECT_NEAR(car.force_across, 1, 0.1);
  EXPECT_NEAR(car.force_along, 1, 0.2);
  EXPECT_FALSE(half.is_car());
  EXPECT_FALSE(bicycle.is_car());
  EXPECT_LT(bicycle.force_across, 0.2);
  EXPECT_GT(bicycle.driving, 120);  // and not for want of motion
}

TEST(VehicleGuess, WhoSlidesIsNoCar) {
  const VehicleGuess slides = guess_simulated(0, 12);
  EXPECT_FALSE(slides.is_car());
  EXPECT_GT(slides.slip, 3 * kDegree);
}

TEST(VehicleGuess, TheSkierIsNoCar) {
  const std::string folder = source_folder() + "/data/ski_run/";
  for (const char* receiver : {"gnss.csv", "gnss_l1.csv"}) {
    const VehicleGuess g =
        guess(read_imu({folder + "mt9a_1.csv", LogFormat::kCsv}), read_gnss({folder + receiver, LogFormat::kCsv}));
    EXPECT_FALSE(g.is_car());
    EXPECT_GT(g.force_along, 0.6);
    EXPECT_LT(g.force_across, 0.4);  // and not for want of motion alone
  }
}

TEST(VehicleGuess, TheDriveIsACarAndFlightsAreNot) {
  PISTE_REQUIRE_DATASETS();
  const std::string drive = (datasets() / "drive/").string();
  EXPECT_TRUE(
      guess(read_imu({drive + "imu.txt", LogFormat::kKfGins}), read_gnss({drive + "gnss.txt", LogFormat::kKfGins}))
          .is_car());
  for (const std::string flight : {"flight_3", "flight_4"}) {
    const std::string folder = (datasets() / "quadrotor" / flight / "").string();
    EXPECT_FALSE(
        guess(read_imu({folder + "imu_1.csv", LogFormat::kCsv}), read_gnss({folder + "gnss.csv", LogFormat::kCsv}))
            .is_car());
  }
}

}  // namespace
}  // namespace piste::test
