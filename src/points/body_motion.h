#pragma once
/// The rate and the specific force of the body at the epochs of a run, from the samples of its log.

#include <cstddef>
#include <utility>

#include "piste/core/estimate.h"
#include "piste/core/log.h"

namespace piste {

/// Finds the sample that ends at a time, or the first one after it. Times that nearly ascend are found fast.
class SampleAt {
 public:
  explicit SampleAt(const Log& log) : imu_(&log.imu) {}
  std::size_t operator()(double time) {
    while (near_ > 0 && (*imu_)[near_ - 1].time >= time) --near_;
    while (near_ + 1 < imu_->size() && (*imu_)[near_].time < time) ++near_;
    return near_;
  }

 private:
  const std::vector<ImuSample>* imu_;
  std::size_t near_ = 0;
};

/// Means over the sample that ends at the row, without the estimated errors of the IMU: rate against i, and force, in
/// b.
class SampleMotion {
 public:
  explicit SampleMotion(const Log& log) : log_(&log), at_(log) {}
  std::pair<Vector3d, Vector3d> operator()(double time, const Estimate& x);

 private:
  const Log* log_;
  SampleAt at_;
};

}  // namespace piste
