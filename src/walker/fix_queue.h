#pragma once
/// A queue of fixes that wait until the IMU samples reach the time where they belong.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "piste/model/measurement_list.h"

namespace piste {

/// One channel of a fix in the queue: position and velocity of a receiver may belong to different times.
struct QueuedFix {
  double time = 0;  ///< of the fix, as its source states it
  int source = 0;   ///< decides the order of what belongs to the same time
  int sensor = 0;   ///< its number among the sensors of its type
  int channel = 0;
  AnyFix fix;
};

/// Fixes in the order of the times where they belong, which is that of the fix less the delay of its source. At equal
/// times they are in the order of their source, and then in that of their arrival. They may be added in any order.
class FixQueue {
 public:
  FixQueue() { fixes_.reserve(256); }

  void add(QueuedFix&& fix);
  /// Takes out the next fix that belongs to `time` or before. `delays` are those of all sources now [s].
  std::optional<QueuedFix> take(double time, std::span<const double> delays);

 private:
  std::vector<QueuedFix> fixes_;
};

}  // namespace piste
