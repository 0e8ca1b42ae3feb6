#include "recordings/allan_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/row_gaps.h"
#include "math/words.h"
#include "piste/core/error.h"
#include "piste/math/earth.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kSlowestChecked = 5;  // Hz: standstill is judged by the rows within a second
constexpr std::size_t kFewestRows = 32;

using Rows = std::pair<std::size_t, std::size_t>;  // [begin, end)

// A triad that the file does not have is zero in all rows; the force then is assumed to be gravity.
bool is_missing(const std::vector<Vector3d>& values) {
  return std::all_of(values.begin(), values.end(), [](const Vector3d& v) { return v.isZero(0); });
}

void check_unit(const ImuHealth& health, const std::string& file) {
  if (!health.force_unit || !health.has_gravity) return;
  throw DataError(file + ":1", fmt::format("the specific force at rest is {:.4g} m/s^2 as the units say, and should be "
                                           "9.8: the values are {:.4g} times that, so another unit is meant",
                                           health.force, health.force_unit->factor));
}

// Stationary times as rows, joined across short disturbances.
std::vector<Rows> rests(const ImuRecording& imu, const ImuHealth& health, const AllanOptions& options,
                        AllanRecording& found) {
  std::vector<Interval> joined;
  for (const Interval& rest : health.rest) {
    if (!joined.empty() && rest.start - joined.back().end <= options.longest_disturbance) {
      if (rest.start - joined.back().end > 2 * health.sampling.interval) ++found.disturbances;
      joined.back().end = rest.end;
    } else {
      joined.push_back(rest);
    }
  }
  // Motion within 1 s of the log's ends is included, but not counted as a disturbance.
  if (!joined.empty()) {
    const double first = joined.front().start - imu.time.front(), last = imu.time.back() - joined.back().end;
    if (first > 0 && first <= 1) joined.front().start = imu.time.front();
    if (last > 0 && last <= 1) joined.back().end = imu.time.back();
  }
  double rested = 0, longest = 0;
  std::vector<Rows> rows;
  for (const Interval& rest : joined) {
    if (rest.end - rest.start < std::min(options.shortest_rest, (imu.time.back() - imu.time.front()) / 2)) continue;
    longest = std::max(longest, rest.end - rest.start);
    rested += rest.end - rest.start;
    const auto at = [&](double t) {
      return static_cast<std::size_t>(std::lower_bound(imu.time.begin(), imu.time.end(), t) - imu.time.begin());
    };
    rows.emplace_back(at(rest.start), std::min(at(rest.end) + 1, imu.time.size()));
  }
  found.moving = std::max(0.0, imu.time.back() - imu.time.front() - rested);
  if (longest < options.shortest_rest) {
    const double span = imu.time.back() - imu.time.front();
    if (span < options.shortest_rest) {
      throw DataError(imu.file, fmt::format("the log lasts {}; noise is found from at least {} at rest (`--at-rest` "
                                            "takes all rows as they are)",
                                            time_text(span), time_text(options.shortest_rest)));
    }
    double most = 0;
    for (const Interval& rest : joined) most = std::max(most, rest.end - rest.start);
    throw DataError(imu.file, fmt::format("the IMU rests for {} at most, of {}; noise is found from at least {} at "
                                          "rest (`--at-rest` takes all rows as they are)",
                                          time_text(most), time_text(span), time_text(options.shortest_rest)));
  }
  return rows;
}

// The value of a row: a rate or a specific force.
double value_of(const ImuRecording& imu, std::size_t row, std::size_t axis) {
  const double value =
      axis < 3 ? imu.gyro[row](static_cast<Eigen::Index>(axis)) : imu.accel[row](static_cast<Eigen::Index>(axis - 3));
  if (!imu.increments) return value;
  const std::size_t later = std::max<std::size_t>(row, 1);
  return value / (imu.time[later] - imu.time[later - 1]);
}

// One axis over stationary rows: its values in stretches without a gap, with short holes bridged.
std::vector<std::vector<double>> stretches(const ImuRecording& imu, const std::vector<Rows>& rests, const RowGaps& gaps,
                                           std::size_t axis, const AllanOptions& options) {
  constexpr std::size_t kEdge = 10;  // rows on each side of a hole; the line joins their means
  std::vector<std::vector<double>> all;
  for (const auto& [first, last] : rests) {
    std::vector<double> values;
    const auto end_stretch = [&] {
      if (values.size() >= kFewestRows) all.push_back(std::move(values));
      values.clear();
    };
    for (std::size_t i = first; i < last; ++i) {
      if (i > first && gaps.before(i)) {
        const auto missing = static_cast<std::size_t>(std::llround((imu.time[i] - imu.time[i - 1]) / gaps.period)) - 1;
        if (missing > options.longest_hole || values.size() < kEdge || last - i < kEdge) {
          end_stretch();
        } else {
          double before = 0, after = 0;
          for (std::size_t k = 0; k < kEdge; ++k) {
            before += values[values.size() - 1 - k] / kEdge;
            after += value_of(imu, i + k, axis) / kEdge;
          }
          for (std::size_t k = 1; k <= missing; ++k)
            values.push_back(before + (after - before) * static_cast<double>(k) / static_cast<double>(missing + 1));
        }
      }
      values.push_back(value_of(imu, i, axis));
    }
    end_stretch();
  }
  return all;
}

