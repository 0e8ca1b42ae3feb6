// A car and a bicycle, simulated: the mounting and the odometer's scale are found, and without GNSS the wheels hold the
// position. Where the wheels slide, nothing is worse than without them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>
#include <optional>
#include <tuple>

#include "piste/replay/replay.h"
#include "start/vehicle_mounting.h"
#include "support/random.h"
#include "support/simulated_case.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

// An industrial MEMS-IMU by its data sheet (ADIS16465).
ImuSensor industrial() {
  ImuSensor s;
  s.gyro = {.noise = 0.0025 * kDegree, .bias = 0.2 * kDegree, .drift = {}, .scale = 0.002};
  s.gyro.drift = {DriftProcess::Kind::kGaussMarkov, 0.0006 * kDegree, 300, 0};
  s.accel = {.noise = 2.3e-4, .bias = 0.02, .drift = {}, .scale = 0.002};
  s.accel.drift = {DriftProcess::Kind::kGaussMarkov, 4e-5, 300, 0};
  return s;
}

struct Drive {
  Case simulated;
  Log log;
  Quaterniond q_vb;  // true
  Vector3d contact;
};

// How a vehicle is driven: an S a cycle, on the way round.
struct Way {
  double lean = 0, swing = 30 * kDegree, cycle = 25, speed = 12, round = 250 * kDegree;
  double skid = 0;  // rad/s of its nose
};

// The trunk of the simulation is the vehicle: it looks along its path.
Drive drive(const Way& way, std::uint64_t seed) {
  Drive d{make_case("bicycle", 20, seed,
                    [&](Scenario& s) {
                      s.imus[0].sensor = industrial();
                      s.imus[0].gyro = s.imus[0].accel = {};  // drawn from that alone
                      MotionOptions& m = s.motion;
                      m.run = 240;
                      m.rest_after = 20;
                      m.speed = way.speed;
                      m.net_turn = way.round;
                      m.turn = way.swing;
                      m.cycle = way.cycle;
                      m.lean = way.lean;
                      m.turning_rate = 0;
                      m.sway_rate = Vector3d::Constant(1e-5);
                      m.sway_velocity = Vector3d::Constant(1e-5);
                      m.balance_rate = Vector3d(0, 0, way.skid);
                      m.vibration = Vector3d::Constant(0.3);
                      m.vibration_rate.setZero();
                    }),
          {},
          {},
          {}};
  d.log = d.simulated.log();
  const Truth &plate = d.simulated.simulation.plate, &body = d.simulated.simulation.bodies[0];
  const double t = d.simulated.under_way() + 50;
  const TruthState r = plate.at(t), b = body.at(t);
  d.q_vb = (r.q_wb * d.simulated.scenario.q_tr.conjugate()).conjugate() * b.q_wb;
  d.contact = b.q_wb.conjugate() * (r.p_wb - b.p_wb);
  Random random(seed);
  for (double at = plate.start_time() + 1; at < plate.end_time() - 1; at += 0.1) {
    d.log.speed.push_back({at, 1.013 * plate.at(at).v_wb.norm() + random.gaussian(0.03), 0.03});
  }
  return d;
}

struct Outcomes {
  Replay run;
  double end = 0, way = 0, sigma = 0;  // m: horizontal error at the end of the outage, and the way in it
};

// GNSS is withheld for `length` from 120 s under way. `slip`: of the vehicle, as it is without being stated.
Outcomes replay_without_gnss(const Drive& d, double length, bool vehicle, bool odometer,
                             const GaussMarkov& slip = VehicleOptions().slip,
                             const std::optional<Quaterniond>& mounting = {}) {
  ReplayOptions options{.conditioning = {},
                        .filter = d.simulated.options,
                        .heading = {},
                        .smoother = SmootherKind::kNone,
                        .history = false};
  if (vehicle) {
    options.filter.vehicle.emplace();
    options.filter.vehicle->contact = d.contact;
    options.filter.vehicle->contact_sigma = Vector3d::Constant(0.3);
    options.filter.vehicle->slip = slip;
    options.filter.vehicle->mounting = mounting;
  }
  if (odometer) options.filter.odometer.emplace();
  options.filter.estimate = with_implied_blocks(options.filter, options.filter.estimate);
  Log log = d.log;
  const Interval outage{d.simulated.under_way() + 120, d.simulated.under_way() + 120 + length};
  std::erase_if(log.gnss[0], [&](const GnssFix& fix) { return outage.contains(fix.time); });
  Outcomes out{replay(std::move(log), options)};
  const Truth& body = d.simulated.simulation.bodies[0];
  const Solution& s = out.run.filtered.solution;
  for (std::size_t i = 1; i < s.size() && s.time(i) < outage.end; ++i) {
    const TruthState truth = body.at(s.time(i));
    if (s.time(i) > outage.start) out.way += truth.v_wb.norm() * (s.time(i) - s.time(i - 1));
    // The log has its own world.
    const Vector3d is = s.world().from_geodetic(body.world().to_geodetic(truth.p_wb));
    out.end = (s.estimate(i).p_wb - is).head<2>().norm();
    out.sigma = s.sigmas(i).position.head<2>().norm();
  }
  return out;
}

