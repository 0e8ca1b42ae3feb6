#include "piste/inspect/log_match.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "piste/inspect/imu_health.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "support/datasets.h"
#include "support/log_faults.h"
#include "support/places.h"
#include "support/random.h"
#include "support/simulated_case.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

// The plate of the scenarios sits at 42 deg, half way between two axes; here it sits upright, with the boresight's few
// degrees.
Simulation simulated(const std::string& motion, std::uint64_t seed, std::size_t receiver, double rest_before = 30,
                     double rest_after = 10) {
  Scenario s = read_scenario(kSource / "config/scenarios" / (motion + ".yaml"));
  s.imus.resize(1);
  s.imus[0].clock_offset = 0;
  s.gnss = {s.gnss[receiver]};
  s.attitude.clear();
  s.motion.rest_before = rest_before;
  s.motion.run = 60;
  s.motion.rest_after = rest_after;
  s.q_tr = Quaterniond::Identity();
  return simulate(s, seed);
}

Logs logs_of(const std::string& motion, Simulation simulation) {
  return {motion + " " + simulation.gnss[0].file, std::move(simulation.imus[0].recording),
          std::move(simulation.gnss[0])};
}

Logs shipped(const std::string& receiver) {
  const std::string folder = source_folder() + "/data/ski_run/";
  return {"shipped " + receiver, read_imu({folder + "mt9a_1.csv", LogFormat::kCsv}),
          read_gnss({folder + receiver, LogFormat::kCsv})};
}

Logs drive(const std::string& receiver) {
  const std::string folder = (datasets() / "drive/").string();
  return {"drive " + receiver, read_imu({folder + "imu.txt", LogFormat::kKfGins}),
          read_gnss({folder + receiver, LogFormat::kKfGins})};
}

const std::vector<Logs>& clean_logs() {
  static const std::vector<Logs> logs = [] {
    std::vector<Logs> all;
    for (const char* motion : {"ski", "easy_ski", "giant_slalom", "bicycle"}) {
      for (const std::size_t receiver : {0, 1})
        all.push_back(logs_of(motion, simulated(motion, 3 + receiver, receiver)));
    }
    for (const char* receiver : {"gnss.csv", "gnss_l1.csv"}) all.push_back(shipped(receiver));
    if (!datasets().empty()) {
      for (const char* receiver : {"gnss.txt", "gnss_full.txt"}) all.push_back(drive(receiver));
    }
    return all;
  }();
  return logs;
}

// In the giant slalom the accelerometers clip in every turn: no window of it tells the axes.
bool clips(const Logs& logs) { return logs.name.starts_with("giant"); }

// Those that faults are put into: of each motion one, and of each receiver.
std::vector<Logs> spoilt_logs() {
  std::vector<Logs> some;
  for (const Logs& logs : clean_logs()) {
    for (const char* name : {"ski gnss_l1l2", "easy_ski gnss_l1.", "giant_slalom gnss_l1l2", "bicycle gnss_l1.",
                             "shipped gnss.csv", "drive gnss_full"}) {
      if (logs.name.starts_with(name)) some.push_back(logs);
    }
  }
  return some;
}

std::vector<Suspicion> look_at(const Logs& logs) {
  const GnssHealth health = gnss_health(logs.gnss);
  std::vector<Suspicion> all = suspicions(sampling(logs.imu.time), {}, "imu", 20000, 4);
  for (const auto& more :
       {suspicions(health, {}, "gnss"), suspicions(match(logs.imu, logs.gnss, health), "imu", "gnss")})
    all.insert(all.end(), more.begin(), more.end());
  std::stable_sort(all.begin(), all.end(), [](const Suspicion& a, const Suspicion& b) { return a.fault < b.fault; });
  return all;
}

std::string listed(const std::vector<Suspicion>& all) {
  std::string text;
  for (const Suspicion& s : all)
    text += fmt::format("  {} {}: {} -> {}\n", static_cast<int>(s.fault), s.file, s.what, s.remedy);
  return text;
}

void expect_first(const std::vector<Suspicion>& all, LogFault fault, const std::string& name) {
  EXPECT_TRUE(!all.empty() && all.front().fault == fault) << name << ": not " << static_cast<int>(fault) << '\n'
                                                          << listed(all);
}