// Counts gaps, and gives the stretches as times.
void describe(const ImuRecording& imu, const std::vector<Rows>& rests, const RowGaps& gaps, const AllanOptions& options,
              AllanRecording& found) {
  for (const auto& [first, last] : rests) {
    std::size_t begin = first;
    for (std::size_t i = first + 1; i < last; ++i) {
      if (!gaps.before(i)) continue;
      const auto missing = static_cast<std::size_t>(std::llround((imu.time[i] - imu.time[i - 1]) / gaps.period)) - 1;
      ++found.gaps;
      found.missing += missing;
      if (missing <= options.longest_hole) {
        found.filled += missing;
        continue;
      }
      if (i - begin >= kFewestRows) found.stretches.push_back({imu.time[begin], imu.time[i - 1]});
      begin = i;
    }
    if (last - begin >= kFewestRows) found.stretches.push_back({imu.time[begin], imu.time[last - 1]});
  }
}

}  // namespace

double AllanRecording::used() const {
  double sum = 0;
  for (const Interval& s : stretches) sum += s.end - s.start;
  return sum;
}

ReadRecording read_at_rest(const AllanSource& source, const AllanOptions& options) {
  RowFaults faults;
  ReadRecording read;
  AllanRecording& found = read.found;
  found.source = source;
  ImuRecording imu = read_imu(source.log, &faults);
  if (imu.increments && imu.time.size() > 1) {  // the first row has no interval
    imu.time.erase(imu.time.begin());
    imu.gyro.erase(imu.gyro.begin());
    imu.accel.erase(imu.accel.begin());
  }
  found.rows = imu.time.size();
  found.refused = faults.total();
  if (!faults.first.empty())
    found.first_refused = fmt::format("{}: {}", faults.first.front().place, faults.first.front().what);
  if (found.rows < kFewestRows) {
    throw DataError(
        source.log.file + ":1",
        fmt::format("has {} rows of an IMU that can be read; {} at least are needed{}", found.rows, kFewestRows,
                    found.first_refused.empty() ? "" : ". The first that cannot: " + found.first_refused));
  }
  const bool no_gyro = is_missing(imu.gyro), no_accel = is_missing(imu.accel);
  if (no_gyro && no_accel) throw DataError(source.log.file + ":1", "all values of the IMU are zero");
  if (no_accel) std::fill(imu.accel.begin(), imu.accel.end(), Vector3d(0, 0, -kStandardGravity));
  read.health = imu_health(imu);
  if (no_accel) std::fill(imu.accel.begin(), imu.accel.end(), Vector3d::Zero());
  if (!no_accel) check_unit(read.health, source.log.file);
  if (read.health.fast_rates && !options.at_rest)
    throw DataError(source.log.file + ":1", "the angular rates are faster than those of any body: are they degrees?");

  const RowGaps gaps = find_gaps(imu.time);
  found.interval = gaps.period;
  found.jitter = std::max(read.health.sampling.jitter, imu.stamp_jitter);
  found.span = imu.time.back() - imu.time.front();
  if (!imu.temperature.empty()) {
    const auto [low, high] = std::minmax_element(imu.temperature.begin(), imu.temperature.end());
    found.temperature = {*low, *high};
  }
  found.rest_checked = !options.at_rest && gaps.period * kSlowestChecked <= 1;
  const std::vector<Rows> rows =
      found.rest_checked ? rests(imu, read.health, options, found) : std::vector<Rows>{{0, imu.time.size()}};
  describe(imu, rows, gaps, options, found);
  for (std::size_t axis = 0; axis < 6; ++axis) {
    AllanSums sums(true);
    std::vector<std::vector<double>> values = stretches(imu, rows, gaps, axis, options);
    for (std::vector<double>& stretch : values) {
      if (found.step[axis] == 0 && !imu.increments) found.step[axis] = value_step(stretch);
      found.outliers[axis] += options.robust ? replace_outlying(stretch) : outlying(stretch).size();
      sums.add(stretch);
      sums.end_stretch();
    }
    found.curves[axis] = sums.curve(gaps.period);
  }
  return read;
}

}  // namespace piste
