#include "piste/inspect/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string_view>

#include "core/row_gaps.h"
#include "io/left_out_rows.h"
#include "math/time.h"

namespace piste {
namespace {

constexpr double kFinest = 1e-6;         // s
constexpr double kGpsEpoch = 315964800;  // s after 1970 of the first GPS week
constexpr double kJittery = 0.2;         // of the interval
constexpr double kManyMissing = 0.001;   // share of all rows: with more missing rows, gaps are a fault
constexpr double kLongGap = 0.5;         // s: a longer gap is a fault

// The step of which all times since the first are multiples. 0 if it is smaller than kFinest.
double resolution(std::span<const double> time) {
  long long common = 0;
  for (const double t : time) {
    const double steps = (t - time.front()) / kFinest;
    if (std::abs(steps - std::round(steps)) > 0.1 || steps > 9e15) return 0;
    common = std::gcd(common, std::llround(steps));
    if (common == 1) break;
  }
  return kFinest * static_cast<double>(common);
}

// The reason for an unreadable row, in words for a list.
std::string_view name_of(RowFault::Kind kind) {
  switch (kind) {
    case RowFault::Kind::kText:
      return "with text where a number should stand";
    case RowFault::Kind::kNotFinite:
      return "with NaN or infinity";
    case RowFault::Kind::kFields:
      return "with too few or too many fields";
    case RowFault::Kind::kChecksum:
      return "with a wrong checksum";
    case RowFault::Kind::kTimeRepeated:
      return "that repeat the time of the row before";
    case RowFault::Kind::kTimeBack:
      return "earlier than the row before";
    case RowFault::Kind::kValue:
      return "with a value that cannot be";
  }
  return "";
}

LogFault fault_of(RowFault::Kind kind) {
  if (kind == RowFault::Kind::kTimeRepeated) return LogFault::kTimeRepeated;
  return kind == RowFault::Kind::kTimeBack ? LogFault::kTimeBack : LogFault::kBadRows;
}

// A unit of time with which the rate is between `slowest` and `fastest`, if seconds do not fit.
void suspect_unit(const Sampling& s, const std::string& file, double fastest, double slowest,
                  std::vector<Suspicion>& found) {
  if (s.rows < 3 || (s.rate() >= slowest && s.rate() <= fastest)) return;
  struct Unit {
    std::string_view name;
    double seconds;
  };
  for (const Unit unit : {Unit{"milliseconds", 1e-3}, Unit{"microseconds", 1e-6}, Unit{"nanoseconds", 1e-9},
                          Unit{"minutes", 60}, Unit{"hours", kHour}, Unit{"days", kDay}}) {
    const double rate = s.rate() / unit.seconds;
    if (rate < slowest || rate > fastest) continue;
    found.push_back({LogFault::kTimeUnit, file,
                     fmt::format("rows are {:.6g} s apart, as time_s has it; as {} they come at {:.4g} Hz", s.interval,
                                 unit.name, rate),
                     fmt::format("time_s is in seconds: multiply it by {:g}", unit.seconds)});
    return;
  }
}

}  // namespace

Sampling sampling(std::span<const double> time) {
  Sampling s;
  s.rows = time.size();
  if (time.empty()) return s;
  s.span = {time.front(), time.back()};
  if (time.size() < 2) return s;
  const RowGaps gaps = find_gaps(time);
  s.interval = gaps.period;
  s.resolution = resolution(time);
  double sum = 0;
  for (std::size_t i = 1; i < time.size(); ++i) {
    const double step = time[i] - time[i - 1];
    if (gaps.before(i)) {
      s.gaps.push_back({time[i - 1], time[i]});
      s.missing += static_cast<std::size_t>(std::llround(std::min(step / s.interval, 1e15))) - 1;
    } else {
      sum += (step - s.interval) * (step - s.interval);
    }
  }
  const std::size_t whole = time.size() - 1 - s.gaps.size();
  if (whole > 0) s.jitter = std::sqrt(sum / static_cast<double>(whole));
  return s;
}

std::vector<Suspicion> suspicions(const Sampling& s, const RowFaults& faults, const std::string& file, double fastest,
                                  double slowest) {
  std::vector<Suspicion> found;
  if (s.rows < 3) {
    found.push_back({LogFault::kEmpty, file, fmt::format("{} rows can be read", s.rows),
                     faults.total() > 0 ? fmt::format("{} were refused; the first: {}: {}", faults.total(),
                                                      faults.first.front().place, faults.first.front().what)
                                        : "is this the right file, and was it written to the end?"});
    return found;
  }
  suspect_unit(s, file, fastest, slowest, found);
  const bool seconds = found.empty();
  if (seconds && s.span.start > kGpsEpoch) {
    const double gps = s.span.start - kGpsEpoch;
    found.push_back(
        {LogFault::kNotSecondsOfWeek, file,
         fmt::format("time begins at {:.3f} s: seconds since 1970, it seems, and not of the GPS week", s.span.start),
         fmt::format("subtract {:.0f} s, and add the leap seconds where it is UTC",
                     kGpsEpoch + kWeek * std::floor(gps / kWeek))});
  } else if (seconds && (s.span.start < -kWeek || s.span.start >= kWeek)) {  // below zero: since another instant
    found.push_back(
        {LogFault::kNotSecondsOfWeek, file,
         fmt::format("time begins at {:.3f} s, which is no second of the GPS week (0 to 604800)", s.span.start),
         fmt::format("subtract whole weeks, such as {:.0f} s", kWeek * std::floor(s.span.start / kWeek))});
  }
  // Counted as a replay with `repair` counts them. It does not skip impossible values: one may stand for all.
  const std::size_t unreadable =
      faults.total() - faults.count(RowFault::Kind::kTimeRepeated) - faults.count(RowFault::Kind::kTimeBack);
  const bool few = LeftOutRows::are_few(unreadable, s.rows) && faults.count(RowFault::Kind::kValue) == 0;
  for (std::size_t k = 0; k < RowFault::kKinds; ++k) {
    const auto kind = static_cast<RowFault::Kind>(k);
    if (faults.count(kind) == 0) continue;
    const auto first =
        std::find_if(faults.first.begin(), faults.first.end(), [kind](const RowFault& f) { return f.kind == kind; });
    found.push_back({fault_of(kind), file,
                     fmt::format("{} of {} rows {}; the first at {}: {}", faults.count(kind), s.rows + faults.total(),
                                 name_of(kind), first->place, first->what),
                     fault_of(kind) == LogFault::kBadRows
                         ? few ? "`repair: true` leaves these rows out and counts them; below it is read so"
                               : "mend or leave out these rows; replay refuses them"
                         : "`repair: true` puts rows in order and drops repeated ones; below they are read so"});
  }
  if (!s.gaps.empty()) {
    const auto longest = std::max_element(s.gaps.begin(), s.gaps.end(), [](const Interval& a, const Interval& b) {
      return a.end - a.start < b.end - b.start;
    });
    const double length = longest->end - longest->start;
    if (length > kLongGap || static_cast<double>(s.missing) > kManyMissing * static_cast<double>(s.rows)) {
      found.push_back(
          {LogFault::kGaps, file,
           fmt::format("{} gaps, some {} rows missing; the longest of {:.3f} s at t = {:.3f} s", s.gaps.size(),
                       s.missing, length, longest->start),
           "rows were lost, or there was nothing to log; what moves in a gap is not known, and sigmas grow there"});
    }
  }
  if (s.jitter > kJittery * s.interval) {
    found.push_back({LogFault::kJitter, file,
                     fmt::format("intervals scatter by {:.2g} s (rms) about {:.6g} s", s.jitter, s.interval),
                     "times of arrival, it seems; `replay` lays the rows on the even clock of the samples"});
  }
  return found;
}

}  // namespace piste
