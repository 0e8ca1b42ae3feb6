#include "piste/condition/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "condition/first_fixes.h"
#include "condition/ramp_faults.h"
#include "condition/several_imus.h"
#include "core/time_search.h"
#include "math/magnetic_field.h"
#include "math/time.h"
#include "piste/condition/rest_detection.h"
#include "piste/core/error.h"
#include "piste/math/interruption.h"

namespace piste {
namespace {

// To the week of the IMU.
template <class Fix>
double week_shift(const std::vector<Fix>& fixes, double imu_time) {
  return fixes.empty() ? 0 : piste::week_shift(fixes.front().time, imu_time);
}

template <class Fix>
std::string span_text(const std::string& file, const std::vector<Fix>& fixes, double shift) {
  if (fixes.empty()) return fmt::format("{} is empty", file);
  return fmt::format("{} covers {:.3f} to {:.3f} s", file, fixes.front().time + shift, fixes.back().time + shift);
}

/// The fixes of one receiver that are used. The others are counted.
std::vector<GeodeticFix> used_fixes(const GnssRecording& receiver, const Interval& imu,
                                    const std::vector<Interval>& outages, LogCounts& counts) {
  const double shift = week_shift(receiver.fixes, imu.start);
  std::size_t withheld = 0, outside = 0;
  std::vector<GeodeticFix> used;
  for (GeodeticFix fix : receiver.fixes) {
    fix.time += shift;
    if (!imu.contains(fix.time)) {
      ++outside;
    } else if (std::any_of(outages.begin(), outages.end(), [&](const Interval& o) { return o.contains(fix.time); })) {
      ++withheld;
    } else {
      used.push_back(fix);
    }
  }
  counts.gnss_outside.push_back(outside);
  counts.gnss_withheld.push_back(withheld);
  counts.gnss_without_fix.push_back(receiver.without_fix);
  counts.gnss_not_used.push_back(receiver.not_used);
  counts.gnss_repaired.push_back(receiver.repaired);
  return used;
}

GnssFix in_world(const World& world, const GeodeticFix& fix) {
  GnssFix result{fix.time,           world.from_geodetic(fix.position),
                 fix.sigma_position, fix.velocity,
                 fix.correlation,    fix.slow_level,
                 fix.slow_change};
  result.quality = fix.quality;
  result.satellites = fix.satellites;
  if (result.velocity) result.velocity->value = world.rotation_wn(result.position) * fix.velocity->value;
  return result;
}

// Position at t by linear interpolation between the fixes around it; before the first and after the last, that fix.
Vector3d position_at(const std::vector<GnssFix>& fixes, double t) {
  const auto after = first_at_or_after(fixes, t);
  if (after == fixes.begin()) return fixes.front().position;
  if (after == fixes.end()) return fixes.back().position;
  const auto before = after - 1;
  const double part = (t - before->time) / (after->time - before->time);
  return (1 - part) * before->position + part * after->position;
}

AttitudeFix in_world(const World& world, const EulerFix& fix, double time, const Vector3d& p_w) {
  const Matrix3d R_wn = world.rotation_wn(p_w);
  const Matrix3d axes_w = R_wn * euler_axes(fix.angles);
  return {time, Quaterniond(R_wn) * from_euler(fix.angles),
          axes_w * fix.sigma.cwiseAbs2().asDiagonal() * axes_w.transpose()};
}

// `world`, if it is not null, is that of the log: then no fix is needed.
void condition_gnss(const Recording& recording, const Interval& imu, const ConditioningOptions& options,
                    const World* world, Log& log) {
  if (recording.gnss.empty()) throw DataError("", "no GNSS: a `gnss:` source is needed for position");
  std::vector<std::vector<GeodeticFix>> used;
  for (const GnssRecording& receiver : recording.gnss) {
    used.push_back(used_fixes(receiver, imu, options.outages, log.counts));
  }
  const auto first = std::find_if(used.begin(), used.end(), [](const auto& fixes) { return !fixes.empty(); });
  if (first == used.end() && world == nullptr) {
    const GnssRecording& receiver = recording.gnss.front();
    const bool withheld =
        std::any_of(log.counts.gnss_withheld.begin(), log.counts.gnss_withheld.end(), [](auto n) { return n > 0; });
    throw DataError(recording.imu.file + ":1",
                    withheld
                        ? std::string("every GNSS fix within the IMU's time is withheld; shorten `outages`")
                        : fmt::format("no time in common with GNSS: the IMU covers {:.3f} to {:.3f} s, {}; check the "
                                      "files, `span`, and `clock: {{offset}}` of the IMU",
                                      imu.start, imu.end,
                                      span_text(receiver.file, receiver.fixes, week_shift(receiver.fixes, imu.start))));
  }
  log.world = world != nullptr ? *world : World(first->front().position);
  for (const auto& fixes : used) {
    auto& out = log.gnss.emplace_back();
    SlowLevel level;
    for (const GeodeticFix& fix : fixes) {
      out.push_back(in_world(log.world, fix));
      if (!fix.slow_level.isZero(0)) continue;
      out.back().slow_level = level.next(fix.time, fix.sigma_position);
      out.back().slow_change = level.take_change();
    }
    log.counts.gnss_contradicted.push_back(widen_first_fixes(out, options.behaviour.trust, log.world));
    log.counts.gnss_ramps.push_back(exclude_ramp_faults(out, options.behaviour.trust, log.world));
  }
}

void condition_attitude(const Recording& recording, const Interval& imu, Log& log) {
  const auto receiver =
      std::find_if(log.gnss.begin(), log.gnss.end(), [](const auto& fixes) { return !fixes.empty(); });
  for (const AttitudeRecording& source : recording.attitude) {
    const double shift = week_shift(source.fixes, imu.start);
    auto& out = log.attitude.emplace_back();
    for (const EulerFix& fix : source.fixes) {
      const double time = fix.time + shift;
      if (imu.contains(time)) out.push_back(in_world(log.world, fix, time, position_at(*receiver, time)));
    }
    log.counts.attitude_outside.push_back(source.fixes.size() - out.size());
    log.counts.attitude_not_valid.push_back(source.not_valid);
    log.counts.attitude_repaired.push_back(source.repaired);
    if (out.empty()) {
      throw DataError(
          recording.imu.file + ":1",
          fmt::format("no time in common with the reference attitude: the IMU covers {:.3f} to {:.3f} s, {}", imu.start,
                      imu.end, span_text(source.file, source.fixes, shift)));
    }
  }
}

// The fixes of a file within the IMU's time; the others are counted.
template <class Fix>
std::vector<Fix> within(const FixRecording<Fix>& recording, const Interval& imu, std::size_t& outside) {
  const double shift = week_shift(recording.fixes, imu.start);
  std::vector<Fix> out;
  for (Fix fix : recording.fixes) {
    fix.time += shift;
    if (imu.contains(fix.time)) out.push_back(fix);
  }
  outside = recording.fixes.size() - out.size();
  if (!recording.fixes.empty() && out.empty()) {
    throw DataError(recording.file + ":1",
                    fmt::format("no time in common with the IMU, which covers {:.3f} to {:.3f} s: {}", imu.start,
                                imu.end, span_text(recording.file, recording.fixes, shift)));
  }
  return out;
}

// The log of the IMU, or of several as one, alone.
Log imus_alone(const Recording& recording, const ConditioningOptions& options) {
  return options.imus.empty() ? condition_imu(recording.imu, options) : condition_imus(recording, options);
}

// The Earth's field at each magnetic sample: at the last fix before it.
void add_earth_field(const MagneticConditioning& options, Log& log) {
  constexpr double kReach = 1000;  // m: the field turns by 0.01 deg over it
  const std::vector<GnssFix>* track = log.gnss.empty() ? nullptr : &log.gnss.front();
  const auto field_at = [&](const Vector3d& p_w) {
    Vector3d field = options.field ? *options.field : magnetic_field(log.world.to_geodetic(p_w), options.year);
    if (!options.declination) return field;
    const double level = field.head<2>().norm();
    return Vector3d(level * std::cos(*options.declination), level * std::sin(*options.declination), field.z());
  };
  Vector3d place = Vector3d::Zero(), field = field_at(place);
  std::size_t next = 0;
  for (MagneticSample& sample : log.magnetic) {
    while (track != nullptr && next < track->size() && (*track)[next].time <= sample.time) ++next;
    if (next > 0 && ((*track)[next - 1].position - place).norm() > kReach) {
      place = (*track)[next - 1].position;
      field = field_at(place);
    }
    sample.earth = field;
  }
}

// `log` is that of the IMU of the recording.
Log conditioned(Log log, const Recording& recording, const ConditioningOptions& options, const World* world) {
  const Interval imu{log.imu.front().time - log.imu.front().interval, log.imu.back().time};
  condition_gnss(recording, imu, options, world, log);
  add_earth_field(options.magnetic, log);
  condition_attitude(recording, imu, log);
  log.speed = within(recording.speed, imu, log.counts.speed_outside);
  log.height = within(recording.height, imu, log.counts.height_outside);
  log.heading = within(recording.heading, imu, log.counts.heading_outside);
  log.counts.speed_repaired = recording.speed.repaired;
  log.counts.height_repaired = recording.height.repaired;
  log.counts.heading_repaired = recording.heading.repaired;
  if (!options.behaviour.rest.detect) return log;
  check_interruption();
  std::vector<Interval> rest = detect_rest(log, options.behaviour.rest);
  return with_rest(std::move(log), std::move(rest));
}

}  // namespace

Log condition(const Recording& recording, const ConditioningOptions& options) {
  return conditioned(imus_alone(recording, options), recording, options, nullptr);
}

Log condition(Recording&& recording, const ConditioningOptions& options) {
  const std::string file = recording.imu.file;
  Log log =
      options.imus.empty() ? condition_imu(std::move(recording.imu), options) : condition_imus(recording, options);
  recording.further.clear();
  recording.imu = {};
  recording.imu.file = file;
  return conditioned(std::move(log), recording, options, nullptr);
}

Log condition(const Recording& recording, const ConditioningOptions& options, const World& world) {
  return conditioned(imus_alone(recording, options), recording, options, &world);
}

}  // namespace piste
