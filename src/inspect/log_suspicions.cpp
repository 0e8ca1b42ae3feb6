// The words for faults between the logs of an IMU and a receiver.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "adding_to.h"
#include "log_factors.h"
#include "math/time.h"
#include "piste/inspect/log_match.h"
#include "piste/math/earth.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kClockError = 0.3;  // s: a larger offset is a fault of the clock
constexpr double kLatest = 1;        // s: largest delay of velocities
constexpr double kNearly = 0.3;      // s: tolerance to a known offset

// The likely cause of an offset of the clocks.
struct Meaning {
  LogFault fault = LogFault::kClockOffset;
  std::string what, remedy;
  bool known = false;
};

Meaning meaning_of(double offset, bool stated) {
  if (stated) {
    return {LogFault::kClockOffset, "so much its own two times of a fix are apart from its motion",
            "the whole offset stands in `clock:` of replay.yaml, with this part of it where the motion is sure", false};
  }
  const std::string as_offset = fmt::format("`clock: {{offset: {:.2f} s}}` of the IMU makes up for it", offset);
  const double size = std::abs(offset);
  // UTC behind GPS time since 1999: 13 to 18 s.
  if (size > 13 - kNearly && size < 18 + kNearly && std::abs(size - std::round(size)) < kNearly) {
    const std::string_view which = offset < 0 ? "IMU" : "receiver";
    return {LogFault::kLeapSeconds,
            fmt::format("{:.0f} s are the leap seconds: the {}'s times are UTC, it seems, and not GPS", size, which),
            fmt::format("add {:.0f} s to the {}'s times, or: {}", size, which, as_offset), true};
  }
  for (const double leap : {0.0, 18.0, -18.0}) {
    const double rest = offset - leap, days = std::round(rest / kDay), hours = std::round(rest / kHour);
    const std::string utc = leap == 0 ? "" : " (and the 18 leap seconds)";
    if (days != 0 && std::abs(rest - days * kDay) < kNearly) {
      return {LogFault::kNotSecondsOfWeek,
              fmt::format("{:.0f} days{}: seconds of the day, it seems, or of another week", std::abs(days), utc),
              "give both times in seconds of the same GPS week; or: " + as_offset, true};
    }
    if (hours != 0 && std::abs(hours) <= 14 && std::abs(rest - hours * kHour) < kNearly) {
      return {LogFault::kClockOffset, fmt::format("{:+.0f} h{}: local time, it seems", hours, utc),
              "give both times in GPS time; or: " + as_offset, true};
    }
  }
  return {LogFault::kClockOffset, "the clocks were not set by one another", as_offset, false};
}

void suspect_clock(const LogMatch& m, const std::string& imu_file, const std::string& gnss_file,
                   std::vector<Suspicion>& found) {
  const auto add = adding_to(found, imu_file);
  const bool apart = !(m.overlap > 0);
  const std::string spans = fmt::format("the IMU covers {:.3f} to {:.3f} s, {} {:.3f} to {:.3f} s", m.imu.start,
                                        m.imu.end, gnss_file, m.gnss.start, m.gnss.end);
  if (!m.clock) {
    if (apart) {
      add(LogFault::kNoOverlap, "the logs have no time in common: " + spans,
          "are they of the same run? Their motions determine no offset either");
    }
    return;
  }
  const ClockMatch& c = *m.clock;
  if (std::abs(c.offset) < std::max(kClockError, 5 * c.sigma)) return;
  if (m.velocities_may_be_late && std::abs(c.offset) < kLatest) {
    add(LogFault::kVelocityDelay,
        fmt::format("its clock is {:.2f} ± {:.2f} s {} the receiver's velocities: the positions are too coarse to show "
                    "whether the clock is wrong or the velocities come {}",
                    std::abs(c.offset), c.sigma, c.offset > 0 ? "ahead of" : "behind", c.offset > 0 ? "early" : "late"),
        "replay estimates both: `velocity_delay` and `gnss_delay`");
    return;
  }
  const Meaning meaning = meaning_of(c.offset, m.clock_told);
  const std::string by =
      fmt::format("the motions fit with the IMU's clock {:.2f} ± {:.2f} s {} the receiver's (correlation {:.2f})",
                  std::abs(c.offset), c.sigma, c.offset > 0 ? "ahead of" : "behind", c.correlation);
  if (apart && !meaning.known) {
    add(LogFault::kNoOverlap, fmt::format("the logs have no time in common: {}; {}", spans, by), meaning.remedy);
  } else {
    add(meaning.fault, fmt::format("{}: {}{}", by, meaning.what, apart ? "; as they stand, " + spans : ""),
        meaning.remedy);
  }
}

