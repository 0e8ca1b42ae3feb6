#include "attitude_motion.h"

#include <algorithm>

#include "core/row_gaps.h"
#include "core/time_search.h"

namespace piste {

std::vector<ImuSample> turns_of(const AttitudeRecording& attitude) {
  constexpr double kClosest = 0.095;  // s: 0.1 s, with a tolerance for late stamps
  std::vector<double> time;
  time.reserve(attitude.fixes.size());
  for (const EulerFix& fix : attitude.fixes) time.push_back(fix.time);
  const RowGaps gaps = find_gaps(time);
  std::vector<ImuSample> turns;
  std::size_t last = 0;
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (gaps.before(i)) {
      last = i;
      continue;
    }
    if (time[i] - time[last] < kClosest) continue;
    const Quaterniond before = from_euler(attitude.fixes[last].angles), now = from_euler(attitude.fixes[i].angles);
    turns.push_back({.time = time[i], .interval = time[i] - time[last], .dtheta = so3_log(before.conjugate() * now)});
    last = i;
  }
  return turns;
}

GyroTurns::GyroTurns(const ImuRecording& imu) : integral_(imu) {
  samples_.reserve(imu.time.size());
  attitude_.reserve(imu.time.size());
  Quaterniond q = Quaterniond::Identity();
  for (std::size_t i = 0; i < imu.time.size(); ++i) {
    const double step = i > 0 ? imu.time[i] - imu.time[i - 1] : integral_.interval();
    const Vector3d turn = imu.increments ? imu.gyro[i] : Vector3d(step * imu.gyro[i]);
    samples_.push_back({.time = imu.time[i], .interval = step, .dtheta = turn});
    q = (q * so3_exp(turn)).normalized();
    attitude_.push_back(q);
  }
}

Quaterniond GyroTurns::at(double time) const {
  const auto sample = first_at_or_after(samples_, time);
  const auto i = static_cast<std::size_t>(sample - samples_.begin());
  if (i == samples_.size()) return attitude_.back();
  const double left = (sample->time - time) / sample->interval;
  return attitude_[i] * so3_exp(-left * sample->dtheta);
}

}  // namespace piste
