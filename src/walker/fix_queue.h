#pragma once
/// A queue of fixes that wait until the IMU samples reach their time of validity.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "piste/model/measurement_list.h"

namespace piste {

/// One channel of a fix in the queue. Position and velocity of a receiver may have different delays.
struct QueuedFix {
  double time = 0;  ///< of the fix, as its source states it
  int source = 0;   ///< decides the order of fixes with the same time of validity
  int sensor = 0;   ///< its index among the sensors of its type
  int channel = 0;
  AnyFix fix;
};

/// Fixes in the order of their time of validity, which is the time of the fix less the delay of its source. Fixes of
/// equal time are ordered by source, and then by arrival. They may be added in any order.
class FixQueue {
 public:
  FixQueue() { fixes_.reserve(256); }

  void add(QueuedFix&& fix);
  /// Takes out the next fix whose time of validity is at or before `time`. `delays`: of all sources, now [s].
  std::optional<QueuedFix> take(double time, std::span<const double> delays);

 private:
  std::vector<QueuedFix> fixes_;
};

}  // namespace piste
