#pragma once
/// When a body that stands gives zero updates: at intervals, with the mean rate since the last ones.

#include <optional>

#include "piste/core/options.h"
#include "piste/model/rest.h"

namespace piste {

class RestUpdates {
 public:
  /// The next sample, in order. Returns a fix where an interval of rest without a gap is full.
  std::optional<RestFix> add(const ImuSample& sample, const RestOptions& options);

 private:
  Vector3d turn_ = Vector3d::Zero();
  double time_ = 0;  // since the last fix
};

}  // namespace piste
