#include "piste/search/inspect.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <set>
#include <sstream>

#include "piste/math/interruption.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

// A log of the shipped run, with each row of numbers changed.
template <class Change>
std::string changed_log(const std::string& name, Change&& change) {
  std::istringstream lines(read_text(kSource / "data/ski_run" / name));
  std::string text, line;
  std::getline(lines, text);
  text += '\n';
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    std::vector<double> row;
    for (std::string field; std::getline(fields, field, ',');) row.push_back(std::stod(field));
    if (!change(row)) continue;
    for (std::size_t i = 0; i < row.size(); ++i) text += fmt::format("{}{:.9f}", i > 0 ? "," : "", row[i]);
    text += '\n';
  }
  return text;
}

bool names(const Inspection& found, LogFault fault) {
  return std::any_of(found.suspicions.begin(), found.suspicions.end(),
                     [fault](const Suspicion& s) { return s.fault == fault; });
}

// The sigma of its velocities is measured, for which the log is read once more.
TEST(Inspect, OneBadRowIsLeftOutOfACoarseReceiver) {
  const TemporaryFolder folder;
  std::string text = changed_log("gnss.csv", [](std::vector<double>& row) {
    std::fill(row.end() - 3, row.end(), 20);
    return true;
  });
  const auto bad = text.find('\n', text.size() / 2) + 1;
  text.replace(bad, text.find(',', bad) - bad, "??");
  const Inspection found = inspect({folder.write("gnss.csv", text)});
  EXPECT_FALSE(names(found, LogFault::kUnreadable));
  EXPECT_EQ(found.logs.at(0).faults.total(), 1u);
  ASSERT_TRUE(found.logs[0].gnss_health);
  EXPECT_TRUE(found.logs[0].log.sigma_velocity);
}

// Columns without units are guessed. Where the motion refutes that, they are read as it says: here velocities in km/h
// along east, north and down, and forces with the other sign.
TEST(Inspect, WhatTheMotionRefutesIsReadAsItSays) {
  const TemporaryFolder folder;
  const auto named = [](const std::string& header, const std::string& log) {
    return header + log.substr(log.find('\n'));
  };
  const std::string gnss = folder.write("gnss.csv", named("tow,lat,lon,height,sdn,sde,sdd,vn,ve,vd,sdvn,sdve,sdvd",
                                                          changed_log("gnss.csv", [](std::vector<double>& row) {
                                                            for (std::size_t i = 7; i < 13; ++i) row[i] *= 3.6;
                                                            std::swap(row[7], row[8]);
                                                            std::swap(row[10], row[11]);
                                                            return true;
                                                          })));
  const std::string imu =
      folder.write("imu.csv", named("tow,gx,gy,gz,ax,ay,az", changed_log("mt9a_1.csv", [](std::vector<double>& row) {
                                      for (std::size_t i = 4; i < 7; ++i) row[i] = -row[i];
                                      return true;
                                    })));
  const Inspection found = inspect({gnss, imu});
  for (const LogFault fault : {LogFault::kVelocityUnit, LogFault::kAccelSign}) {
    EXPECT_TRUE(names(found, fault)) << static_cast<int>(fault);
  }
  ASSERT_TRUE(found.calibration() != nullptr);
  const auto config = ready_config(found, folder.path().string(), "sensor.yaml");
  ASSERT_TRUE(config);
  EXPECT_TRUE(contains(*config, "velocity: {names: [vn, ve, vd], axes: east north down, unit: 'km/h'}")) << *config;
  EXPECT_TRUE(contains(*config, "accel: {names: [ax, ay, az], axes: -x -y -z")) << *config;
}

