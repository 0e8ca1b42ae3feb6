#pragma once
/// What looks wrong in a log, in words that lead to its remedy.

#include <string>
#include <vector>

namespace piste {

/// Kinds of what can be wrong, the worst first: those that make a log mean something else, then those that spoil all
/// that is made of it, then those that cost accuracy, then what one should know.
enum class LogFault {
  // It is not what it claims to be.
  kUnreadable,
  kEmpty,
  kSameLog,             ///< two files hold the same recording
  kTimeUnit,            ///< milliseconds, microseconds for seconds
  kIncrementsForRates,  ///< increments under the names of rates
  kRatesForIncrements,  ///< and the other way round
  kGyroDegrees,         ///< degrees under the name of radians
  kGyroRadians,         ///< and the other way round
  kAccelG,              ///< g under the name of m/s²
  kAccelMetres,         ///< and the other way round
  kNoGravity,           ///< accelerations without gravity
  kAccelSign,           ///< minus the specific force
  kAxesMirrored,        ///< two axes of the whole IMU interchanged, or one turned round
  kGyroAxes,            ///< the gyroscopes' axes are not the accelerometers'
  kLatitudeLongitude,   ///< interchanged
  kVelocityEastNorth,   ///< east-north for north-east
  kVelocityUp,          ///< up for down
  kVelocityUnit,        ///< km/h or knots
  // Its time is not that of the others.
  kNotSecondsOfWeek,  ///< seconds of the day, or since 1970
  kTimeBack,
  kNoOverlap,
  kLeapSeconds,  ///< UTC for GPS time
  kClockOffset,
  // It is broken in places.
  kBadRows,  ///< text, NaN, cut lines, impossible values
  kTimeRepeated,
  kClockJump,
  kGaps,
  kFrozenSensor,  ///< the same sample again and again
  kSpikes,
  kRepeatedFix,  ///< the receiver says its last fix again
  kPositionJumps,
  kSigmaTooSmall,
  // It costs accuracy.
  kCoordinatesRounded,
  kClipped,
  kSigmaTooLarge,
  kLowRate,
  kJitter,
  kVelocityDelay,  ///< of the velocities against the positions
  kQuantised,
  // To know.
  kNoRest,
  kNoMotion,
  kNoVelocity,
  kNoFix,
  kLeverArm,
};

/// Whether a fault makes a log mean something else or spoils what is made of it; the others cost accuracy at most.
constexpr bool is_severe(LogFault fault) { return fault < LogFault::kCoordinatesRounded; }

struct Suspicion {
  LogFault fault;
  std::string file;
  std::string what;    ///< with the numbers that it rests on, such as `the gyroscopes turn 57.3 times faster than …`
  std::string remedy;  ///< what to do, such as `name the columns gyro_x_deg_s`
};

}  // namespace piste
