#include "column_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <numeric>
#include <string_view>

#include "column_units.h"
#include "io/counter_rollover.h"
#include "piste/core/error.h"

namespace piste {
namespace {

// The unit of time among the words of a name, and the remaining name if the unit is at the end.
struct TimeStem {
  std::vector<std::string> words;
  std::string unit;
};

struct TimeWord {
  std::string_view word, unit;
};
constexpr std::array kTimeWords =
    std::to_array<TimeWord>({{"ns", "ns"},           {"nsec", "ns"},         {"nsecs", "ns"},       {"nanos", "ns"},
                             {"nanosec", "ns"},      {"nanosecs", "ns"},     {"nanoseconds", "ns"}, {"us", "us"},
                             {"usec", "us"},         {"usecs", "us"},        {"micros", "us"},      {"microsec", "us"},
                             {"microsecs", "us"},    {"microseconds", "us"}, {"ms", "ms"},          {"msec", "ms"},
                             {"msecs", "ms"},        {"millis", "ms"},       {"millisec", "ms"},    {"millisecs", "ms"},
                             {"milliseconds", "ms"}, {"seconds", "s"},       {"secs", "s"},         {"sec", "s"}});

std::string unit_in_name(const SampledColumn& c) {
  const auto* const found =
      std::find_if(kTimeWords.begin(), kTimeWords.end(), [&](const TimeWord& w) { return c.has(w.word); });
  return found == kTimeWords.end() ? std::string() : std::string(found->unit);
}

TimeStem stem_of(const SampledColumn& c) {
  if (measures(c.unit, dimension::kTime)) return {c.words, c.unit};
  const auto* const found = std::find_if(kTimeWords.begin(), kTimeWords.end(), [&](const TimeWord& w) {
    return !c.words.empty() && c.words.back() == w.word;
  });
  if (found == kTimeWords.end()) return {};
  return {{c.words.begin(), c.words.end() - 1}, std::string(found->unit)};
}

// Whether a text is such as `20201104T091731.4`.
bool is_compact_calendar(std::string_view text) {
  constexpr std::size_t kDate = 8, kTime = 6;
  constexpr std::string_view kDigits = "0123456789";
  return text.size() >= kDate + 1 + kTime && text[kDate] == 'T' && text.find_first_not_of(kDigits) == kDate &&
         text.substr(kDate + 1, kTime).find_first_not_of(kDigits) == std::string_view::npos;
}

/// Looks for the time of one table.
class TimeFinder {
 public:
  TimeFinder(const std::string& file, const ColumnTable& table, const std::vector<ColumnMeaning>& meanings,
             const Pace& pace, const std::string& owner)
      : file_(file), table_(table), meanings_(meanings), pace_(pace), owner_(owner) {}

  // Times by name, else by their steps: an absolute one if there is one, and in addition one since power-up.
  std::optional<FoundTime> find() const {
    Found found;
    look(found, true, true);
    look(found, true, false);  // of a coarse clock
    if (!table_.header) look(found, false, true);
    if (!found.absolute && !found.boot && found.falling) {
      const std::string name = table_.name_of(*found.falling);
      const auto& values = table_.columns[*found.falling].values;
      const auto at = std::adjacent_find(values.begin(), values.end(), std::greater<>());
      throw DataError(
          file_ + ":1",
          fmt::format("column `{}` keeps falling back (it falls back at row {}, from {:g} to {:g}), so that "
                      "it is no time by itself; if it is the "
                      "remainder of whole seconds or of longer units in another column, name both: "
                      "`time: {{name: …, unit: s, rest: {{name: {}, unit: …}}}}`",
                      name, at - values.begin() + 2, *at, *(at + 1), name));
    }
    if (!found.absolute && !found.boot) return std::nullopt;
    const Timed& time = found.own ? *found.own : found.absolute ? *found.absolute : *found.boot;
    FoundTime all{time.time, time.column, {}};
    if (time.time.of != TimeScale::kBoot && found.boot) all.boot = found.boot->time;
    return all;
  }

 private:
  // Whether a column's falls forbid that it is a time: many of them, or one from which it does not recover.
  bool keeps_falling(std::size_t column) const {
    const Steps steps = steps_of(table_, table_.columns[column].values);
    return steps.falls_back() || (steps.falls > 0 && steps.lost > 1);
  }

  struct Parts {  // of a second
    std::size_t column = 0;
    std::string unit;
  };
  struct Timed {
    ColumnTime time;
    std::size_t column;
  };
  struct Found {
    std::optional<Timed> absolute, boot, own;
    std::optional<std::size_t> falling;
  };

