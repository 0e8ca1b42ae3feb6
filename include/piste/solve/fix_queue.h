#pragma once
/// Fixes that wait for the IMU to come to their time.

#include <cstddef>
#include <vector>

#include "piste/model/measurement_list.h"

namespace piste {

inline constexpr double kSameInstant = 1e-6;  ///< s: times nearer to one another than this are one

struct QueuedFix {
  double time = 0;
  int source = 0;  ///< first of its sensor's, the order at equal times
  int sensor = 0;  ///< among those of its type
  AnyFix fix;
};

/// Ordered by time, at equal times by source, and as they came where both are equal. Fixes may be added in any order.
class FixQueue {
 public:
  FixQueue() { fixes_.reserve(256); }

  void add(QueuedFix&& fix);
  /// The next fix up to `time`, or null. Stands until the queue is changed.
  const QueuedFix* next(double time) const;
  /// Takes the next fix out. It stands until drop_taken().
  void take() { ++taken_; }
  /// Forgets what was taken.
  void drop_taken();

 private:
  std::vector<QueuedFix> fixes_;
  std::size_t taken_ = 0;
};

}  // namespace piste