// Without velocities nothing shows what they are of; a longitude beyond 90 deg is no latitude, and readers refuse it.
bool applies(const SeededFault& seeded, const Logs& logs) {
  const GeodeticFix& first = logs.gnss.fixes.front();
  if (seeded.fault == LogFault::kLatitudeLongitude && std::abs(first.position.longitude) > 90 * kDegree) return false;
  const bool of_axes = seeded.fault >= LogFault::kNoGravity && seeded.fault <= LogFault::kGyroAxes;
  if (of_axes && clips(logs)) return false;
  const bool of_velocity = seeded.fault >= LogFault::kLatitudeLongitude && seeded.fault <= LogFault::kVelocityUnit;
  return first.velocity || !of_velocity;
}

TEST(LogMatch, NothingIsWrongWithCleanLogs) {
  for (const Logs& logs : clean_logs()) {
    const std::vector<Suspicion> all = look_at(logs);
    EXPECT_TRUE(all.empty() || !is_severe(all.front().fault)) << logs.name << '\n' << listed(all);
  }
}

TEST(LogMatch, NothingIsWrongWithoutRestOrVelocitiesOrAtOneHertz) {
  Logs logs = logs_of("easy_ski without rest", simulated("easy_ski", 102, 0, 0, 0));
  const auto expect_nothing = [](const Logs& clean) {
    const std::vector<Suspicion> all = look_at(clean);
    EXPECT_TRUE(all.empty() || !is_severe(all.front().fault)) << clean.name << '\n' << listed(all);
  };
  expect_nothing(logs);
  Logs slow = logs;
  std::erase_if(slow.gnss.fixes, [&](const GeodeticFix& f) { return std::abs(f.time - std::round(f.time)) > 0.01; });
  expect_nothing(slow);
  for (GeodeticFix& f : logs.gnss.fixes) f.velocity.reset();
  expect_nothing(logs);
  Logs winding = logs_of("giant_slalom", simulated("giant_slalom", 102, 0, 0, 0));
  std::erase_if(winding.gnss.fixes, [&](const GeodeticFix& f) { return std::abs(f.time - std::round(f.time)) > 0.01; });
  expect_nothing(winding);
}

TEST(LogMatch, ClockUnitsAndAxesOfCleanLogs) {
  for (const Logs& logs : clean_logs()) {
    const LogMatch m = match(logs.imu, logs.gnss, gnss_health(logs.gnss));
    ASSERT_TRUE(m.clock) << logs.name;
    fmt::print("{:26} clock {:+.3f} ± {:.3f} s, correlation {:.3f}, turn {:.2f}", logs.name, m.clock->offset,
               m.clock->sigma, m.clock->correlation, m.turn_ratio);
    // The drive's IMU is some 65 ms late against its receiver.
    EXPECT_NEAR(m.clock->offset, logs.name.starts_with("drive") ? 0.065 : 0, 0.03) << logs.name;
    EXPECT_GT(m.clock->correlation, 0.9) << logs.name;
    EXPECT_EQ(m.motion.has_value(), !clips(logs)) << logs.name;
    if (m.motion) {
      fmt::print(
          ", accel {:.3f}, left {:.3f} of {:.2f} m/s, axes {} off by {:.1f} (others {:.1f} deg more), lever arm {:.2f} "
          "{:.2f} {:.2f} m",
          m.motion->accel_factor, m.motion->residual, m.motion->change, m.motion->axes, m.motion->tilt / kDegree,
          m.motion->margin / kDegree, m.motion->lever_arm.x(), m.motion->lever_arm.y(), m.motion->lever_arm.z());
      EXPECT_TRUE(m.motion->as_given()) << logs.name;
      EXPECT_NEAR(m.motion->accel_factor, 1, 0.05) << logs.name;
      EXPECT_EQ(m.motion->axes, "+x +y +z") << logs.name;
      EXPECT_LT(m.motion->tilt / kDegree, logs.name.starts_with("shipped") ? 50 : 10) << logs.name;
    }
    fmt::print("\n");
  }
}

