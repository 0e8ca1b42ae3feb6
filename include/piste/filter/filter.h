#pragma once
/// The navigation filter, which takes one IMU sample or fix at a time: an error-state Kalman filter with feedback
/// (Groves 2013, section 14.2). Use it directly in a real-time program; `run_filter` (run.h) feeds it a whole log.
///
///     Filter filter(options, world, start);
///     filter.add(0, fix);                       // the first receiver's, before the samples that pass it
///     if (filter.add(sample)) show(filter.time(), filter.estimate(), filter.covariance());

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "piste/core/solution.h"
#include "piste/filter/filter_state.h"
#include "piste/filter/initial_state.h"
#include "piste/model/measurement_list.h"

namespace piste {

class KalmanFilter;  // src/filter/kalman_filter.h

/// The filter. A fix outside its gate is rejected, unless fault detection finds the filter at fault. The covariance is
/// then inflated by the error that the fix shows. The filter is always one IMU sample behind the newest. A copy of a
/// filter has its whole state: two copies with the same input give the same bytes.
class Filter {
 public:
  /// Throws ConfigError if the options are not valid.
  Filter(const FilterOptions& options, const World& world, const Start& start);
  Filter(const Filter& other);
  Filter(Filter&& other) noexcept;
  Filter& operator=(const Filter& other);
  Filter& operator=(Filter&& other) noexcept;
  ~Filter();

  /// Adds the next IMU sample, and processes the previous one. Returns true if there was one: time(), estimate() and
  /// covariance() are then those of its end. All fixes up to that time must have been added before. No heap.
  /// Throws DataError if `sample` is not finite, if its interval is not positive, or if it is not later than the
  /// previous one. The filter is then as it was before. Throws DataError if the filter diverges.
  bool add(const ImuSample& sample);
  /// Adds a fix, in any order of time. `sensor` counts from 0 among the sensors of the fix's type: 1 is the second
  /// receiver for a GnssFix. A fix older than time() is left out and counted by late(). A fix of a type that the
  /// options do not use is left out without a count.
  ///
  /// A fix with a known or estimated delay is compared with the estimate at its time of validity. For this it must be
  /// added before the samples pass that time: add all fixes up to time() + look_ahead(). A fix that is added later, as
  /// in real time, is compared with the next estimate, carried back over the delay (model/gnss.h).
  void add(int sensor, const AnyFix& fix);
  /// Processes the last sample. Nothing may be added after it. Returns false if there is no sample. Throws as add().
  bool finish();

  /// How far ahead of the samples fixes must be added so that each is used at its time of validity [s]. It is the
  /// longest delay, and one second more if a delay is estimated. 0 without delays.
  double look_ahead() const;

  double time() const { return state().time; }
  const Estimate& estimate() const { return state().x; }
  const Covariance& covariance() const { return state().P; }
  const FilterState& state() const;  ///< the current state
  const StateLayout& layout() const;
  const World& world() const;
  const FilterOptions& options() const;
  const std::vector<std::string>& sources() const;  ///< names of the sources, indexed by Innovation::source
  /// The estimate advanced to the newest sample, without covariance: for a display that cannot wait for the next
  /// sample.
  Estimate predicted() const;
  std::span<const Innovation> innovations() const;  ///< since the last call to clear_innovations()
  void clear_innovations();
  std::size_t late() const;  ///< number of fixes that came too late

 private:
  const KalmanFilter& kalman() const;
  KalmanFilter& kalman();

  // The private parts, in place instead of on the heap. filter_in_place.cpp checks the size.
  static constexpr std::size_t kSize = 204800;
  alignas(64) std::array<std::byte, kSize> storage_;
};

}  // namespace piste
