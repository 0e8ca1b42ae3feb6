#include "piste/experiment/inspect.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

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

}  // namespace
}  // namespace piste::test
