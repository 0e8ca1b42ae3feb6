#pragma once
/// Navigation in real time: takes raw rows of an IMU and fixes of receivers, and gives position, velocity and attitude
/// with their sigmas. Detection of standstill, start and filter are included.

#include <memory>
#include <optional>

#include "piste/condition/pipeline.h"
#include "piste/start/start.h"

namespace piste {

/// One row of an IMU: time of the sensor's clock, sensor axes, rad/s and m/s².
struct ImuRow {
  double time = 0;
  Vector3d gyro, accel;
};

/// The navigation state at one time.
struct LiveState {
  double time = 0;  ///< GPS time
  Geodetic position;
  Vector3d velocity, euler;    ///< along local north-east-down; (roll, pitch, heading)
  Sigmas sigmas;               ///< until the heading is known, that of the heading covers all hypotheses
  bool heading_known = false;  ///< whether the heading search has ended
};

struct LiveOptions {
  ConditioningOptions conditioning = {};  ///< `span` and `outages` are not used
  FilterOptions filter = {};
  InitialHeading heading = {};  ///< auto or a value: a session has no reference attitude and no magnetometer
  /// s by which the filter stays behind the newest row. Standstill is detected one second after its beginning, and a
  /// fix may come this late. `now()` advances to the newest row.
  double lag = 1.5;
  double pass_interval = 0.25;  ///< s between two passes of the conditioning, whose cost grows with `memory`
  double memory = 60;           ///< s of rows and fixes that are kept: a standstill of half a minute must fit in
};

/// Takes rows and fixes as they come, and conditions them by the code of replay: over the last `memory` seconds, every
/// `pass_interval`. So gaps are bridged, standstill is detected and samples are interpolated in the same way. Between
/// these passes a row is only stored. The heading comes from a multiple-model search (src/start/heading_search.h),
/// whose most likely filter becomes the filter. If the start is still in memory, it is filtered once more with the
/// heading now known.
class Live {
 public:
  /// Throws ConfigError if the options are not valid.
  explicit Live(LiveOptions options);
  ~Live();
  Live(Live&&) noexcept;
  Live& operator=(Live&&) noexcept;

  /// Adds the next row. Throws DataError, and leaves the session as it was, if the row is not finite or not later than
  /// the previous one. Throws DataError if the filter diverges.
  void add(const ImuRow& row);
  /// Adds a fix of a receiver. A fix that is more than `lag` late is left out and counted. Throws DataError, and leaves
  /// the session as it was, if the options have no such receiver or the fix cannot be right (core/fix_faults.h).
  void add(int receiver, const GeodeticFix& fix);

  /// The state of the filter, `lag` behind the newest row. Nothing until a start is found.
  std::optional<LiveState> state() const;
  /// The state advanced to the newest row. It copies the filter, and costs as much as filtering `lag` and
  /// `pass_interval`: some 0.5 ms at 100 Hz. Rows since the last pass are used as measured: no standstill is detected
  /// in them, and no single wrong row is interpolated. Fixes since that pass are not used.
  std::optional<LiveState> now() const;

  /// The filter once the heading is known, else null.
  const Filter* filter() const;
  /// Number of fixes that came too late.
  std::size_t late() const;

 private:
  class Session;
  std::unique_ptr<Session> session_;
};

}  // namespace piste
