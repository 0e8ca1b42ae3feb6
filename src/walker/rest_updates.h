#pragma once
/// When the filter makes zero-velocity and zero-rate updates: at rest, at regular intervals, with the mean rate since
/// the last update. A rest that the measurements contradict is withdrawn.

#include <optional>

#include "piste/core/options.h"
#include "piste/model/rest.h"

namespace piste {

/// Collects samples at rest and makes a RestFix of each interval.
class RestUpdates {
 public:
  /// Adds the next sample. Returns a fix when an interval of rest without a gap is complete.
  std::optional<RestFix> add(const ImuSample& sample, const RestOptions& options);

  /// Tells whether measurements of the last sample were used. Where `patience` samples in a row had one that was
  /// refused, the rest is withdrawn until it ends: it was none.
  void judge(bool used, const RestOptions& options);
  bool withdrawn() const { return withdrawn_; }

 private:
  Vector3d turn_ = Vector3d::Zero();
  double time_ = 0;  // since the last fix
  int refused_ = 0;
  bool withdrawn_ = false;
};

}  // namespace piste
