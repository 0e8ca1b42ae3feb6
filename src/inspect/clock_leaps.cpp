#include "clock_leaps.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "clock_match.h"
#include "log_signals.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

// The rows from `begin` to `end`, both of them included.
ImuRecording part_of(const ImuRecording& imu, double begin, double end) {
  const auto first = std::lower_bound(imu.time.begin(), imu.time.end(), begin) - imu.time.begin();
  const auto last = std::upper_bound(imu.time.begin(), imu.time.end(), end) - imu.time.begin();
  ImuRecording part;
  part.increments = imu.increments;
  part.time.assign(imu.time.begin() + first, imu.time.begin() + last);
  part.gyro.assign(imu.gyro.begin() + first, imu.gyro.begin() + last);
  part.accel.assign(imu.accel.begin() + first, imu.accel.begin() + last);
  return part;
}

// The offset of the IMU's clock in these rows, with the sigma that LogMatch gives it.
std::optional<ClockMatch> offset_in(const ImuRecording& rows, const Track& track, const GnssHealth& health,
                                    const std::optional<Interval>& within) {
  constexpr std::size_t kFewest = 3;
  if (rows.time.size() < kFewest) return std::nullopt;
  std::optional<ClockMatch> found = match_clocks(ImuIntegral(rows), track, within);
  if (found) found->sigma = clock_sigma(found->sigma, health);
  return found;
}

}  // namespace

std::vector<ClockStep> clock_leaps(const ImuRecording& imu, const std::vector<Interval>& gaps,
                                   const GnssRecording& gnss, const GnssHealth& health) {
  // Quantiles of the normal distribution: a gap is taken for a step once in a million times, a step for a gap once in
  // a thousand.
  const double leaps = normal_quantile(1 - 1e-6 / 2), same = normal_quantile(1 - 1e-3 / 2);
  constexpr double kNear = 1;        // s around the two offsets that are compared
  constexpr std::size_t kOften = 8;  // no clock is set so often in a log: that loses rows
  const Track track(gnss, health);
  std::vector<ClockStep> steps;
  if (gaps.empty() || track.empty()) return steps;
  const double interval = ImuIntegral(imu).interval(), least = leaps * std::sqrt(2) * clock_sigma(0, health);
  std::vector<Interval> wide;  // those that the motion can resolve
  std::ranges::copy_if(gaps, std::back_inserter(wide),
                       [&](const Interval& gap) { return gap.end - gap.start - interval > least; });
  if (wide.size() > kOften) return steps;
  double since = imu.time.front();
  for (std::size_t k = 0; k < wide.size(); ++k) {
    const double until = k + 1 < wide.size() ? wide[k + 1].start : imu.time.back();
    const double step = wide[k].end - wide[k].start - interval;
    const auto before = offset_in(part_of(imu, since, wide[k].start), track, health, std::nullopt);
    if (!before) continue;
    const Interval within{before->offset - kNear, before->offset + step + kNear};
    const auto behind = offset_in(part_of(imu, wide[k].end, until), track, health, within);
    if (!behind) continue;
    const double sigma = std::hypot(before->sigma, behind->sigma), change = behind->offset - before->offset;
    if (change <= leaps * sigma || std::abs(change - step) >= same * sigma) continue;
    steps.push_back({wide[k].start, step});
    since = wide[k].end;
  }
  return steps;
}

}  // namespace piste