  // Looks for times, unless there is one already.
  void look(Found& found, bool named, bool steady) const {
    if (found.absolute || found.boot) return;
    for (const std::size_t c : stamps_first()) {
      if (named && !is_named_time(c)) continue;
      const auto time = time_from(c, pace_, steady);
      if (!time && named && keeps_falling(c)) found.falling = c;
      if (!time) continue;
      auto& place = time->of == TimeScale::kBoot ? found.boot : found.absolute;
      if (!place) place = Timed{*time, c};
      if (!found.own && is_own_stamp(c)) found.own = Timed{*time, c};
    }
  }

  // `steady`: only one that differs from row to row.
  std::optional<ColumnTime> time_from(std::size_t column, const Pace& pace, bool steady) const {
    const SampledColumn& c = table_.columns[column];
    if (steady && 2 * changing(table_, c) < 1 && !parts_column(column)) return std::nullopt;
    ColumnTime time;
    time.name = table_.name_of(column);
    const bool gps = c.has_any({"gps", "gpst", "gpstime"});
    const std::string_view text = c.first();
    if (text.find(':') != std::string_view::npos || is_compact_calendar(text)) {
      if (text == c.last()) return std::nullopt;
      time.unit = "calendar";
      const bool says_utc = text.ends_with('Z') || text.ends_with("UTC");
      time.of = gps && !says_utc ? TimeScale::kGps : TimeScale::kUtc;
      if (text.find_first_of("-/T") != std::string_view::npos || std::count(text.begin(), text.end(), '.') > 1) {
        return time;
      }
      if (const auto date = column_of(meanings_, "date")) {
        time.date = table_.name_of(*date);
      } else {
        time.unit = "hhmmss";
        time.of = TimeScale::kBoot;
      }
      return time;
    }
    constexpr std::size_t kWholeDate = 8;  // characters; of six digits the order is not known
    const auto parts = parts_column(column);
    if (c.unit == kTimeOfDay || is_time_of_day(table_, c.values)) {
      time.unit = "hhmmss";
      if (const auto date = column_of(meanings_, "date"); date && table_.columns[*date].first().size() >= kWholeDate) {
        time.unit = "calendar";
        time.of = gps ? TimeScale::kGps : TimeScale::kUtc;
        time.date = table_.name_of(*date);
      }
      return time;
    }
    Steps steps = steps_of(table_, times_in(column, parts));
    if (!(steady ? steps.is_time() : steps.is_coarse_time())) return std::nullopt;
    if (!steady) steps.median = steps.mean;
    std::string unit = unit_in_name(c);
    if (parts) {
      time.rest = table_.name_of(parts->column);
      time.rest_unit = parts->unit;
      unit = "s";
    }
    if (c.has("fine") && c.has("sample")) unit = tick_of(steps);
    if (const std::string_view days = days_of(steps, pace); unit.empty() && !parts && !days.empty()) {
      time.unit = days;
      time.of = gps ? TimeScale::kGps : TimeScale::kUtc;
      return time;
    }
    if (unit.empty()) unit = time_unit(steps, pace);
    time.unit = unit_of(table_, column, dimension::kTime, unit);
    const double first = steps.first * unit_factor(time.unit.empty() ? c.cell.unit : time.unit, dimension::kTime);
    // The name may refer to the receiver. A GPS time after 2030 is taken for Unix time after 2020.
    constexpr double kSince = 9e8, kUntil = 4e9, kWeekLength = 604800, kLatestGps = 1.6e9;
    if (first > kSince && first < kUntil) {
      time.of = gps && first < kLatestGps ? TimeScale::kGps : TimeScale::kUtc;
    } else if ((gps || c.has_any({"tow", "sow", "week"}) || is_milliseconds_of_week(column)) && first < kWeekLength) {
      time.of = TimeScale::kGpsWeek;
      if (const auto week = column_of(meanings_, "week"); week && *week != column) time.week = table_.name_of(*week);
    }
    return time;
  }

  // Whether a time in milliseconds is that of the week: the table has columns of the week and of the time since
  // power-up, as ArduPilot's GPS messages have TimeMS, Week and T.
  bool is_milliseconds_of_week(std::size_t column) const {
    const auto is_other = [&](std::size_t c) {
      return c != column && meanings_[c].key == "time" && table_.columns[c].words.size() == 1;
    };
    bool other = false;
    for (std::size_t c = 0; c < meanings_.size(); ++c) other = other || is_other(c);
    return other && table_.columns[column].unit == "ms" && column_of(meanings_, "week").has_value();
  }

