#include <algorithm>
#include <cmath>
#include <utility>

#include "piste/inspect/inspection.h"
#include "piste/math/statistics.h"

namespace piste {

// The slope is the median of the slopes between fixes half a log apart (Theil and Sen). A fix can only arrive late, so
// the offset is a low quantile of the residuals. A few wrong times move a quantile less than the minimum.
std::optional<ReceiverClock> fit_clock(const std::vector<double>& logger, const std::vector<double>& gps) {
  constexpr std::size_t kFewest = 10;
  const std::size_t count = std::min(logger.size(), gps.size()), half = count / 2;
  if (count < kFewest) return std::nullopt;
  ReceiverClock clock;
  clock.since = logger.front();
  clock.span = {logger.front(), logger.back()};
  std::vector<double> slopes(half), offsets(count), rests(count);
  const auto offset = [&](std::size_t i) { return logger[i] - gps[i]; };
  for (std::size_t i = 0; i < half; ++i) {
    slopes[i] = (offset(i + half) - offset(i)) / (logger[i + half] - logger[i]);
  }
  clock.drift = median(std::move(slopes));
  for (std::size_t i = 0; i < count; ++i) offsets[i] = offset(i) - clock.drift * (logger[i] - clock.since);
  constexpr std::size_t kEarly = 20;  // the quantile: one in so many
  std::vector<double> sorted = offsets;
  std::sort(sorted.begin(), sorted.end());
  clock.offset = sorted[count / kEarly];
  const double middle = median(offsets);
  constexpr double kSigmaPerMedian = 1.4826;  // of the absolute values of a normal distribution
  for (std::size_t i = 0; i < count; ++i) rests[i] = std::abs(offsets[i] - middle);
  clock.scatter = kSigmaPerMedian * median(std::move(rests));
  return clock;
}

const ReceiverClock* Inspection::imu_clock() const {
  const auto imu = first(LogKind::kImu);
  if (!imu || !logs[*imu].log.columns || logs[*imu].log.columns->time.of != TimeScale::kBoot) return nullptr;
  const std::vector<double>& time = logs[*imu].imu.time;
  for (const InspectedLog& log : logs) {
    const bool shared = log.clock && time.front() < log.clock->span.end && time.back() > log.clock->span.start;
    if (shared) return &*log.clock;
  }
  return nullptr;
}

}  // namespace piste