void suspect_imus(const LogMatch& m, const LogFactors& factors, const std::string& file,
                  std::vector<Suspicion>& found) {
  const auto add = adding_to(found, file);
  const double by_interval = 1 / m.interval, f = factors.gyro, a = factors.accel;
  const std::string turns = fmt::format("the gyroscopes turn {:.4g} times as fast as the track", m.turn_ratio);
  if (rather_factor(f, by_interval) && rather_factor(a, by_interval)) {
    add(LogFault::kIncrementsForRates,
        fmt::format("{}, and the forces are {:.4g} times too small, as increments over {:.4g} s are", turns, a,
                    m.interval),
        "these are increments: name the columns dtheta_x_rad and dvel_x_m_s");
    return;
  }
  if (rather_factor(f, m.interval) && rather_factor(a, m.interval)) {
    add(LogFault::kRatesForIncrements,
        fmt::format("{}, and the forces are {:.4g} times too large, as rates are over {:.4g} s", turns, 1 / a,
                    m.interval),
        "these are rates: name the columns gyro_x_rad_s and accel_x_m_s2");
    return;
  }
  if (f == kDegree) {
    add(LogFault::kGyroDegrees, turns + ": degrees under the name of radians",
        "name the columns gyro_x_deg_s, or dtheta_x_deg");
  } else if (f == kDegreesPerRadian) {
    add(LogFault::kGyroRadians, turns + ": radians under the name of degrees",
        "name the columns gyro_x_rad_s, or dtheta_x_rad");
  } else if (f != 1) {
    add(f > 1 ? LogFault::kIncrementsForRates : LogFault::kRatesForIncrements,
        fmt::format("{}, the forces are {:.4g} times too small", turns, a),
        "name the gyroscopes' columns for what they are");
  }
  const std::string forces =
      fmt::format("the forces are {:.4g} times what gravity and the track's accelerations ask", 1 / a);
  if (near_factor(a, kStandardGravity)) {
    add(LogFault::kAccelG, forces + ": g under the name of m/s^2", "name the columns accel_x_g");
  } else if (near_factor(a, 1 / kStandardGravity)) {
    add(LogFault::kAccelMetres, forces + ": m/s^2 under the name of g", "name the columns accel_x_m_s2");
  } else if (!near_factor(a, 1)) {
    add(LogFault::kAccelG, forces, "convert the accelerometers to m/s^2, or name their unit in the header");
  }
}

void suspect_axes(const MotionMatch& motion, const std::string& file, std::vector<Suspicion>& found) {
  const auto add = adding_to(found, file);
  const std::string left = fmt::format(
      "{:.2g} m/s rms are left of the velocities over 5 s where {:.2g} m/s are with the labels as they stand",
      motion.residual, motion.residual_as_given);
  if (!motion.gravity) {
    add(LogFault::kNoGravity, "the motion fits the track only without gravity in the forces: " + left,
        "give the accelerometers' own output, the specific force; `linear acceleration` has lost the tilt");
  }
  const bool reversed = (-motion.gyro_axes).isIdentity();
  if (motion.mirrored && reversed) {
    add(LogFault::kAxesMirrored,
        fmt::format("the axes are left-handed: as logged, forward, right, down are {}; {}", motion.axes, left),
        "two axes are interchanged or one is reversed, of gyroscopes and accelerometers alike: put that right in the "
        "file.");
  } else if (motion.track_mirrored()) {
    return;  // suspect_track() reports it
  } else if (motion.mirrored && motion.gyro_axes.isIdentity()) {
    add(LogFault::kAccelSign, "the motion fits the track with the forces reversed: " + left,
        "reverse the signs of the accelerometers: at rest the axis that points up reads +9.8 m/s^2. A track with "
        "latitude "
        "and longitude, or east and north, exchanged looks the same");
  } else if (motion.mirrored) {
    add(LogFault::kGyroAxes,
        fmt::format("the accelerometers' axes are left-handed: in those of the gyroscopes they are {}; {}",
                    axes_text(-motion.gyro_axes), left),
        "one of the accelerometers' axes is reversed, or two are interchanged");
  } else if (!motion.gyro_axes.isIdentity()) {
    add(LogFault::kGyroAxes,
        fmt::format(
            "the gyroscopes' axes are not the accelerometers': the columns x y z should be {} of what they are; {}",
            axes_text(motion.gyro_axes), left),
        "bring the gyroscopes' columns into that order and sign");
  }
}

// A track that turns the other way round, or would if latitude and longitude were not interchanged.
void suspect_track(const LogMatch& m, const std::string& file, std::vector<Suspicion>& found) {
  const auto add = adding_to(found, file);
  if (m.interchanged) {
    add(LogFault::kLatitudeLongitude,
        fmt::format(
            "latitude and longitude are exchanged, it seems: the track is that of the IMU's motion once they are "
            "interchanged ({:.2g} m/s rms are left of its velocities over 5 s), and mirrored as it stands",
            m.motion->residual),
        "interchange the columns latitude_deg and longitude_deg");
    return;
  }
  const std::string remedy =
      "are its latitude and longitude, or its east and north, exchanged? Else the accelerometers' signs, or the axes "
      "of "
      "the IMU, are not as its columns say";
  if (m.motion && m.motion->track_mirrored()) {
    add(LogFault::kTrackMirrored,
        fmt::format("the track is the mirror image of the motion of the IMU: {:.2g} m/s rms are left of the velocities "
                    "over 5 s where {:.2g} m/s are as it stands",
                    m.motion->residual, m.motion->residual_as_given),
        remedy);
  } else if (m.turn_correlation < 0 && (!m.motion || m.motion->as_given())) {
    add(LogFault::kTrackMirrored,
        fmt::format("the track turns left where the gyroscopes turn right (correlation of the turn rates {:.2f})",
                    m.turn_correlation),
        remedy);
  }
}

}  // namespace

std::vector<Suspicion> suspicions(const LogMatch& m, const std::string& imu_file, const std::string& gnss_file) {
  std::vector<Suspicion> found;
  if (m.interval == 0) return found;  // the rows themselves are wrong, which is reported elsewhere
  suspect_clock(m, imu_file, gnss_file, found);
  suspect_track(m, gnss_file, found);
  suspect_imus(m, log_factors(m), imu_file, found);
  if (m.motion) {
    suspect_axes(*m.motion, imu_file, found);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Suspicion& a, const Suspicion& b) { return a.fault < b.fault; });
  return found;
}

}  // namespace piste
