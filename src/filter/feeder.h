#pragma once
// Feeds a log to one or several filters in the order of time.

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/time_search.h"
#include "piste/filter/run.h"
#include "piste/math/interruption.h"
#include "piste/model/measurement_list.h"
#include "walker/fix_queue.h"

namespace piste {

/// A place in a log: the next sample, and the next fix of each sensor.
struct LogPlace {
  std::size_t imu = 0, imu_end = 0;  ///< next sample, and the end of the samples
  std::vector<std::size_t> fixes;    ///< next fix of each sensor, type by type in the order of the measurement list
  double rest_step = 0;              ///< as in LogPart
};

/// The place from which a filter that starts at `time` is fed.
inline LogPlace place_at(const Log& log, double time, const LogPart& part) {
  const auto first_from = [](const auto& samples, double t) {
    return static_cast<std::size_t>(first_at_or_after(samples, t) - samples.begin());
  };
  LogPlace place{first_from(log.imu, time + kSameInstant), first_from(log.imu, part.end), {}, part.rest_step};
  MeasurementList::for_each([&]<class Type>() {
    for (const auto& fixes : Type::logged(log)) place.fixes.push_back(first_from(fixes, time - kSameInstant));
  });
  return place;
}

/// Feeds one IMU sample per call, or at standstill as many as are merged. Fixes up to the end of the sample, plus the
/// look-ahead for their delays, are fed before it. `Sink` has add() for samples and for fixes, and look_ahead(), as
/// Filter has. The part of the first sample before `fed` was fed already, and is cut off.
template <class Sink>
class Feeder {
 public:
  Feeder(const Log& log, LogPlace from, Sink& sink, double fed = -1e300)
      : log_(log), place_(std::move(from)), sink_(sink), fed_(fed) {}

  const LogPlace& place() const { return place_; }
  bool done() const { return place_.imu >= place_.imu_end; }

  /// Returns true if an epoch was completed. @pre not done()
  bool step() {
    check_interruption();
    const ImuSample& sample = next();
    const double until = sample.time + sink_.look_ahead();
    std::size_t slot = 0;
    MeasurementList::for_each([&]<class Type>() {
      const auto sensors = Type::logged(log_);
      for (std::size_t sensor = 0; sensor < sensors.size(); ++sensor) {
        feed(sensors[sensor], place_.fixes[slot++], until, static_cast<int>(sensor));
      }
    });
    return sink_.add(sample);
  }

 private:
  const ImuSample& next() {
    const ImuSample& first = log_.imu[place_.imu++];
    const double part = (first.time - std::exchange(fed_, -1e300)) / first.interval;
    if (part < 1 - kSameInstant) {
      together_ = first;
      together_.interval *= part;
      together_.dtheta *= part;
      together_.dvel *= part;
      return together_;
    }
    if (place_.rest_step <= 0 || !stands(first)) return first;
    together_ = first;
    for (; place_.imu < place_.imu_end; ++place_.imu) {
      const ImuSample& s = log_.imu[place_.imu];
      const double apart = s.time - s.interval - together_.time, interval = together_.interval + s.interval;
      if (!stands(s) || std::abs(apart) > kSameInstant || interval > place_.rest_step + kSameInstant) break;
      together_.time = s.time;
      together_.interval = interval;
      together_.dtheta += s.dtheta;
      together_.dvel += s.dvel;
    }
    return together_;
  }

  // Whether a sample may be merged: at standstill, measured, and within the ranges.
  static bool stands(const ImuSample& s) {
    return s.at_rest && !s.gap && !s.interpolated && s.clipped_gyro == 0 && s.clipped_accel == 0;
  }

  template <class Fix>
  void feed(const std::vector<Fix>& fixes, std::size_t& next, double until, int sensor) {
    for (; next < fixes.size() && fixes[next].time <= until; ++next) sink_.add(sensor, fixes[next]);
  }

  const Log& log_;
  LogPlace place_;
  Sink& sink_;
  double fed_;
  ImuSample together_;
};

}  // namespace piste
