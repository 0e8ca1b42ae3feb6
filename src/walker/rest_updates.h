#pragma once
/// When the filter makes zero-velocity and zero-angular-rate updates (ZUPT, ZARU): at standstill, at regular intervals,
/// with the mean rate since the last update. A standstill that the measurements contradict is withdrawn.

#include <optional>

#include "piste/core/options.h"
#include "piste/model/rest.h"

namespace piste {

/// Collects samples at standstill and makes a RestFix of each interval.
class RestUpdates {
 public:
  /// Adds the next sample. Returns a fix when an interval of standstill without a gap is complete.
  std::optional<RestFix> add(const ImuSample& sample, const RestOptions& options);

  /// Takes the result of the last fix: `used` is false if one of its channels was rejected. After `patience` such fixes
  /// in a row the standstill is withdrawn until it ends.
  void judge(bool used, const RestOptions& options);
  bool withdrawn() const { return withdrawn_; }

 private:
  Vector3d turn_ = Vector3d::Zero();
  double time_ = 0;  // s since the last fix
  int refused_ = 0;
  bool withdrawn_ = false;
};

}  // namespace piste