// The same of increments under names without a unit: there are no rates then whose unit is to be judged.
TEST(Inspect, IncrementsWithoutAUnitAreReadAsSuch) {
  const TemporaryFolder folder;
  const std::string log = changed_log("mt9a_1.csv", [](std::vector<double>& row) {
    for (std::size_t i = 1; i < 7; ++i) row[i] *= 0.01;
    return true;
  });
  const std::string imu = folder.write("imu.csv", "tow,gx,gy,gz,ax,ay,az" + log.substr(log.find('\n')));
  const Inspection found = inspect({(kSource / "data/ski_run/gnss.csv").string(), imu});
  const auto config = ready_config(found, folder.path().string(), "sensor.yaml");
  ASSERT_TRUE(config);
  EXPECT_TRUE(contains(*config, "dtheta: {names: [gx, gy, gz], unit: rad}")) << *config;
  EXPECT_TRUE(contains(*config, "dvel: {names: [ax, ay, az], unit: 'm/s'}")) << *config;
}

// No receiver, and no tilt: gravity alone says so. At ten rows a second, g is as likely.
TEST(Inspect, ForcesOfGravityOverTheIntervalAreIncrements) {
  const auto mapping = [](double interval) {
    const TemporaryFolder folder;
    std::string text = "time,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z\n";
    for (int i = 0; i < 600; ++i) {
      text += fmt::format("{:.3f},{:.7f},{:.7f},{:.7f},{:.7f},{:.7f},{:.7f}\n", interval * i, 1e-3 * interval * (i % 7),
                          2e-3 * interval * (i % 3), 0.3 * interval * std::sin(0.01 * i), interval * std::sin(0.05 * i),
                          0.01 * interval * (i % 5), -9.79 * interval);
    }
    return inspect({folder.write("log.csv", text)}).logs.at(0).log.columns;
  };
  for (const double interval : {0.02, 0.005}) {
    const auto found = mapping(interval);
    ASSERT_TRUE(found && found->find("dtheta") != nullptr && found->find("dvel") != nullptr) << interval;
    EXPECT_EQ(found->find("dtheta")->unit, "rad");
    EXPECT_EQ(found->find("dvel")->unit, "m/s");
  }
  const auto slow = mapping(0.1);
  ASSERT_TRUE(slow && slow->find("accel") != nullptr);
  EXPECT_EQ(slow->find("accel")->unit, "g");
}

// Rows a second apart, of a calendar: a slow log, and no milliseconds.
TEST(Inspect, ACalendarLeavesNoDoubtOfItsSeconds) {
  const TemporaryFolder folder;
  std::string text = "time,wx,wy,wz,ax,ay,az\n";
  for (int i = 0; i < 240; ++i) {
    text += fmt::format("2024-05-11 08:{:02d}:{:02d}+00:00,0.0{},{:.4f},0.01,0.{},0.2,-9.{}\n", 10 + i / 60, i % 60,
                        i % 7, 0.2 * std::sin(0.3 * i), i % 4, 6 + i % 3);
  }
  const Inspection found = inspect({folder.write("log.csv", text)});
  ASSERT_TRUE(found.logs.at(0).is(LogKind::kImu));
  EXPECT_TRUE(names(found, LogFault::kLowRate));
  EXPECT_FALSE(names(found, LogFault::kTimeUnit));
  EXPECT_FALSE(names(found, LogFault::kIncrementsForRates));
}

// The IMU is switched on before the week's end, and the receiver has its first fix after it.
TEST(Inspect, AWeekMayEndBetweenTheStartsOfTwoLogs) {
  constexpr double kWeek = 604800, kLater = kWeek - 302410;  // s: the run begins at 302400
  const TemporaryFolder folder;
  const std::string imu = folder.write("imu.csv", changed_log("mt9a_1.csv",
                                                              [](std::vector<double>&row) {
                                                                row[0] = std::fmod(row[0] + kLater, kWeek);
                                                                return true;
                                                              })),
                    gnss = folder.write("gnss.csv", changed_log("gnss.csv", [](std::vector<double>&row) {
                                          row[0] += kLater - kWeek;
                                          return row[0] >= 0;
                                        }));
  const Inspection found = inspect({gnss, imu});
  const LogMatch* match = found.first_match();
  ASSERT_TRUE(match != nullptr && match->clock);
  EXPECT_GT(match->overlap, 100);
  EXPECT_NEAR(match->clock->offset, 0, 0.1);
  EXPECT_FALSE(names(found, LogFault::kNotSecondsOfWeek));
  const auto config = ready_config(found, folder.path().string(), "sensor.yaml");
  ASSERT_TRUE(config);
  EXPECT_EQ(config->find("offset: 6048"), std::string::npos) << *config;
  ASSERT_TRUE(found.calibration());
  EXPECT_TRUE(found.calibration()->fits());
}

