#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/recording.h"
#include "math/time.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kHole = 4;         // usual intervals of the accelerometers
constexpr double kOwnInterval = 2;  // of the gyroscopes: a row after a longer step is of one usual interval

double usual_interval(const std::vector<double>& time) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < time.size(); ++i) steps.push_back(time[i] - time[i - 1]);
  return steps.empty() ? 0 : median(std::move(steps));
}

/// The accelerometers as a function of time. Times that are asked for must increase.
class Forces {
 public:
  Forces(const ImuRecording& accel, double shift)
      : accel_(accel), shift_(shift), hole_(kHole * usual_interval(accel.time)) {
    velocity_.reserve(accel.time.size());
    for (std::size_t i = 0; i < accel.time.size(); ++i) {
      if (i == 0) {
        velocity_.emplace_back(Vector3d::Zero());
      } else {
        velocity_.emplace_back(velocity_.back() + (time(i) - time(i - 1)) * accel.accel[i]);
      }
    }
  }

  double time(std::size_t i) const { return accel_.time[i] + shift_; }
  double start() const { return time(0); }
  double end() const { return time(accel_.time.size() - 1); }

  /// Whether there are rows all along.
  bool covers(double from, double to) {
    if (from < start() || to > end()) return false;
    for (std::size_t i = after(from); i < accel_.time.size() && time(i - 1) < to; ++i) {
      if (time(i) - time(i - 1) > hole_) return false;
    }
    return true;
  }
  Vector3d at(double t) { return between(accel_.accel, t); }
  Vector3d mean(double from, double to) { return (between(velocity_, to) - between(velocity_, from)) / (to - from); }

 private:
  // The row at or after t, and not the first.
  std::size_t after(double t) {
    while (at_ > 1 && time(at_ - 1) > t) --at_;
    while (at_ + 1 < accel_.time.size() && time(at_) < t) ++at_;
    return at_;
  }
  Vector3d between(const std::vector<Vector3d>& values, double t) {
    const std::size_t i = after(t);
    const double part = (t - time(i - 1)) / (time(i) - time(i - 1));
    return values[i - 1] + part * (values[i] - values[i - 1]);
  }

  const ImuRecording& accel_;
  double shift_, hole_;
  std::vector<Vector3d> velocity_;
  std::size_t at_ = 1;
};

}  // namespace

ImuRecording paired(const ImuRecording& gyro, const ImuRecording& accel, bool instant) {
  if (gyro.time.size() < 2 || accel.time.size() < 2) {
    throw DataError((gyro.time.size() < 2 ? gyro : accel).file + ":1", "holds fewer than two IMU rows");
  }
  Forces forces(accel, week_shift(accel.time.front(), gyro.time.front()));
  const double usual = usual_interval(gyro.time);
  ImuRecording both;
  both.file = gyro.file;
  both.repaired = gyro.repaired;
  both.repaired += accel.repaired;
  both.stamp_jitter = std::max(gyro.stamp_jitter, accel.stamp_jitter);
  for (std::size_t i = 0; i < gyro.time.size(); ++i) {
    const double t = gyro.time[i], step = i == 0 ? usual : t - gyro.time[i - 1];
    const double from = instant ? t : t - (step > kOwnInterval * usual ? usual : step);
    if (!forces.covers(from, t)) {
      ++both.unpaired;
      continue;
    }
    both.time.push_back(t);
    both.gyro.push_back(gyro.gyro[i]);
    both.accel.push_back(instant ? forces.at(t) : forces.mean(from, t));
    if (!gyro.magnetic.empty()) both.magnetic.push_back(gyro.magnetic[i]);
    if (!gyro.temperature.empty()) both.temperature.push_back(gyro.temperature[i]);
  }
  for (std::size_t i = 0; i < accel.time.size(); ++i) {
    if (forces.time(i) < gyro.time.front() - usual || forces.time(i) > gyro.time.back() + usual) ++both.unpaired;
  }
  if (both.time.empty()) {
    throw DataError(
        gyro.file + ":1",
        fmt::format("no time in common with {}: the gyroscopes cover {:.3f} to {:.3f} s, the accelerometers "
                    "{:.3f} to {:.3f} s; both times must be of one clock, and in their own units",
                    accel.file, gyro.time.front(), gyro.time.back(), forces.start(), forces.end()));
  }
  return both;
}

}  // namespace piste
