// Calendar times of GPS times, to and fro.

#include "math/gps_time.h"

#include <gtest/gtest.h>

namespace piste {
namespace {

using std::chrono::sys_days;
using namespace std::chrono_literals;

TEST(CalendarTime, CountsLeapSeconds) {
  const CalendarTime utc = calendar_time({2200, 302400.5}, TimeSystem::kUtc),
                     gps = calendar_time({2200, 302400.5}, TimeSystem::kGps);
  EXPECT_EQ(std::tuple(utc.year, utc.month, utc.day, utc.hour, utc.minute, utc.second, utc.microsecond),
            std::tuple(2022, 3, 9, 11, 59, 42, 500000));
  EXPECT_EQ(std::tuple(gps.hour, gps.minute, gps.second), std::tuple(12, 0, 0));
  EXPECT_DOUBLE_EQ(unix_time({2200, 302400.5}), 1646827182.5);
}

// 31 December 2016 ended with 23:59:60.
TEST(CalendarTime, HasALeapSecond) {
  const GpsTime midnight = gps_time(sys_days{2017y / 1 / 1}, 0, TimeSystem::kUtc);
  const auto text = [&](double before) {
    const CalendarTime t = calendar_time({midnight.week, midnight.seconds - before}, TimeSystem::kUtc);
    return std::tuple(t.day, t.hour, t.minute, t.second, t.microsecond);
  };
  EXPECT_EQ(text(0), std::tuple(1, 0, 0, 0, 0));
  EXPECT_EQ(text(0.25), std::tuple(31, 23, 59, 60, 750000));
  EXPECT_EQ(text(1), std::tuple(31, 23, 59, 60, 0));
  EXPECT_EQ(text(1.5), std::tuple(31, 23, 59, 59, 500000));
}

TEST(CalendarTime, IsTheInverseOfGpsTime) {
  for (const double seconds : {0.0, 86399.999999, 302400.123456, 604799.5}) {
    for (const int week : {400, 1042, 1900, 2200}) {
      for (const TimeSystem system : {TimeSystem::kGps, TimeSystem::kUtc, TimeSystem::kJapan}) {
        const CalendarTime t = calendar_time({week, seconds}, system);
        const auto day = day_of(t.year, t.month, t.day);
        ASSERT_TRUE(day);
        const GpsTime back = gps_time(*day, t.hour * 3600 + t.minute * 60 + t.second + 1e-6 * t.microsecond, system);
        EXPECT_NEAR((back.week - week) * 604800.0 + back.seconds - seconds, 0, 1e-6);
      }
    }
  }
}

}  // namespace
}  // namespace piste