const std::vector<std::string> kShipped{(kSource / "data/ski_run/mt9a_1.csv").string(),
                                        (kSource / "data/ski_run/gnss.csv").string()};

// Through all of the work, in named stages, with shares from which the time left is of the right order.
TEST(Inspect, TellsHowFarItIs) {
  using Clock = std::chrono::steady_clock;
  struct Told {
    std::string stage;
    double part, time;
  };
  std::vector<Told> told;
  const auto start = Clock::now();
  inspect(kShipped, [&](std::string_view stage, double part) {
    told.push_back({std::string(stage), part, std::chrono::duration<double>(Clock::now() - start).count()});
  });
  ASSERT_GT(told.size(), 20u);
  const double all = told.back().time;
  EXPECT_EQ(told.back().part, 1);
  std::set<std::string> stages;
  double still = 0, farthest = 0, leap = 0;
  for (std::size_t i = 0; i < told.size(); ++i) {
    stages.insert(told[i].stage);
    const double before = i > 0 ? told[i - 1].part : 0;
    EXPECT_GE(told[i].part, before);
    leap = std::max(leap, told[i].part - before);
    still = std::max(still, told[i].time - (i > 0 ? told[i - 1].time : 0));
    farthest = std::max(farthest, std::abs(told[i].part - told[i].time / all));
  }
  fmt::print("{:.1f} s, {} stages; off by {:.2f} of the work at most, silent for {:.2f} s, leaps of {:.2f}\n", all,
             stages.size(), farthest, still, leap);
  EXPECT_TRUE(stages.contains("reading") && stages.contains("noise in motion") && stages.contains("whole log"));
  EXPECT_LT(farthest, 0.3);
  EXPECT_LT(leap, 0.3);
  EXPECT_LT(still, 0.25 * all);
}

// Whatever it is at, it ends soon after it is asked to.
TEST(Inspect, EndsWhereItIsInterrupted) {
  using Clock = std::chrono::steady_clock;
  struct Ended {};
  double slowest = 0;
  for (const double after : {0.05, 0.2, 0.5, 1.0, 1.5}) {
    const auto start = Clock::now();
    const auto passed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
    const std::function<void()> check = [&] {
      if (passed() > after) throw Ended();
    };
    const InterruptedBy interrupted(check);
    EXPECT_THROW(inspect(kShipped), Ended) << after;
    slowest = std::max(slowest, passed() - after);
  }
  fmt::print("ends after {:.3f} s at most\n", slowest);
  EXPECT_LT(slowest, 0.5);
}

// A log in memory is inspected as the file of which it is the content.
TEST(Inspect, LogsInMemory) {
  const std::string imu = read_text(kShipped[0]), gnss = read_text(kShipped[1]);
  const Inspection found = inspect({LogSource{"table_1.csv", imu}, LogSource{"table_2.csv", gnss}});
  const auto config = ready_config(found, "elsewhere", "sensor.yaml");
  ASSERT_TRUE(config);
  EXPECT_TRUE(contains(*config, "file: 'table_1.csv'")) << *config;
  ASSERT_TRUE(found.calibration());
  EXPECT_TRUE(found.calibration()->fits());
}

}  // namespace
}  // namespace piste::test
