#include "math/gps_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "math/time.h"

namespace piste {
namespace {

using std::chrono::days;
using std::chrono::sys_days;
using std::chrono::year_month_day;
using namespace std::chrono_literals;

constexpr sys_days kGpsEpoch{1980y / 1 / 6};
constexpr int kDaysPerWeek = 7;
constexpr double kJapanOffset = 9 * kHour;

/// GPS − UTC grows by one second at the beginning of each of these days (IERS Bulletin C).
constexpr std::array kLeapDays{
    sys_days{1981y / 7 / 1}, sys_days{1982y / 7 / 1}, sys_days{1983y / 7 / 1}, sys_days{1985y / 7 / 1},
    sys_days{1988y / 1 / 1}, sys_days{1990y / 1 / 1}, sys_days{1991y / 1 / 1}, sys_days{1992y / 7 / 1},
    sys_days{1993y / 7 / 1}, sys_days{1994y / 7 / 1}, sys_days{1996y / 1 / 1}, sys_days{1997y / 7 / 1},
    sys_days{1999y / 1 / 1}, sys_days{2006y / 1 / 1}, sys_days{2009y / 1 / 1}, sys_days{2012y / 7 / 1},
    sys_days{2015y / 7 / 1}, sys_days{2017y / 1 / 1},
};

bool is_whole(double value, double least, double most) {
  return value >= least && value <= most && value == std::floor(value);
}

}  // namespace

std::optional<sys_days> day_of(double year, double month, double day) {
  if (!is_whole(year, 1980, 9999) || !is_whole(month, 1, 12) || !is_whole(day, 1, 31)) return std::nullopt;
  const year_month_day date{std::chrono::year(static_cast<int>(year)), std::chrono::month(static_cast<unsigned>(month)),
                            std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok() || sys_days(date) < kGpsEpoch) return std::nullopt;
  return sys_days(date);
}

GpsTime gps_time(sys_days day, double second, TimeSystem system) {
  if (system == TimeSystem::kJapan) second -= kJapanOffset;
  if (second < 0) {
    second += kDay;
    day -= days(1);
  }
  if (system != TimeSystem::kGps) {
    second += static_cast<double>(
        std::count_if(kLeapDays.begin(), kLeapDays.end(), [&](sys_days leap) { return day >= leap; }));
  }
  const auto since = static_cast<int>((day - kGpsEpoch).count());
  return {since / kDaysPerWeek, (since % kDaysPerWeek) * kDay + second};
}

GpsTime gps_time(const GpsTime& time, TimeSystem system) {
  const double whole = std::floor(time.seconds / kDay);
  const sys_days day = kGpsEpoch + days(time.week * kDaysPerWeek + static_cast<int>(whole));
  return gps_time(day, time.seconds - whole * kDay, system);
}

namespace {

constexpr std::int64_t kMicro = 1'000'000, kDayMicro = 86'400 * kMicro;

std::int64_t microseconds(const GpsTime& time) {
  return std::int64_t{time.week} * kDaysPerWeek * kDayMicro + std::llround(time.seconds * static_cast<double>(kMicro));
}

// GPS − UTC [s] at microseconds since the GPS epoch, and whether the instant is within a leap second.
std::pair<std::int64_t, bool> leap_seconds(std::int64_t since) {
  std::int64_t leap = 0;
  bool within = false;
  for (const sys_days day : kLeapDays) {
    const std::int64_t begins = (day - kGpsEpoch).count() * kDayMicro + leap * kMicro;  // of the leap second
    within = since >= begins && since < begins + kMicro;
    if (since < begins + kMicro) break;
    ++leap;
  }
  return {leap, within};
}

}  // namespace

CalendarTime calendar_time(const GpsTime& time, TimeSystem system) {
  std::int64_t since = microseconds(time);
  bool within = false;
  if (system != TimeSystem::kGps) {
    const auto [leap, leaps] = leap_seconds(since);
    within = leaps;
    since -= (leap + (within ? 1 : 0)) * kMicro;
    if (system == TimeSystem::kJapan) since += static_cast<std::int64_t>(kJapanOffset) * kMicro;
  }
  const auto day = static_cast<int>(since / kDayMicro);
  const std::int64_t of_day = since % kDayMicro, seconds = of_day / kMicro;
  const year_month_day date{kGpsEpoch + days(day)};
  return {.year = static_cast<int>(date.year()),
          .month = static_cast<int>(static_cast<unsigned>(date.month())),
          .day = static_cast<int>(static_cast<unsigned>(date.day())),
          .hour = static_cast<int>(seconds / 3600),
          .minute = static_cast<int>(seconds / 60 % 60),
          .second = static_cast<int>(seconds % 60) + (within ? 1 : 0),
          .microsecond = static_cast<int>(of_day % kMicro)};
}

std::string utc_text(const GpsTime& time) {
  const CalendarTime t = calendar_time(time, TimeSystem::kUtc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z", t.year, t.month, t.day, t.hour, t.minute, t.second,
                     t.microsecond);
}

double unix_time(const GpsTime& time) {
  const std::int64_t since = microseconds(time), seconds = since / kMicro;
  const auto [leap, within] = leap_seconds(since);
  constexpr std::int64_t kGpsInUnix = 315'964'800;
  return static_cast<double>(kGpsInUnix - leap + seconds) +
         static_cast<double>(since % kMicro) / static_cast<double>(kMicro);
}

}  // namespace piste
