#pragma once
/// What looks wrong in a log, and what to do about it.

#include <string>
#include <vector>

namespace piste {

/// Kinds of faults, the worst first: those that make a log mean something else, then those that spoil every result,
/// then those that cost accuracy, then what one should know.
enum class LogFault {
  kDoesNotHold,  ///< the configuration that was made of it, by its own verdict
  // It is not what it claims to be.
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
  kTrackMirrored,       ///< it turns the other way round than the gyroscopes
  kVelocityEastNorth,   ///< east-north for north-east
  kVelocityUp,          ///< up for down
  kVelocityUnit,        ///< km/h or knots
  // Its time is not that of the others.
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
  kCoordinatesRounded,
  kClipped,
  kSigmaTooLarge,
  kLowRate,
  kJitter,
  kVelocityDelay,        ///< of the velocities relative to the positions
  kVelocityContradicts,  ///< velocities put antenna or clock elsewhere than the positions do
  kQuantised,            ///< values stand still, as they are rounded
  kAntennaSways,         ///< it moves on the body, by a replay of the configuration that was made of it
  // To know.
  kNoRest,
  kNoMotion,
  kClockUntold,  ///< nothing tells how far the clocks of two logs are apart
  kNoVelocity,
  kNoFix,
  kLeverArm,
  kNotUsed,  ///< a log that piste knows and has no use for
};

/// Whether a fault makes a log mean something else or spoils every result. The others cost accuracy at most.
constexpr bool is_severe(LogFault fault) { return fault < LogFault::kCoordinatesRounded; }

/// One thing that looks wrong.
struct Suspicion {
  LogFault fault;
  std::string file;
  std::string what;    ///< with its numbers, such as `the gyroscopes turn 57.3 times faster than …`
  std::string remedy;  ///< what to do, such as `name the columns gyro_x_deg_s`
};

}  // namespace piste
