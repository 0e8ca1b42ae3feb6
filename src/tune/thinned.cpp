#include "tune/thinned.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/time_search.h"
#include "piste/math/so3.h"
#include "piste/math/statistics.h"
#include "piste/model/strapdown.h"

namespace piste {
namespace {

constexpr double kLongestGroup = 0.1;  // s of a group: a person's or a vehicle's motion is slower than 5 Hz

using Samples = std::vector<ImuSample>;

// Whether a sample may be one of a group.
bool is_plain(const ImuSample& s) { return !s.gap && !s.interpolated && s.clipped_gyro == 0 && s.clipped_accel == 0; }

bool may_join(const ImuSample& a, const ImuSample& b) {
  return is_plain(a) && is_plain(b) && a.at_rest == b.at_rest &&
         std::abs(b.time - b.interval - a.time) < 0.01 * b.interval;
}

// One past the last sample of the group that begins at `first`.
std::size_t end_of_group(const Samples& samples, std::size_t first, std::size_t size) {
  std::size_t end = first + 1;
  while (end < samples.size() && end - first < size && may_join(samples[end - 1], samples[end])) ++end;
  return end;
}

ImuSample sum(const Samples& samples, std::size_t first, std::size_t end) {
  ImuSample all = samples[first];
  for (std::size_t k = first + 1; k < end; ++k) {
    all.time = samples[k].time;
    all.interval += samples[k].interval;
    all.dtheta += samples[k].dtheta;
    all.dvel += samples[k].dvel;
  }
  return all;
}

// Rotation and velocity over some time, in the body axes at its beginning.
struct Motion {
  Vector3d turn, velocity;
};

Motion over(const ImuStep& step) { return {coned_rotation(step), sculled_velocity(step)}; }

ImuStep step_at(const Samples& samples, std::size_t k) {
  return make_step(k > 0 ? &samples[k - 1] : nullptr, samples[k], k + 1 < samples.size() ? &samples[k + 1] : nullptr);
}

Motion over(const Samples& samples, std::size_t first, std::size_t end) {
  Quaterniond turned = Quaterniond::Identity();
  Vector3d velocity = Vector3d::Zero();
  for (std::size_t k = first; k < end; ++k) {
    const Motion of_step = over(step_at(samples, k));
    velocity += turned * of_step.velocity;
    turned = turned * so3_exp(of_step.turn);
  }
  return {so3_log(turned), velocity};
}

// Mean square of the second differences of the mean rates of groups of that size, under way; infinite without any.
double roughness(const Samples& samples, std::size_t size) {
  double squares = 0, count = 0;
  Vector3d before_last = Vector3d::Zero(), last = Vector3d::Zero();
  int adjoining = 0;
  for (std::size_t first = 0; first < samples.size();) {
    const std::size_t end = end_of_group(samples, first, size);
    if (end - first < size || samples[first].at_rest) {
      adjoining = 0;
    } else {
      const ImuSample group = sum(samples, first, end);
      const Vector3d rate = group.dtheta / group.interval;
      if (++adjoining > 2) {
        squares += (rate - 2 * last + before_last).squaredNorm();
        ++count;
      }
      before_last = last;
      last = rate;
    }
    first = end;
  }
  return count > 0 ? squares / count : std::numeric_limits<double>::infinity();
}

double median_interval(const Samples& samples) {
  std::vector<double> intervals;
  intervals.reserve(samples.size());
  for (const ImuSample& s : samples) intervals.push_back(s.interval);
  return median(std::move(intervals));
}

std::size_t best_size(const Samples& samples) {
  const auto most = static_cast<std::size_t>(std::lround(kLongestGroup / median_interval(samples)));
  std::size_t best = 1;
  double least = roughness(samples, 1);
  for (std::size_t size = 2; size <= most; ++size) {
    const double rough = roughness(samples, size);
    if (!(rough < least)) continue;  // a vibration makes it rise and fall
    least = rough;
    best = size;
  }
  return best;
}

}  // namespace

Log thinned(const Log& log) {
  Log thin = log;
  if (log.imu.size() < 2) return thin;
  const std::size_t size = best_size(log.imu);
  if (size == 1) return thin;
  std::vector<std::size_t> ends;
  thin.imu.clear();
  for (std::size_t first = 0; first < log.imu.size(); first = ends.back()) {
    ends.push_back(end_of_group(log.imu, first, size));
    thin.imu.push_back(sum(log.imu, first, ends.back()));
  }
  const Samples sums = thin.imu;
  for (std::size_t k = 0, first = 0; k < sums.size(); first = ends[k++]) {
    if (ends[k] - first == 1) continue;
    const Motion whole = over(log.imu, first, ends[k]), of_sums = over(step_at(sums, k));
    thin.imu[k].dtheta += whole.turn - of_sums.turn;
    thin.imu[k].dvel += whole.velocity - of_sums.velocity;
  }
  return thin;
}

}  // namespace piste