TEST(LogMatch, NamesFaultsOfTheImuFirst) {
  for (const Logs& clean : spoilt_logs()) {
    for (const SeededFault& seeded : imu_faults()) {
      if (!applies(seeded, clean)) continue;
      Logs logs = clean;
      seeded.spoil(logs);
      expect_first(look_at(logs), seeded.fault, clean.name + ", " + seeded.name);
    }
  }
}

TEST(LogMatch, NamesFaultsOfTheReceiverFirst) {
  for (const Logs& clean : spoilt_logs()) {
    for (const SeededFault& seeded : gnss_faults()) {
      if (!applies(seeded, clean)) continue;
      Logs logs = clean;
      seeded.spoil(logs);
      expect_first(look_at(logs), seeded.fault, clean.name + ", " + seeded.name);
    }
  }
}

TEST(LogMatch, ImuInMillisecondsIsNoOtherFault) {
  Logs logs = clean_logs().front();
  for (double& t : logs.imu.time) t *= 1e3;
  const std::vector<Suspicion> all = look_at(logs);
  ASSERT_EQ(all.size(), 1U) << listed(all);
  EXPECT_EQ(all.front().fault, LogFault::kTimeUnit);
}

TEST(LogMatch, SeesThatGravityWasTakenOut) {
  for (const char* motion : {"ski", "bicycle"}) {
    const Simulation simulation = simulated(motion, 5, 0);
    Logs logs = logs_of(motion, simulation);
    for (std::size_t i = 0; i < logs.imu.time.size(); ++i) {
      const TruthState truth = simulation.bodies[0].at(simulation.imus[0].gps_time[i]);
      logs.imu.accel[i] += truth.q_wb.conjugate() * Vector3d(0, 0, kStandardGravity);
    }
    expect_first(look_at(logs), LogFault::kNoGravity, logs.name);
  }
}

// Without velocities it is the gyroscopes that show that a track is mirrored: its turns have the other sign, and where
// latitude and longitude are exchanged, it is stretched as well.
TEST(LogMatch, ExchangedCoordinatesWithoutVelocities) {
  for (const Logs& clean : spoilt_logs()) {
    if (std::abs(clean.gnss.fixes.front().position.longitude) > 90 * kDegree) continue;
    Logs logs = clean;
    for (GeodeticFix& f : logs.gnss.fixes) f.velocity.reset();
    const LogMatch straight = match(logs.imu, logs.gnss, gnss_health(logs.gnss));
    EXPECT_GE(straight.turn_correlation, 0) << logs.name;
    EXPECT_FALSE(straight.interchanged) << logs.name;
    for (GeodeticFix& f : logs.gnss.fixes) std::swap(f.position.latitude, f.position.longitude);
    const LogMatch m = match(logs.imu, logs.gnss, gnss_health(logs.gnss));
    const std::vector<Suspicion> all = look_at(logs);
    fmt::print("{:26} turns {:+.2f}, exchanged {:+.2f}{}; left {:.3f} and {:.3f} m/s\n", logs.name,
               straight.turn_correlation, m.turn_correlation, m.interchanged ? ", found by the motion" : "",
               straight.motion ? straight.motion->residual : 0, m.motion ? m.motion->residual : 0);
    const LogFault fault = clips(logs) ? LogFault::kTrackMirrored : LogFault::kLatitudeLongitude;
    expect_first(all, fault, logs.name);
    ASSERT_FALSE(all.empty());
    EXPECT_TRUE(contains(all.front().what + all.front().remedy, "exchanged")) << listed(all);
    EXPECT_TRUE(contains(all.front().what + all.front().remedy, "latitude and longitude")) << listed(all);
  }
}

// East for north keeps the scale: forces with the other sign would look the same, and both are named.
TEST(LogMatch, EastForNorthInPositions) {
  Logs logs = clean_logs().front();
  const World world(logs.gnss.fixes.front().position);
  for (GeodeticFix& f : logs.gnss.fixes) {
    const Vector3d p = world.from_geodetic(f.position);
    f.position = world.to_geodetic(Vector3d(p.y(), p.x(), p.z()));
    f.velocity.reset();
  }
  const std::vector<Suspicion> all = look_at(logs);
  expect_first(all, LogFault::kTrackMirrored, logs.name);
  EXPECT_TRUE(contains(all.front().remedy, "or its east and north, exchanged?")) << listed(all);
  EXPECT_TRUE(contains(all.front().remedy, "the accelerometers' signs")) << listed(all);
}