TEST(SimulatedCar, MountingAndOdometerAreFoundAndHoldThePosition) {
  // This car does not slip, and is known for it.
  const GaussMarkov slip{{0.01, 0, 0}, 3};
  const int runs = seeds(3, 20);
  double half_way = 0, as_any_car = 0, at_the_end = 0, without = 0;
  for (int seed = 1; seed <= runs; ++seed) {
    const Drive d = drive({}, static_cast<std::uint64_t>(seed));
    const Outcomes half = replay_without_gnss(d, 30, true, true, slip),
                   whole = replay_without_gnss(d, 60, true, true, slip),
                   free = replay_without_gnss(d, 60, false, false);
    half_way += half.end / runs;
    at_the_end += whole.end / runs;
    without += free.end / runs;
    as_any_car += replay_without_gnss(d, 30, true, true).end / runs;
    const Solution& s = half.run.filtered.solution;
    const Estimate x = s.estimate(s.size() - 1);
    const Vector3d mounting = so3_log(d.q_vb * x.q_vb.conjugate());
    fmt::print(
        "mounting {:.3f} {:.3f} {:.3f} deg, scale {:.2f} %, 30 s {:.3f} m, 60 s {:.3f} m of {:.0f} m, free {:.1f} m\n",
        mounting.x() / kDegree, mounting.y() / kDegree, mounting.z() / kDegree, 100 * x.odometer_scale, half.end,
        whole.end, whole.way, free.end);
    EXPECT_LT(mounting.tail<2>().cwiseAbs().maxCoeff(), 0.1 * kDegree);
    EXPECT_NEAR(x.odometer_scale, 0.013, 0.001);
    EXPECT_LT(half.end, 0.5);
    EXPECT_LT(whole.end, 0.003 * whole.way);
    // The sigmas hold.
    const Sigmas sigmas = s.sigmas(s.size() - 1);
    for (int k = 1; k < 3; ++k) {
      EXPECT_LT(std::abs(mounting(k)), 4 * sigmas.blocks(full_offset(Block::kVehicleMounting) + k));
    }
    EXPECT_LT(std::abs(x.odometer_scale - 0.013), 4 * sigmas.blocks(full_offset(Block::kOdometerScale)));
  }
  fmt::print("30 s: {:.3f} m on average, {:.3f} m with the slip of any car\n", half_way, as_any_car);
  EXPECT_LT(at_the_end, 0.25 * without);  // of one run the IMU alone may be right by chance
  if (!thorough()) return;
  EXPECT_LT(half_way, 0.15);
  EXPECT_LT(as_any_car, 0.25);
}

// The batch has the wheels too: without GNSS it knows the position as well as the smoother, and they are of one mind.
TEST(SimulatedCar, TheBatchIsInTheCar) {
  const Drive d = drive({}, 1);
  ReplayOptions options{.conditioning = {}, .filter = d.simulated.options, .heading = {}};
  options.batch = batch_solver();
  options.filter.vehicle.emplace();
  options.filter.vehicle->contact = d.contact;
  options.filter.vehicle->contact_sigma = Vector3d::Constant(0.3);
  options.filter.odometer.emplace();
  options.filter.estimate = with_implied_blocks(options.filter, options.filter.estimate);
  Log log = d.log;
  const Interval outage{d.simulated.under_way() + 120, d.simulated.under_way() + 180};
  std::erase_if(log.gnss[0], [&](const GnssFix& fix) { return outage.contains(fix.time); });
  const Replay rts = replay(log, options);
  options.smoother = SmootherKind::kBatch;
  const Replay batch = replay(log, options);
  const Solution &a = *batch.smoothed, &b = *rts.smoothed;
  ASSERT_EQ(a.size(), b.size());
  EXPECT_TRUE(a.batch->converged);
  double apart = 0, ratio = 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!outage.contains(a.time(i))) continue;
    const Vector3d sigma = b.sigmas(i).position, e = a.estimate(i).p_wb - b.estimate(i).p_wb;
    apart = std::max(apart, e.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    const double r = a.sigmas(i).position.norm() / sigma.norm();
    ratio = std::max({ratio, r, 1 / r});
  }
  fmt::print("batch and smoother {:.3f} sigma apart, sigmas by {:.3f}\n", apart, ratio);
  EXPECT_LT(apart, 0.5);
  EXPECT_LT(ratio, 1.05);
}

