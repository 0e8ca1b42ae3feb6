// How an IMU sits in a vehicle, from drives that are known exactly.

#include "start/vehicle_mounting.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "piste/core/error.h"
#include "piste/start/start.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

constexpr double kStart = 1000, kStep = 0.02;

/// A drive along a straight line in `way` of w, at a speed that changes by the time [s], without any error of sensors.
struct Drive {
  Log log;
  FilterOptions options;
  Start start;

  Drive(const Quaterniond& q_wb, const Vector3d& way, double duration, const std::function<double(double)>& speed) {
    options.sensor.gyro = {1e-4, 1e-4, {}, 0, 0};
    options.sensor.accel = {1e-3, 1e-3, {}, 0, 0};
    options.gnss = {{.name = ""}};
    options.estimate = {Block::kGyroBias, Block::kAccelBias};
    options.vehicle.emplace();
    options.odometer.emplace();
    options.estimate = with_implied_blocks(options, options.estimate);
    log.world = World({0.8, 0.1, 300});
    log.gnss.resize(1);
    const Vector3d earth = log.world.earth_rate();
    const Matrix3d R_bw = q_wb.conjugate().toRotationMatrix();
    Vector3d p = Vector3d::Zero();
    for (int i = 0; i * kStep < duration; ++i) {
      const double t = i * kStep, before = speed(t), after = speed(t + kStep);
      const Vector3d v = 0.5 * (before + after) * way, a = (after - before) / kStep * way;
      if (i % 10 == 0) {
        log.gnss[0].push_back(
            {kStart + t, p, Vector3d::Constant(0.1), FixVelocity{before * way, Vector3d::Constant(0.1)}});
      }
      ImuSample s;
      s.time = kStart + t + kStep;
      s.interval = kStep;
      s.dtheta = kStep * (R_bw * earth);
      s.dvel = kStep * (R_bw * (a - log.world.gravity(p).value + 2 * earth.cross(v)));
      log.imu.push_back(s);
      p += kStep * v;
    }
    start.time = kStart;
    start.x.q_wb = q_wb;
    start.x.v_wb = speed(0) * way;
    start.covariance = Covariance::Zero(9, 9);
    start.covariance.diagonal() << Vector3d::Constant(0.01), Vector3d::Constant(0.01), Vector3d(1e-5, 1e-5, 1e-4);
  }
};

const Quaterniond kMounting = from_euler({0.3, -0.4, 2.5});  // q_vb
const Vector3d kNorthEast(std::sqrt(0.5), std::sqrt(0.5), 0);

Quaterniond attitude_on(double heading) { return from_euler({0, 0, heading}) * kMounting; }

TEST(VehicleMounting, IsTheWayOfTheBody) {
  // A minute at 12 m/s; before it the vehicle is slow, on its way elsewhere.
  Drive d(attitude_on(45 * kDegree), kNorthEast, 80,
          [](double t) { return t < 8 ? 4.0 : std::min(12.0, 4 + (t - 8)); });
  const auto found = find_vehicle_mounting(d.log, d.options, d.start);
  ASSERT_TRUE(found);
  const Vector3d error = so3_log(kMounting * found->q_vb.conjugate());
  EXPECT_LT(error.norm(), 0.3 * kDegree);
  EXPECT_EQ(found->forward, 1);
  EXPECT_LT(found->sigma.y(), 1 * kDegree) << "a degree of slip, over a minute";
  EXPECT_GT(found->sigma.x(), found->sigma.y()) << "roll is that of roads";

  // Far fewer velocities than in the minute that is enough, and as many as are there.
  d.log.imu.resize(d.log.imu.size() / 2);
  const auto sooner = find_vehicle_mounting(d.log, d.options, d.start);
  ASSERT_TRUE(sooner);
  EXPECT_GT(sooner->sigma.y(), found->sigma.y());
}

// It began by going back, and drove on for longer.
TEST(VehicleMounting, ForwardIsTheLongerWay) {
  const auto speed = [](double t) { return std::clamp(-8 + 4 * (t - 12), -8.0, 8.0); };
  for (const double sign : {1.0, -1.0}) {
    const Drive d(attitude_on(45 * kDegree), kNorthEast, 50, [&](double t) { return sign * speed(t); });
    const auto found = find_vehicle_mounting(d.log, d.options, d.start);
    ASSERT_TRUE(found);
    const Quaterniond turned_round = from_euler({0, 0, sign > 0 ? 0 : 180 * kDegree});
    EXPECT_LT(so3_log(turned_round * kMounting * found->q_vb.conjugate()).norm(), 0.3 * kDegree) << sign;
    EXPECT_GT(found->forward, 0.6);
    EXPECT_LT(found->forward, 0.9);
  }
}