// Who writes east before north does so of positions and of velocities.
TEST(LogMatch, ExchangedCoordinatesAndVelocities) {
  for (const Logs& clean : spoilt_logs()) {
    const GeodeticFix& first = clean.gnss.fixes.front();
    if (!first.velocity || std::abs(first.position.longitude) > 90 * kDegree) continue;
    Logs logs = clean;
    for (GeodeticFix& f : logs.gnss.fixes) {
      std::swap(f.position.latitude, f.position.longitude);
      if (f.velocity) std::swap(f.velocity->value.x(), f.velocity->value.y());
    }
    const std::vector<Suspicion> all = look_at(logs);
    expect_first(all, LogFault::kLatitudeLongitude, logs.name);
    EXPECT_TRUE(contains(all.front().remedy, "those of the velocities")) << listed(all);
  }
}

// A sensor in any of the 24 positions is no fault, and its axes are found.
TEST(LogMatch, TurnedAxesAreFound) {
  const Logs& clean = clean_logs().front();
  const GnssHealth health = gnss_health(clean.gnss);
  const std::vector<Vector3d> axes{kX, kY, kZ};
  int positions = 0;
  for (int forward = 0; forward < 6; ++forward) {
    for (int right = 0; right < 6; ++right) {
      const auto axis = [&](int i) { return Vector3d((i < 3 ? 1 : -1) * axes[static_cast<std::size_t>(i % 3)]); };
      const Vector3d f = axis(forward), r = axis(right);
      if (f.dot(r) != 0) continue;
      ++positions;
      const Matrix3d R_bs = rows(f, r, f.cross(r));
      Logs logs = clean;
      turn(logs.imu.gyro, R_bs.transpose());
      turn(logs.imu.accel, R_bs.transpose());
      const LogMatch m = match(logs.imu, logs.gnss, health);
      ASSERT_TRUE(m.motion);
      EXPECT_TRUE(m.motion->as_given());
      EXPECT_TRUE(m.motion->R_bs == R_bs) << m.motion->axes << " for\n" << R_bs;
    }
  }
  EXPECT_EQ(positions, 24);
}

TEST(LogMatch, AxesAreNamedAsInAConfig) {
  Logs logs = clean_logs().front();
  // x right, y back, z down: forward is −y, right is +x.
  turn(logs.imu.gyro, rows(kY, -kX, kZ));
  turn(logs.imu.accel, rows(kY, -kX, kZ));
  const LogMatch m = match(logs.imu, logs.gnss, gnss_health(logs.gnss));
  ASSERT_TRUE(m.motion);
  EXPECT_EQ(m.motion->axes, "-y +x +z");
}

// Logs of different runs have no offset, wherever one looks for it; nor does a log that stands still.
TEST(LogMatch, ClaimsNothingOfStrangers) {
  const std::vector<Logs>& all = clean_logs();
  for (const auto& [one, other] : {std::pair{0U, 6U}, {2U, 0U}, {6U, 2U}}) {
    const LogMatch m = match(all[one].imu, all[other].gnss, gnss_health(all[other].gnss));
    EXPECT_FALSE(m.motion) << all[one].name << " with " << all[other].name << ' ' << m.motion->residual << " of "
                           << m.motion->change;
    EXPECT_FALSE(m.clock) << all[one].name << " with " << all[other].name << ' ' << m.clock->correlation << ' '
                          << m.clock->evidence << ' ' << m.clock->over_rival;
  }
  Logs still = all.front();
  std::erase_if(still.gnss.fixes, [&](const GeodeticFix& f) { return f.time > still.gnss.fixes.front().time + 28; });
  const LogMatch m = match(still.imu, still.gnss, gnss_health(still.gnss));
  EXPECT_FALSE(m.motion);
  EXPECT_FALSE(m.clock);
}

