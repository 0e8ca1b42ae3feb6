#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#include "io/column_reader.h"
#include "io/lower_case.h"
#include "math/numbers.h"
#include "math/time.h"

namespace piste::log_formats {
namespace {

using std::chrono::days;
using std::chrono::sys_days;

// Three numbers with one separator between each two.
std::optional<std::array<double, 3>> three_numbers(std::string_view text, std::string_view separators) {
  std::array<double, 3> values{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [end, error] = read_number(text.data(), text.data() + text.size(), values[i]);
    if (error != std::errc{} || !(values[i] >= 0)) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (i == 2) break;
    if (text.empty() || separators.find(text.front()) == std::string_view::npos) return std::nullopt;
    text.remove_prefix(1);
  }
  if (!text.empty()) return std::nullopt;
  return values;
}

// The number of a month by the first three letters of its English name; nothing if it is none.
std::optional<double> month_of(std::string_view text) {
  constexpr std::string_view kMonths = "jan feb mar apr may jun jul aug sep oct nov dec";
  constexpr std::size_t kLetters = 3;
  const std::string name = lower_case(text.substr(0, kLetters));
  const auto place = kMonths.find(name);
  if (name.size() < kLetters || place == std::string_view::npos || name.find(' ') != std::string::npos)
    return std::nullopt;
  const std::size_t month = place / (kLetters + 1) + 1;
  return static_cast<double>(month);
}

// `2020-11-04`, `2020/11/04`, `20201104`, `4.11.2020`, `04/11/2020` or `04-Nov-2020`. With the year at the end the day
// stands before the month, unless the first date of the log cannot be read so.
std::optional<sys_days> date_of(std::string_view text, std::optional<bool>& month_first) {
  constexpr double kLastDay = 31, kLastMonth = 12;
  constexpr std::size_t kCompact = 8;
  std::string slashes(text);
  for (char& c : slashes) c = c == '-' || c == '.' ? '/' : c;  // a minus would be read as a sign
  if (slashes.size() == kCompact && slashes.find('/') == std::string::npos) slashes.insert(6, "/").insert(4, "/");
  const auto first = slashes.find('/'), second = slashes.find('/', first + 1);
  if (second == std::string::npos) return std::nullopt;
  if (const auto month = month_of(std::string_view(slashes).substr(first + 1, second - first - 1)))
    slashes.replace(first + 1, second - first - 1, fmt::format("{}", *month));
  auto date = three_numbers(slashes, "/");
  if (!date) return std::nullopt;
  if ((*date)[0] <= kLastDay) {
    if (!month_first) month_first = (*date)[1] > kLastMonth;
    *date = {(*date)[2], (*date)[*month_first ? 0 : 1], (*date)[*month_first ? 1 : 0]};
  }
  return day_of((*date)[0], (*date)[1], (*date)[2]);
}

// End of the date before a time: at a blank, or at a T that is not part of a month.
std::size_t end_of_date(std::string_view text) {
  const std::size_t blank = text.find_first_of(" _");
  for (std::size_t t = text.find('T'); t < blank; t = text.find('T', t + 1)) {
    if (t > 0 && text[t - 1] >= '0' && text[t - 1] <= '9') return t;
  }
  return blank;
}

// Hours, minutes and seconds of a time of day, such as `09:17:31.437`, `091731.437`, or, as some loggers write it,
// `09:17:31:437` and `09.17.31.437`.
std::optional<std::array<double, 3>> clock_of(std::string_view text) {
  constexpr std::size_t kDigits = 6;
  std::string clock(text);
  if (const auto comma = clock.find(','); comma != std::string::npos) clock[comma] = '.';
  const auto count = [&](char mark) { return std::count(clock.begin(), clock.end(), mark); };
  if (count(':') == 0 && count('.') >= 2) std::replace(clock.begin(), clock.end(), '.', ':');
  if (count(':') == 3) clock[clock.rfind(':')] = '.';
  const bool compact = clock.size() >= kDigits && clock.find_first_not_of("0123456789") >= kDigits;
  if (compact) clock.insert(4, ":").insert(2, ":");
  return three_numbers(clock, ":");
}

// Seconds of `+0100`, `-01:30` or `+01`; infinite if it is neither.
double zone_of(std::string_view text) {
  std::string digits;
  for (const char c : text.substr(1)) {
    if (c >= '0' && c <= '9') digits += c;
  }
  if (digits.size() == 2) digits += "00";
  if (digits.size() != 4) return std::numeric_limits<double>::infinity();
  const double hours = 10 * (digits[0] - '0') + (digits[1] - '0'), minutes = 10 * (digits[2] - '0') + (digits[3] - '0');
  return (text.front() == '-' ? -1 : 1) * (hours * kHour + minutes * 60);
}

}  // namespace

ColumnClock::ColumnClock(const ColumnReader& reader, const ColumnTime& time, TimeOrder order)
    : reader_(reader),
      of_(time.of),
      calendar_(time.unit == "calendar"),
      digits_(time.unit == "hhmmss"),
      increasing_(order),
      weeks_(order) {
  constexpr int kDatenum1970 = 719529, kSheet1970 = 25569;
  if (time.unit == kDatenum) day_zero_ = kDatenum1970;
  if (time.unit == kSheetDays) day_zero_ = kSheet1970;
  if (calendar_ || digits_ || day_zero_) {
    time_.index = reader.place_of(time.name, "time");
  } else {
    time_ = reader.column(time.name, "time", time.unit, dimension::kTime);
  }
  if (!time.rest.empty()) rest_ = reader.column(time.rest, "rest", time.rest_unit, dimension::kTime);
  if (!time.week.empty()) week_ = reader.place_of(time.week, "week");
  if (!time.date.empty()) date_ = reader.place_of(time.date, "date");
}

double ColumnClock::next() {
  const TextReader& text = reader_.text();
  if (calendar_) return weeks_.next(calendar(), text);
  if (day_zero_) return weeks_.next(of_days(), text);
  if (digits_) return increasing_.later(since_midnight(), text);
  switch (of_) {
    case TimeScale::kBoot:
      return increasing_.later(since_power_up(), text);
    case TimeScale::kGpsWeek: {
      if (!week_) return increasing_.next(reader_.value(time_) + rest(), text);
      const double week = text.number(*week_), seconds = reader_.value(time_) + rest();
      if (!(week >= 0 && week < 1e4 && week == std::floor(week) && std::abs(seconds) <= kWeek)) {
        text.fail(fmt::format("week {:g} and {:.3f} s of it are no GPS time", week, seconds));
      }
      return weeks_.next({static_cast<int>(week), seconds}, text);
    }
    case TimeScale::kGps:
    case TimeScale::kUtc:
      return weeks_.next(since_epoch(), text);
  }
  return 0;
}

double ColumnClock::since_power_up() {
  const double time = reader_.value(time_);
  return time + time_.factor * rollover_.offset(time / time_.factor) + rest();
}

// Of `09:17:31.437`, or of a number such as 91731.437, of an unknown day.
double ColumnClock::since_midnight() const {
  if (const auto clock = clock_of(reader_.text().fields()[time_.index])) {
    return (*clock)[0] * kHour + (*clock)[1] * 60 + (*clock)[2];
  }
  constexpr double kHundred = 100;
  const double digits = reader_.text().number(time_.index);
  const double seconds = std::fmod(digits, kHundred), minutes = std::fmod(std::floor(digits / kHundred), kHundred);
  const double hours = std::floor(digits / (kHundred * kHundred));
  if (!(digits >= 0 && hours < 24 && minutes < 60 && seconds < 61)) {
    reader_.text().fail(
        fmt::format("{} is no time of day; right would be such as 091731.437, hours, minutes and seconds",
                    reader_.text().fields()[time_.index]));
  }
  return hours * kHour + minutes * 60 + seconds;
}

// Whole seconds are split off as whole numbers: nanoseconds since 1970 have more digits than a double.
GpsTime ColumnClock::since_epoch() const {
  const auto [whole, left] = reader_.text().parts(time_.index);
  const bool gps = of_ == TimeScale::kGps;
  constexpr double kFirstDay = 315964800, kLast = 1e10;  // 6 January 1980 in Unix time; s
  const double about = static_cast<double>(whole) * time_.factor;
  if (!(about >= (gps ? 0 : kFirstDay) && about < kLast)) {
    reader_.text().fail(
        fmt::format("{:.10g} s are no time since {}; are the unit and `of` of the time right? `of: boot` "
                    "is time since power-up",
                    about, gps ? "6 January 1980" : "1 January 1970, of the time that GPS exists"));
  }
  const double per_second = std::round(1 / time_.factor);
  const bool decimal = per_second >= 1 && std::abs(per_second * time_.factor - 1) < 1e-12;
  const auto per = decimal ? static_cast<std::int64_t>(per_second) : 1;
  const auto seconds = decimal ? whole / per : static_cast<std::int64_t>(about);
  const double fraction = rest() + (decimal ? (static_cast<double>(whole % per) + left) / per_second
                                            : about + left * time_.factor - static_cast<double>(seconds));
  constexpr auto kDaySeconds = static_cast<std::int64_t>(kDay), kWeekSeconds = static_cast<std::int64_t>(kWeek);
  if (gps) return {static_cast<int>(seconds / kWeekSeconds), static_cast<double>(seconds % kWeekSeconds) + fraction};
  return gps_time(sys_days(days(seconds / kDaySeconds)), static_cast<double>(seconds % kDaySeconds) + fraction,
                  TimeSystem::kUtc);
}

GpsTime ColumnClock::of_days() const {
  constexpr std::int64_t kLatest = 100000;  // days since 1970: in the year 2243
  const auto [whole, left] = reader_.text().parts(time_.index);
  const std::int64_t day = whole - *day_zero_;
  if (!(day >= 0 && day < kLatest && left >= 0)) {
    reader_.text().fail(fmt::format("{} is no time in days; datenum counts from the year 0, sheet_days from 1899",
                                    reader_.text().fields()[time_.index]));
  }
  return gps_time(sys_days(days(day)), left * kDay + rest(),
                  of_ == TimeScale::kGps ? TimeSystem::kGps : TimeSystem::kUtc);
}

GpsTime ColumnClock::calendar() {
  const TextReader& text = reader_.text();
  std::string_view clock = text.fields()[time_.index], date = clock.substr(0, end_of_date(clock));
  if (date_) {
    date = text.fields()[*date_];
  } else {
    clock.remove_prefix(std::min(clock.size(), date.size() + 1));
  }
  double zone = 0;  // s ahead of UTC, such as +01:00
  if (const auto sign = clock.find_first_of("+-"); sign != std::string_view::npos) {
    zone = zone_of(clock.substr(sign));
    clock = clock.substr(0, sign);
  }
  for (const std::string_view end : {"Z", "UTC", "GPS", " "}) {
    if (clock.ends_with(end)) clock.remove_suffix(end.size());
  }
  const auto day = date_of(date, month_first_);
  const auto time = clock_of(clock);
  if (!day || !time || !(std::abs(zone) < kDay) || !((*time)[0] < 24 && (*time)[1] < 60 && (*time)[2] < 61)) {
    text.fail(fmt::format("`{}{}{}` is no time; right would be such as 2020-11-04 09:17:31.437, in UTC or GPS time",
                          date_ ? date : "", date_ ? " " : "", text.fields()[time_.index]),
              RowFault::Kind::kText);
  }
  // A leap second is the 61st of a day's last minute, and not the first of the next day.
  const double minutes = (*time)[0] * kHour + (*time)[1] * 60 - zone;
  const int days_over = static_cast<int>(std::floor(minutes / kDay));
  return gps_time(*day + days(days_over), minutes - days_over * kDay + (*time)[2],
                  of_ == TimeScale::kGps ? TimeSystem::kGps : TimeSystem::kUtc);
}

}  // namespace piste::log_formats
