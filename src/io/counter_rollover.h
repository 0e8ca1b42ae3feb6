#pragma once
/// Counters of 16 and 32 bits that start again at zero.

#include <array>

namespace piste {

/// Follows a counter, such as the milliseconds or microseconds since power-up that an IMU writes.
class CounterRollover {
 public:
  /// The offset of the next count: a power of two for each time that the counter fell from its last hundredth into its
  /// first. A clock that was set back does not do so.
  double offset(double count) {
    constexpr std::array<double, 2> kLengths{65536, 4294967296};
    constexpr double kEnd = 0.01;
    for (const double length : kLengths) {
      if (last_ < length && last_ > (1 - kEnd) * length && count >= 0 && count < kEnd * length) offset_ += length;
    }
    last_ = count;
    return offset_;
  }

 private:
  double last_ = 0, offset_ = 0;
};

}  // namespace piste