// A bicycle leans to 40 deg and more: the constraint is true at its contact point all the same.
TEST(SimulatedBicycle, TheConstraintIsTrueAtAnyLean) {
  const Drive d = drive({.lean = 1, .swing = 38 * kDegree, .cycle = 5}, 1);
  double lean = 0;
  for (double t = d.simulated.under_way() + 20; t < d.simulated.under_way() + 200; t += 0.1) {
    const Quaterniond q_wt = d.simulated.simulation.plate.at(t).q_wb * d.simulated.scenario.q_tr.conjugate();
    lean = std::max(lean, std::abs(to_euler(q_wt).x()));
  }
  const Outcomes with = replay_without_gnss(d, 60, true, false), without = replay_without_gnss(d, 60, false, false);
  const Solution& s = with.run.filtered.solution;
  double nis = 0, rows = 0, refused = 0;
  for (const Innovation& i : s.innovations) {
    if (!s.sources[static_cast<std::size_t>(i.source)].starts_with("vehicle")) continue;
    ++rows;
    nis += i.nis;
    refused += was_used(i.outcome) ? 0 : 1;
  }
  fmt::print("lean {:.0f} deg, NIS {:.2f}, refused {:.3f}, 60 s {:.2f} m, free {:.2f} m\n", lean / kDegree, nis / rows,
             refused / rows, with.end, without.end);
  EXPECT_GT(lean, 40 * kDegree);
  EXPECT_LT(nis / rows, 1.2);
  EXPECT_LT(refused / rows, 0.01);
  EXPECT_LT(with.end, without.end + 1);
}

// A car that slides through its turns: its nose swings by several degrees beside its way.
TEST(SimulatedCar, ASlideIsLetGo) {
  for (const std::uint64_t seed : {1, 2}) {
    const Drive d = drive({.skid = 12 * kDegree}, seed);
    const Outcomes with = replay_without_gnss(d, 30, true, false), without = replay_without_gnss(d, 30, false, false);
    const Solution& s = with.run.filtered.solution;
    double rows = 0, refused = 0;
    for (const Innovation& i : s.innovations) {
      if (s.sources[static_cast<std::size_t>(i.source)] != "vehicle.right") continue;
      ++rows;
      refused += was_used(i.outcome) ? 0 : 1;
    }
    fmt::print("slides: refused {:.2f}, 30 s {:.2f} m, free {:.2f} m\n", refused / rows, with.end, without.end);
    EXPECT_GT(refused / rows, 0.5);
    EXPECT_LT(with.end, std::max(2 * without.end, 1.0));
  }
}

// Round and round like one who seeks a place to park, at a walk, and backwards.
TEST(SimulatedCar, IsNoWorseInUTurnsAtAWalkAndBackwards) {
  const Quaterniond around = from_euler({0, 0, std::numbers::pi});
  for (const auto& [name, way, backwards] :
       {std::tuple{"U-turns", Way{.speed = 5, .round = 12 * std::numbers::pi}, false},
        std::tuple{"a walk", Way{.cycle = 12, .speed = 1.5}, false}, std::tuple{"backwards", Way{.speed = 4}, true}}) {
    const Drive d = drive(way, 1);
    const auto mounting = backwards ? std::optional<Quaterniond>(around * d.q_vb) : std::optional<Quaterniond>(d.q_vb);
    const Outcomes with = replay_without_gnss(d, 60, true, false, VehicleOptions().slip, mounting),
                   without = replay_without_gnss(d, 60, false, false);
    fmt::print("{}: 60 s {:.2f} m of {:.0f} m, free {:.2f} m\n", name, with.end, with.way, without.end);
    EXPECT_LT(with.end, without.end) << name;
    EXPECT_LT(with.end, 3.5 * with.sigma) << name;
    EXPECT_LT(with.sigma, without.sigma) << name;
  }
}

// The way of most of the motion is forward, whatever the axes of the IMU.
TEST(SimulatedCar, AnyMountingIsFoundFromTheMotion) {
  const Drive d = drive({}, 4);
  const FoundStart found = find_start(d.log, d.simulated.options, {});
  const auto mounting = find_vehicle_mounting(d.log, d.simulated.options, found.start);
  ASSERT_TRUE(mounting);
  const Vector3d error = so3_log(d.q_vb * mounting->q_vb.conjugate());
  EXPECT_LT(error.norm(), 3 * kDegree);
  EXPECT_LT(std::abs(error.y()), 4 * mounting->sigma.y());
  EXPECT_LT(std::abs(error.z()), 4 * mounting->sigma.z());
  EXPECT_GT(mounting->forward, 0.9);
}

}  // namespace
}  // namespace piste::test
