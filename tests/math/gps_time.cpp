// Calendar times of GPS times, to and fro.

#include "math/gps_time.h"

#include <gtest/gtest.h>

#include <array>
#include <tuple>

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

// GPS − UTC from each of these months on (IERS Bulletin C).
TEST(CalendarTime, EachLeapSecondIsThatOfTheBulletin) {
  constexpr std::array<std::array<int, 3>, 18> kLeaps{{{1981, 7, 1},
                                                       {1982, 7, 2},
                                                       {1983, 7, 3},
                                                       {1985, 7, 4},
                                                       {1988, 1, 5},
                                                       {1990, 1, 6},
                                                       {1991, 1, 7},
                                                       {1992, 7, 8},
                                                       {1993, 7, 9},
                                                       {1994, 7, 10},
                                                       {1996, 1, 11},
                                                       {1997, 7, 12},
                                                       {1999, 1, 13},
                                                       {2006, 1, 14},
                                                       {2009, 1, 15},
                                                       {2012, 7, 16},
                                                       {2015, 7, 17},
                                                       {2017, 1, 18}}};
  const auto ahead = [](sys_days day) {
    return gps_time(day, 3600, TimeSystem::kUtc).seconds - gps_time(day, 3600, TimeSystem::kGps).seconds;
  };
  for (const auto& [year, month, seconds] : kLeaps) {
    const sys_days day = *day_of(year, month, 1);
    EXPECT_EQ(ahead(day), seconds) << year;
    EXPECT_EQ(ahead(day - std::chrono::days(1)), seconds - 1) << year;
    EXPECT_EQ(unix_time(gps_time(day, 0, TimeSystem::kUtc)),
              86400.0 * static_cast<double>(day.time_since_epoch().count()))
        << year;
  }
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

TEST(CalendarTime, AWeekMayCountInAnotherSystem) {
  // Half a second past noon of a Wednesday, in UTC and in Japan, which is nine hours ahead.
  const GpsTime utc = gps_time({2200, 302400.5}, TimeSystem::kUtc),
                japan = gps_time({2200, 302400.5}, TimeSystem::kJapan);
  EXPECT_EQ(utc.week, 2200);
  EXPECT_EQ(utc.seconds, 302418.5);
  EXPECT_EQ(japan.seconds, 302418.5 - 9 * 3600);
  EXPECT_EQ(gps_time({2200, 302400.5}, TimeSystem::kGps).seconds, 302400.5);
  EXPECT_EQ(utc_text(utc), "2022-03-09T12:00:00.500000Z");
  // The first hour of a week in Japan is of the week before.
  EXPECT_EQ(gps_time({2200, 3600}, TimeSystem::kJapan).week, 2199);
}

TEST(CalendarTime, NoDayIsMadeUp) {
  EXPECT_TRUE(day_of(2022, 3, 9));
  EXPECT_TRUE(day_of(1980, 1, 6));
  for (const auto& [year, month, day] : {std::tuple{1980., 1., 5.},
                                         {1979., 3., 9.},
                                         {10000., 3., 9.},
                                         {2022.5, 3., 9.},
                                         {2022., 0., 9.},
                                         {2022., 13., 9.},
                                         {2022., 3., 0.},
                                         {2022., 3., 32.},
                                         {2022., 3., 9.5},
                                         {2022., 2., 29.}}) {
    EXPECT_FALSE(day_of(year, month, day)) << year << " " << month << " " << day;
  }
}

}  // namespace
}  // namespace piste
