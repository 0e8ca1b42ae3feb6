#pragma once
/// Means of rate and specific force over the last samples. By these a measurement that comes late is compared with the
/// motion at an earlier time (model/gnss.h).
///
/// Rate and force are turned into w and smoothed exponentially twice (Brown 1963). Let s₁ be the once and s₂ the twice
/// smoothed signal, with the time constant T. Of a signal that changes evenly, value without lag and slope are
///
///     2 s₁ − s₂,    (s₁ − s₂) / T
///
/// White noise of density N leaves the variance 5/4 N² / T.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Smooths the steps of a filter.
class MotionMean {
 public:
  /// Adds a step, as measured, that ends with the attitude `q_wb`.
  void add(const ImuStep& step, const Quaterniond& q_wb);
  /// The means at the end of the last step, in the axes of `q_wb`. Zero before the first step.
  RecentMotion at(const Quaterniond& q_wb, const ImuSensor& sensor) const;

 private:
  struct Smoothed {
    Vector3d once = Vector3d::Zero(), twice = Vector3d::Zero();
  };
  Smoothed rate_, force_;
  bool begun_ = false;
};

}  // namespace piste