// Too few fixes for a velocity: three of one a second, eight of ten a second.
TEST(LogMatch, ClaimsNothingOfAReceiverWithoutATrack) {
  const Logs clean = shipped("gnss.csv");
  for (const auto& [fixes, interval] : {std::pair{3U, 1.0}, {8U, 0.1}}) {
    GnssRecording few = clean.gnss;
    few.fixes.resize(fixes);
    for (std::size_t i = 0; i < fixes; ++i) {
      few.fixes[i].velocity.reset();
      few.fixes[i].time = few.fixes[0].time + interval * static_cast<double>(i);
    }
    const LogMatch m = match(clean.imu, few, gnss_health(few));
    EXPECT_FALSE(m.clock);
    EXPECT_FALSE(m.motion);
    EXPECT_EQ(m.turn_ratio, 0);
  }
}

// A bicycle that leans in its turns, in a log that begins and ends under way: its correlation alone would not do.
TEST(LogMatch, ClockOfALeaningBicycleIsConfirmedByItsMotion) {
  for (std::uint64_t seed = 103; seed < 106; ++seed) {
    Logs logs = logs_of("bicycle without rest", simulated("bicycle", seed, 0, 0, 0));
    const double under_way = logs.gnss.fixes.front().time + 10, stops = logs.gnss.fixes.back().time - 10;
    std::erase_if(logs.gnss.fixes, [&](const GeodeticFix& f) { return f.time < under_way || f.time > stops; });
    for (double& t : logs.imu.time) t -= 4321;
    const LogMatch m = match(logs.imu, logs.gnss, gnss_health(logs.gnss));
    ASSERT_TRUE(m.clock) << seed;
    EXPECT_FALSE(m.clock->certain) << seed << ' ' << m.clock->correlation << ' ' << m.clock->over_rival;
    EXPECT_TRUE(m.motion) << seed;
    EXPECT_NEAR(m.clock->offset, -4321, 5 * m.clock->sigma) << seed;
  }
}

// A rider who leans exactly as the turn has it: roll = atan(v ψ' / g). The roll rate is then as the derivative of the
// turn rate, and rates about all axes explain turns at any lag: an offset by these is 0.06 s off. On a rough road,
// without velocities.
Logs leaning_ride(double ahead) {
  constexpr double kSpeed = 6, kStep = 0.02, kLength = 150, kGravity = 9.81;
  constexpr double kSigma = 0.1, kShakenForce = 5, kShakenRate = 0.2;  // m, m/s², rad/s
  const World world({0.7, 0.3, 200});
  const auto turn_rate = [](double t) { return 0.25 * std::sin(0.45 * t) + 0.18 * std::sin(1.07 * t + 1); };
  const auto roll = [&](double t) { return std::atan(kSpeed * turn_rate(t) / kGravity); };
  Logs logs{"leaning ride", {}, {}};
  Vector3d p = Vector3d::Zero();
  double heading = 0.4;
  Random random(3);
  const auto euler = [&](double t) { return Vector3d(roll(t), 0, heading); };
  for (int i = 0; i * kStep < kLength; ++i) {
    const double t = i * kStep, roll_rate = (roll(t + kStep) - roll(t - kStep)) / (2 * kStep);
    const Quaterniond q_wb = from_euler(euler(t));
    const Vector3d across(-std::sin(heading), std::cos(heading), 0);
    const Vector3d force = kSpeed * turn_rate(t) * across - Vector3d(0, 0, kGravity);
    logs.imu.time.push_back(t + ahead);
    logs.imu.gyro.emplace_back(q_wb.conjugate() * (euler_axes(euler(t)) * Vector3d(roll_rate, 0, turn_rate(t))) +
                               random.vector(kShakenRate));
    logs.imu.accel.emplace_back(q_wb.conjugate() * force + random.vector(kShakenForce));
    if (i % 10 == 0) {
      logs.gnss.fixes.push_back({t, world.to_geodetic(p + random.vector(kSigma)), Vector3d::Constant(kSigma), {}});
    }
    const double middle = heading + 0.5 * kStep * turn_rate(t);
    p += kSpeed * kStep * Vector3d(std::cos(middle), std::sin(middle), 0);
    heading += kStep * turn_rate(t + 0.5 * kStep);
  }
  return logs;
}

