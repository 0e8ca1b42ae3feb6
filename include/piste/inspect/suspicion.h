#pragma once
/// The faults of a log, and what to do about them.

#include <string>
#include <vector>

namespace piste {

/// Kinds of faults, the worst first: faults that make a log mean something else, faults that spoil every result, faults
/// that cost accuracy, remarks.
enum class LogFault {
  kDoesNotHold,  ///< the generated configuration does not pass its own verdict
  // The log is not what its labels say.
  kUnreadable,
  kEmpty,
  kSameLog,             ///< two files have the same recording
  kTimeUnit,            ///< milliseconds or microseconds instead of seconds
  kIncrementsForRates,  ///< increments under the names of rates
  kRatesForIncrements,  ///< and the other way round
  kGyroDegrees,         ///< degrees under the name of radians
  kGyroRadians,         ///< and the other way round
  kAccelG,              ///< g under the name of m/s²
  kAccelMetres,         ///< and the other way round
  kNoGravity,           ///< accelerations without gravity
  kAccelSign,           ///< the log has minus the specific force
  kAxesMirrored,        ///< of the whole IMU: two axes interchanged, or one reversed
  kGyroAxes,            ///< the gyroscopes' axes are not the accelerometers'
  kLatitudeLongitude,   ///< interchanged
  kTrackMirrored,       ///< the track turns the other way round than the gyroscopes
  kVelocityEastNorth,   ///< east-north for north-east
  kVelocityUp,          ///< up for down
  kVelocityUnit,        ///< km/h or knots
  // Its time does not agree with the other logs.
  kNotSecondsOfWeek,  ///< seconds of the day, or since 1970
  kTimeBack,
  kNoOverlap,
  kLeapSeconds,  ///< UTC for GPS time
  kClockOffset,
  kAttitudeClock,  ///< of an attitude log against the IMU
  kAttitudeAxes,   ///< an attitude log is of other axes than the IMU
  // It is broken in places.
  kBadRows,  ///< text, NaN, cut lines, impossible values
  kTimeRepeated,
  kClockJump,
  kGaps,
  kFrozenSensor,  ///< the same sample many times
  kSpikes,
  kRepeatedFix,  ///< the receiver repeats its last fix
  kPositionJumps,
  kSigmaTooSmall,
  // It costs accuracy.
  kDoubt,  ///< two readings of the logs are equally likely, or the whole log contradicts the one of a part
  kCoordinatesRounded,
  kClipped,
  kSigmaTooLarge,
  kLowRate,
  kJitter,
  kVelocityDelay,        ///< of the velocities relative to the positions
  kVelocityContradicts,  ///< velocities put antenna or clock elsewhere than the positions do
  kQuantised,            ///< values are constant because they are rounded
  kAntennaSways,         ///< the antenna moves on the body, by a replay of the generated configuration
  // To know.
  kNoRest,
  kNoMotion,
  kClockUntold,  ///< the logs do not determine the offset between their clocks
  kNoVelocity,
  kNoFix,
  kLeverArm,
  kNotUsed,  ///< piste knows the log, but does not use it
};

/// Whether a fault makes a log mean something else or spoils every result. The other faults cost accuracy at most.
constexpr bool is_severe(LogFault fault) { return fault < LogFault::kDoubt; }

/// One fault.
struct Suspicion {
  LogFault fault;
  std::string file;
  std::string what;    ///< with its numbers, such as `the gyroscopes turn 57.3 times faster than …`
  std::string remedy;  ///< what to do, such as `name the columns gyro_x_deg_s`
};

}  // namespace piste