TEST(VehicleMounting, IsNotMadeUp) {
  const Drive walk(attitude_on(45 * kDegree), kNorthEast, 20, [](double) { return 4; });
  EXPECT_FALSE(find_vehicle_mounting(walk.log, walk.options, walk.start)) << "too slow";
  const Drive lift(attitude_on(0), -Vector3d::UnitZ(), 20, [](double) { return 8; });
  EXPECT_FALSE(find_vehicle_mounting(lift.log, lift.options, lift.start)) << "straight up";
  Drive vague(attitude_on(45 * kDegree), kNorthEast, 1.5, [](double) { return 8; });
  ASSERT_TRUE(find_vehicle_mounting(vague.log, vague.options, vague.start));
  vague.log.gnss[0].clear();
  for (const double sigma : {0.8, 3.0}) {  // m/s: of three velocities too little to know, or of none
    vague.start.covariance.diagonal().segment<3>(3).setConstant(sigma * sigma);
    EXPECT_FALSE(find_vehicle_mounting(vague.log, vague.options, vague.start)) << sigma;
  }
}

TEST(VehicleMounting, GoesIntoTheOptionsAndTheStart) {
  Drive d(attitude_on(45 * kDegree), kNorthEast, 20, [](double) { return 8; });
  Start start = d.start;
  const FilterOptions found = with_mounting(d.options, d.log, start);
  ASSERT_TRUE(found.vehicle->mounting);
  EXPECT_LT(found.vehicle->mounting->angularDistance(kMounting), 0.3 * kDegree);
  EXPECT_LT(start.x.q_vb.angularDistance(kMounting), 0.3 * kDegree) << "and the start knows it";
  const auto alone = find_vehicle_mounting(d.log, d.options, d.start);
  EXPECT_NEAR(found.vehicle->mounting_sigma.x(), 2 * alone->sigma.x(), 1e-12) << "loose";
  EXPECT_GE(found.vehicle->mounting_sigma.minCoeff(), 1 * kDegree);

  // One that is stated stays, whatever the log says.
  d.options.vehicle->mounting = from_euler({0, 0, 1});
  start = d.start;
  EXPECT_EQ(with_mounting(d.options, d.log, start).vehicle->mounting->coeffs(), d.options.vehicle->mounting->coeffs());
  EXPECT_EQ(start.x.q_vb.coeffs(), d.options.vehicle->mounting->coeffs());

  const FilterOptions on_foot = without_vehicle(d.options);
  EXPECT_FALSE(on_foot.vehicle);
  EXPECT_FALSE(on_foot.odometer);
  EXPECT_EQ(on_foot.estimate, (std::vector<Block>{Block::kGyroBias, Block::kAccelBias}));
  start = d.start;
  EXPECT_FALSE(with_mounting(on_foot, d.log, start).vehicle);
  EXPECT_EQ(start.x.q_vb.coeffs(), d.start.x.q_vb.coeffs());
}

TEST(VehicleMounting, SaysThatTheDrivingIsTooLittle) {
  const Drive d(attitude_on(45 * kDegree), kNorthEast, 10, [](double) { return 4; });
  Start start = d.start;
  EXPECT_TRUE(contains(message_of<DataError>([&] { with_mounting(d.options, d.log, start); }),
                       "the log has too little driving faster than 5 m/s"));
}

// Straight on at one speed a body may look anywhere.
TEST(VehicleMounting, OfAStraightDriveNotEvenTheHeadingIsFound) {
  const Drive d(attitude_on(45 * kDegree), kNorthEast, 20, [](double) { return 8; });
  const FoundStart found = find_start(d.log, d.options, {});
  EXPECT_FALSE(found.aligned);
  EXPECT_TRUE(contains(found.how, "the motion does not determine the heading at the start")) << found.how;
  EXPECT_GT(std::sqrt(found.start.covariance(8, 8)), 60 * kDegree);
}

// The heading is found without the vehicle, and what the vehicle states goes into the start.
TEST(VehicleMounting, IsNotNeededForTheStart) {
  Drive d(attitude_on(45 * kDegree), kNorthEast, 20, [](double) { return 8; });
  d.options.vehicle->mounting = kMounting;
  d.options.vehicle->contact = Vector3d(1, 2, 3);
  const double heading = to_euler(d.start.x.q_wb).z();
  const Start start = find_start(d.log, d.options, {InitialHeading::Source::kValue, heading, 0.02}).start;
  EXPECT_EQ(start.x.vehicle_contact, d.options.vehicle->contact);
  EXPECT_EQ(start.x.q_vb.coeffs(), kMounting.coeffs());
}

}  // namespace
}  // namespace piste::test