TEST(LogMatch, ClockOfARiderWhoLeansAsTheTurnHasIt) {
  for (const double ahead : {0.0, 0.7, -2.3}) {
    const Logs logs = leaning_ride(ahead);
    const LogMatch m = match(logs.imu, logs.gnss, gnss_health(logs.gnss));
    ASSERT_TRUE(m.clock) << ahead;
    EXPECT_NEAR(m.clock->offset, ahead, 0.03) << ahead << " +- " << m.clock->sigma;
  }
}

// Weaving once a minute and pedalling: what shakes the IMU is more than what turns the track. No single minute tells
// the clock, but a quarter of an hour does.
TEST(LogMatch, ClockOfACalmRideIsToldByItsLength) {
  Scenario s = read_scenario(kSource / "config/scenarios/bicycle.yaml");
  s.imus.resize(1);
  s.gnss.resize(1);
  s.attitude.clear();
  s.motion.rest_before = 30;
  s.motion.run = 900;
  s.motion.cycle = 60;
  const Logs logs = logs_of("calm ride", simulate(s, 5));
  const LogMatch m = match(logs.imu, logs.gnss, gnss_health(logs.gnss));
  ASSERT_TRUE(m.clock);
  EXPECT_LT(m.clock->correlation, 0.85);
  EXPECT_TRUE(m.motion);
  EXPECT_NEAR(m.clock->offset, s.imus[0].clock_offset, 0.05);
}

// Fixes of metres, and hardly a turn: when the body rests tells which of many offsets is right.
TEST(LogMatch, ClockOfAGentleLapIsToldByItsRests) {
  Scenario s = read_scenario(kSource / "config/scenarios/montecarlo/gentle_lap.yaml");
  s.imus.resize(1);
  s.gnss = {s.gnss[1]};
  s.attitude.clear();
  const Logs logs = logs_of("gentle lap", simulate(s, 7));
  const GnssHealth health = gnss_health(logs.gnss);
  EXPECT_FALSE(match(logs.imu, logs.gnss, health).clock);
  const LogMatch m = match(logs.imu, logs.gnss, health, imu_health(logs.imu).rest);
  ASSERT_TRUE(m.clock);
  EXPECT_NEAR(m.clock->offset, s.imus[0].clock_offset, m.clock->by_rest ? 1 : 0.1);
}

// What is left of a clock that a log tells is no offset that a configuration could take.
TEST(LogMatch, OfAToldClockNamesNoOffset) {
  LogMatch m;
  m.imu = m.gnss = {0, 100};
  m.interval = 0.01;
  m.overlap = 100;
  m.clock = ClockMatch{.offset = -0.38, .sigma = 0.01, .correlation = 0.97};
  EXPECT_TRUE(contains(suspicions(m, "imu", "gnss").at(0).remedy, "`clock: {offset: -0.38 s}`"));
  m.clock_told = true;
  const Suspicion told = suspicions(m, "imu", "gnss").at(0);
  EXPECT_EQ(told.fault, LogFault::kClockOffset);
  EXPECT_FALSE(contains(told.remedy, "-0.38")) << told.remedy;
  EXPECT_TRUE(contains(told.remedy, "replay.yaml")) << told.remedy;
}

TEST(LogMatch, KnowsTheSameLogTwice) {
  const Logs logs = shipped("gnss.csv");
  const GnssRecording l1 = shipped("gnss_l1.csv").gnss;
  ImuRecording copy = logs.imu;
  shift(copy.time, 5);
  copy.time.resize(copy.time.size() / 2);
  copy.gyro.resize(copy.time.size());
  copy.accel.resize(copy.time.size());
  const PairMatch same = match(logs.imu, copy);
  EXPECT_TRUE(same.same);
  ASSERT_EQ(suspicions(same, "one", "other").size(), 1U);
  EXPECT_EQ(suspicions(same, "one", "other").front().fault, LogFault::kSameLog);
  EXPECT_TRUE(match(logs.gnss, logs.gnss).same);

  const PairMatch receivers = match(logs.gnss, l1);
  EXPECT_FALSE(receivers.same);
  EXPECT_TRUE(suspicions(receivers, "one", "other").empty());
  EXPECT_LT(receivers.distance, 2);
  EXPECT_FALSE(match(logs.imu, clean_logs()[0].imu).same);
}

}  // namespace
}  // namespace piste::test
