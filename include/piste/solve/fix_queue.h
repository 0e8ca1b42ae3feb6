#pragma once
/// A queue of fixes that wait until the IMU samples reach their time.

#include <cstddef>
#include <vector>

#include "piste/model/measurement_list.h"

namespace piste {

inline constexpr double kSameInstant = 1e-6;  ///< s: times that differ by less are the same

/// A fix in the queue.
struct QueuedFix {
  double time = 0;
  int source = 0;  ///< the first source of its sensor: the order at equal times
  int sensor = 0;  ///< its number among the sensors of its type
  AnyFix fix;
};

/// Fixes in the order of their time; at equal times in the order of their source, and then in that of their arrival.
/// They may be added in any order.
class FixQueue {
 public:
  FixQueue() { fixes_.reserve(256); }

  void add(QueuedFix&& fix);
  /// The next fix up to `time`, or null. The pointer is valid until a fix is added or the taken ones are dropped.
  const QueuedFix* next(double time) const;
  /// Takes the next fix out of the queue. It stays in memory until drop_taken().
  void take() { ++taken_; }
  /// Frees the places of the fixes that were taken.
  void drop_taken();

 private:
  std::vector<QueuedFix> fixes_;
  std::size_t taken_ = 0;
};

}  // namespace piste
