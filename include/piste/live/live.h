#pragma once
/// Navigation in real time: raw rows of an IMU and fixes of receivers in, position, velocity and attitude with their
/// sigmas out. Rest, start and filter are inside.

#include <memory>
#include <optional>

#include "piste/condition/pipeline.h"
#include "piste/start/start.h"

namespace piste {

/// One row of an IMU: sensor clock and sensor axes, rad/s and m/s².
struct ImuRow {
  double time = 0;
  Vector3d gyro, accel;
};

/// What is known at a time.
struct LiveState {
  double time = 0;  ///< GPS time
  Geodetic position;
  Vector3d velocity, euler;    ///< along local north-east-down; (roll, pitch, heading)
  Sigmas sigmas;               ///< while the heading is not known, that of the heading is 1.8 rad
  bool heading_known = false;  ///< whether one heading is left
};

struct LiveOptions {
  ConditioningOptions conditioning = {};  ///< `span` and `outages` are not used
  FilterOptions filter = {};
  InitialHeading heading = {};  ///< auto or a value: a session has no reference attitude and no magnetometer
  /// s by which the filter stays behind the newest row. A rest is seen a second after it began, and a fix may come this
  /// late; `now()` advances to the newest row.
  double lag = 1.5;
  double pass_interval = 0.25;  ///< s between two passes of the conditioning: each costs as much as `memory` is long
  double memory = 60;           ///< s of rows and fixes that are kept: a rest of half a minute must fit in
};

/// Takes rows and fixes as they come, and conditions them by the code of replay: over the last minute, four times a
/// second. So gaps are bridged, rests found and samples interpolated in the same way. Between these times a row is only
/// stored. The heading comes from a multiple-model search (src/start/heading_search.h), whose most likely filter becomes
/// the filter. If the start is still in memory, it is filtered once more with the heading that is known now.
class Live {
 public:
  /// Throws ConfigError if the options are not valid.
  explicit Live(LiveOptions options);
  ~Live();
  Live(Live&&) noexcept;
  Live& operator=(Live&&) noexcept;

  /// Adds the next row. Throws DataError if it is not later than the one before or not finite, and then is as it was
  /// before; or if the filter diverges.
  void add(const ImuRow& row);
  /// Adds a fix of a receiver. A fix that is later than `lag` is left out and counted. Throws DataError, and then is as
  /// it was before, if the receiver is none of the options or the fix cannot be right (core/fix_faults.h).
  void add(int receiver, const GeodeticFix& fix);

  /// The state of the filter, `lag` behind the newest row. Nothing before the first fixes.
  std::optional<LiveState> state() const;
  /// The state advanced to the newest row. It copies the filter, and costs as much as filtering `lag` and
  /// `pass_interval`, some 0.5 ms at 100 Hz. Rows since the last pass are taken as they came: no rest is seen in them,
  /// and no single wrong row interpolated. Fixes since then are not in it.
  std::optional<LiveState> now() const;

  /// The filter itself, once the heading is known; else null.
  const Filter* filter() const;
  /// Number of fixes that came too late.
  std::size_t late() const;

 private:
  class Session;
  std::unique_ptr<Session> session_;
};

}  // namespace piste