  // The unit of times in days, whose rows come at a possible pace: those of MATLAB are 730 000 and more in our time,
  // those of spreadsheets 36 526 and more. Empty if they are none.
  static std::string_view days_of(const Steps& steps, const Pace& pace) {
    constexpr double kDay = 86400, kEarliest = 29221, kLatest = 73051;  // s; 1980 and 2100 by spreadsheets
    constexpr double kYearZero = 693960;                                // what MATLAB counts more
    const double step = kDay * steps.median;
    if (!(step > pace.fastest && step < pace.slowest && steps.median < pace.fastest)) return {};
    if (steps.first > kEarliest && steps.first < kLatest) return kSheetDays;
    return steps.first > kEarliest + kYearZero && steps.first < kLatest + kYearZero ? kDatenum : std::string_view();
  }

  // Of Xsens' SampleTimeFine, which counts 0.1 ms, or µs where the sensor is a Dot: by the pace.
  static std::string tick_of(const Steps& steps) {
    constexpr double kSlowestTicks = 2000;  // 5 Hz in the one unit, 500 Hz in the other
    return steps.median < kSlowestTicks ? "1e-4 s" : "us";
  }

  // The columns of this time, added up: a time may stand in two columns.
  std::vector<double> times_in(std::size_t column, const std::optional<Parts>& rest) const {
    std::vector<double> times = table_.columns[column].values;
    CounterRollover rollover;
    for (double& time : times) time += rollover.offset(time);
    if (!rest) return times;
    const double factor = unit_factor(rest->unit, dimension::kTime);
    for (std::size_t i = 0; i < times.size(); ++i) times[i] += factor * table_.columns[rest->column].values[i];
    return times;
  }

  // The column of parts of a second that goes with one of whole seconds, such as `stamp.nanosec` with `stamp.sec`: the
  // names differ in the unit alone. Without names it is the next one, of nanoseconds that start again with each second.
  std::optional<Parts> parts_column(std::size_t column) const {
    const SampledColumn& whole = table_.columns[column];
    if (!whole.is_whole()) return std::nullopt;
    const auto within_second = [&](std::size_t c, const std::string& unit) {
      const double second = 1 / unit_factor(unit, dimension::kTime);
      const auto& parts = table_.columns[c].values;
      return std::all_of(parts.begin(), parts.end(), [&](double v) { return v >= 0 && v < second; });
    };
    if (!table_.header) {
      const std::size_t next = column + 1;
      const bool is_it = next < table_.columns.size() && table_.columns[next].is_whole() && within_second(next, "ns") &&
                         steps_of(table_, table_.columns[next].values).falls_back();
      return is_it ? std::optional(Parts{next, "ns"}) : std::nullopt;
    }
    const TimeStem stem = stem_of(whole);
    if (stem.unit != "s") return std::nullopt;
    for (std::size_t c = 0; c < table_.columns.size(); ++c) {
      const TimeStem other = stem_of(table_.columns[c]);
      if (other.words != stem.words || other.unit.empty() || other.unit == "s") continue;
      if (within_second(c, other.unit)) return Parts{c, other.unit};
    }
    return std::nullopt;
  }

  // All columns, those of a message's own stamp first: the other stamp in ROS is the time of arrival. Before them the
  // stamp of the sensor itself, such as `gyroTimestamp_sinceReboot` of `gyroRotationX`.
  std::vector<std::size_t> stamps_first() const {
    std::vector<std::size_t> order(table_.columns.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_partition(order.begin(), order.end(), [&](std::size_t c) { return is_own_stamp(c); });
    const auto others = std::find_if(order.begin(), order.end(), [&](std::size_t c) { return !is_own_stamp(c); });
    std::stable_partition(others, order.end(), [&](std::size_t c) {
      return table_.columns[c].has("header") && table_.columns[c].has_any({"stamp", "timestamp"});
    });
    return order;
  }

  bool is_own_stamp(std::size_t column) const {
    const std::vector<std::string>& words = table_.columns[column].words;
    return !owner_.empty() && words.size() > 1 && words.front() == owner_ && meanings_[column].key == "time";
  }

  bool is_named_time(std::size_t column) const {
    const bool whole_date =
        meanings_[column].key == "date" && table_.columns[column].first().find(':') != std::string_view::npos;
    return meanings_[column].key == "time" || whole_date || parts_column(column).has_value();
  }

  const std::string& file_;
  const ColumnTable& table_;
  const std::vector<ColumnMeaning>& meanings_;
  const Pace& pace_;
  const std::string& owner_;  // the first word of the sensor's columns, or empty
};

}  // namespace

std::optional<FoundTime> find_time(const std::string& file, const ColumnTable& table,
                                   const std::vector<ColumnMeaning>& meanings, const Pace& pace,
                                   const std::string& owner) {
  return TimeFinder(file, table, meanings, pace, owner).find();
}

}  // namespace piste
