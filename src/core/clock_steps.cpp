#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/recording.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

// Median of the intervals in which the clock goes on.
double period_of(const std::vector<double>& time) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (time[i] > time[i - 1]) intervals.push_back(time[i] - time[i - 1]);
  }
  return intervals.empty() ? 0 : median(std::move(intervals));
}

// Whether the clock goes on evenly from row i, which fell back by `fall`, until it has passed the time before the fall:
// a row out of its order would be followed by a leap forward.
bool goes_on(const std::vector<double>& time, std::size_t i, double fall, double period) {
  const double longest = std::max(2 * period, fall / 2);
  for (std::size_t k = i + 1; k < time.size(); ++k) {
    const double interval = time[k] - time[k - 1];
    if (!(interval > 0) || interval > longest) return false;
    if (time[k] > time[i - 1] + period) return true;
  }
  return false;
}

// The row behind a step: near its time, where the clock jumped by this most nearly.
std::size_t row_behind(const ImuRecording& imu, const ClockStep& step, double period, std::size_t from) {
  constexpr double kNear = 2, kLike = 1.5;  // periods
  std::size_t best = 0;
  double least = std::max(kLike * period, std::abs(step.step) / 4);
  for (std::size_t i = std::max<std::size_t>(from, 1); i < imu.time.size(); ++i) {
    if (std::abs(imu.time[i - 1] - step.time) > kNear * period) continue;
    const double off = std::abs(imu.time[i] - imu.time[i - 1] - period - step.step);
    if (off >= least) continue;
    least = off;
    best = i;
  }
  return best;
}

}  // namespace

std::vector<ClockStep> clock_steps(const std::vector<double>& time) {
  constexpr std::size_t kRows = 1000;  // at most one step in so many rows, and one at least
  const double period = period_of(time);
  std::vector<ClockStep> steps;
  double since = time.empty() ? 0 : time.front();
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (time[i] > time[i - 1]) continue;
    const double fall = time[i - 1] - time[i];
    // A fall to the beginning is a logger that started again, or a log that stands twice in the file.
    const bool restarts = !(2 * fall < time[i - 1] - since && 2 * fall < time.back() - time[i]);
    if (restarts || !(fall > period) || !goes_on(time, i, fall, period)) return {};
    steps.push_back({time[i - 1], -fall - period});
    since = time[i];
  }
  return steps.size() <= 1 + time.size() / kRows ? steps : std::vector<ClockStep>();
}

void take_out_steps(ImuRecording& imu, const std::vector<ClockStep>& steps) {
  if (steps.empty() || imu.time.size() < 3) return;
  const double period = period_of(imu.time);
  std::vector<std::size_t> rows;
  for (const ClockStep& step : steps) {
    const std::size_t row = row_behind(imu, step, period, rows.empty() ? 0 : rows.back() + 1);
    if (row == 0) {
      throw DataError(
          imu.file,
          fmt::format("`steps` names a step of {:+.6g} s behind t = {:.6f} s, and the times of the rows, {:.6f} "
                      "to {:.6f} s, have none there; right would be the time of the last row before it",
                      step.step, step.time, imu.time.front(), imu.time.back()));
    }
    rows.push_back(row);
  }
  double sum = 0;
  for (std::size_t i = 0, next = 0; i < imu.time.size(); ++i) {
    if (next < rows.size() && i == rows[next]) sum += steps[next++].step;
    imu.time[i] -= sum;
  }
}

}  // namespace piste
