#include "piste/inspect/inspection.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "configuration/replay_keys.h"
#include "core/receiver_class.h"
#include "io/path_from.h"
#include "math/words.h"
#include "piste/configuration/sensor_file.h"
#include "piste/core/sensor_class.h"
#include "piste/io/config.h"
#include "piste/math/earth.h"
#include "piste/math/units.h"

namespace piste {

bool uses_velocities(const InspectedLog& log) {
  return log.gnss_health->velocities > 0 && !(log.calibration && log.calibration->velocities_contradict);
}

namespace {

constexpr double kSureClock = 0.02;     // s: largest 1-sigma of a clock offset that the motion determines
constexpr double kKnownClock = 0.005;   // s: a smaller offset is not written
constexpr double kGains = 2.449489743;  // sigmas, √(2 · 3): an offset that far from the log's own gains ln 1 + 3

// 1-sigmas of a triad's errors from its noise and its mean at rest.
TriadErrors guess_triad(const TriadHealth& health, double interval, double usual_noise, double bias_of_noise,
                        double seen_bias, double scale) {
  TriadErrors e;
  const double noise = health.noise.maxCoeff();
  const double rounding = health.quantum.maxCoeff() * std::sqrt(interval / 12);
  e.noise = std::isfinite(noise) && noise > 0 ? std::max(noise, rounding) : usual_noise;
  e.bias = std::max(bias_of_noise * e.noise, seen_bias);
  constexpr double kDriftOfBias = 0.2, kCorrelationTime = 200;
  e.drift = {DriftProcess::Kind::kGaussMarkov, kDriftOfBias * bias_of_noise * e.noise, kCorrelationTime, 0};
  e.scale = scale;
  e.range = health.limit.maxCoeff();
  return e;
}

constexpr int kDigits = 2;  // of the parameters of an undescribed sensor

Vector3d mean_of(const std::vector<Vector3d>& values) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

std::string file_keys(const InspectedLog& log, const std::string& folder, std::string_view indent) {
  // Content from memory is written next to the configuration.
  std::string text =
      fmt::format("file: {}\n", yaml_text(log.log.content ? log.log.file : path_from(folder, log.log.file)));
  if (!log.log.accel_file.empty()) {
    text += fmt::format("{}accel_file: {}\n", indent, yaml_text(path_from(folder, log.log.accel_file)));
  }
  if (!log.log.gravity_file.empty()) {
    text += fmt::format("{}gravity_file: {}\n", indent, yaml_text(path_from(folder, log.log.gravity_file)));
  }
  text += fmt::format("{}format: {}\n", indent, name_of(log.log.format));
  for (const std::string& doubt : log.guess->doubts) text += fmt::format("{}# {}\n", indent, doubt);
  if (log.log.columns) {
    text += fmt::format("{}columns: {}\n", indent, columns_text(*log.log.columns, std::string(indent) + "  "));
  }
  if (log.log.repair) text += fmt::format("{}repair: true                # {}\n", indent, log.repaired());
  if (log.log.shared_stamps) text += fmt::format("{}stamps: shared               # several rows have one\n", indent);
  if (log.faults.unknown_columns.empty()) return text;
  std::vector<std::string> names;
  for (const std::string& column : log.faults.unknown_columns) names.push_back(yaml_text(column));
  text += fmt::format("{}ignore_columns: [{}]\n", indent, fmt::join(names, ", "));
  return text;
}

// The slow error of a receiver, and its evidence.
std::string drift_text(const PositionDrift& drift, std::string_view why) {
  const std::string most =
      std::isfinite(drift.most_white) ? fmt::format(", most_white: {} m", plain(drift.most_white, kDigits)) : "";
  return fmt::format("    drift: {{{}: {}, correlation_time: {} s{}}}   # {}\n", drift.of_stated ? "share" : "sigma",
                     size_text(drift), plain(drift.correlation_time, kDigits), most, why);
}

// The class whose sigmas are stated for a log without: that of the quality which most fixes have.
const ReceiverClass& class_of(const InspectedLog& log) {
  const auto& counts = log.gnss_health->qualities;
  return receiver_class(static_cast<FixQuality>(std::max_element(counts.begin(), counts.end()) - counts.begin()));
}

bool has_own_factors(const InspectedLog& log) {
  const auto& own = log.log.sigma_scales.of_quality;
  return std::any_of(own.begin(), own.end(), [](double factor) { return factor > 0; });
}

// The factors of the qualities that a log has, each times `all`.
std::string scales_of_qualities(const InspectedLog& log, double all) {
  constexpr int kDifference = 5;
  std::vector<std::string> each;
  for (std::size_t i = 0; i < kQualities; ++i) {
    if (log.gnss_health->qualities[i] == 0) continue;
    each.push_back(fmt::format("{}: {}", kQualityNames[i],
                               plain(all * log.log.sigma_scales.of(static_cast<FixQuality>(i)), kDifference)));
  }
  return fmt::format("    sigma_scale: {{{}}}   # of the sigmas of positions, by the quality of the fix\n",
                     fmt::join(each, ", "));
}

// The factors of a receiver's sigmas where the motion contradicts these sigmas, and its slow error. The white part is
// the difference of the squares of two of these numbers, so they have more digits than their accuracy justifies.
std::string receiver_noise(const Calibration& found, const InspectedLog& log) {
  constexpr double kRight = 0.1;
  constexpr int kDifference = 5;
  const auto wrong = [](double scale) { return std::abs(scale - 1) > kRight; };
  std::string text;
  const SigmaScales& scales = found.sigma_scales;
  if (has_own_factors(log)) {
    text += scales_of_qualities(log, scales.position);
  } else if (wrong(scales.position) || (found.drift && std::abs(scales.position - 1) > 1e-4)) {
    text += fmt::format("    sigma_scale: {}           # of the sigmas of positions, as likely in motion\n",
                        plain(scales.position, kDifference));
  }
  if (wrong(scales.height)) {
    text +=
        fmt::format("    sigma_height_scale: {}    # of their heights, besides\n", plain(scales.height, kDifference));
  }
  if (wrong(scales.velocity)) {
    text += fmt::format("    sigma_velocity_scale: {}     # of velocities\n", plain(scales.velocity, kDigits));
  }
  if (found.drift_by == DriftBy::kClaim) {
    text +=
        "    # Fixes differ by less than is stated: the rest is taken to be slow. An error that lasts moves fixes and\n"
        "    # track together, so that innovations cannot show it. Where there is none, say so: `drift: none`.\n";
  }
  if (!found.drift) return text;
  return text + drift_text(*found.drift, found.drift_by == DriftBy::kRounding ? "heights are rounded, and stand still"
                                                                              : "the slow part");
}

constexpr double kLoose = 5;           // times a sigma by the motion, as the replay uses the same motion again
constexpr double kMostArm = 1;         // m: the prior of an unobserved lever arm
constexpr double kStatedDelay = 0.01;  // s: sigma of a delay that the log itself states
constexpr double kLeastDelay = 0.005;  // s: smallest prior of a delay

double late_prior(double sigma) {
  constexpr double kLeast = 0.02;  // s: the reference of the measurement has delays of its own
  return std::max(kLoose * sigma, kLeast);
}

// The delay of a receiver's velocities, by the filter, by its positions, or as stated in the log; and the prior of the
// delay in a replay.
struct LateVelocities {
  double delay, sigma, prior;
};

// The delay relative to the IMU's clock with the offset that is written.
std::optional<LateVelocities> late_velocities(const InspectedLog& log, double written_offset) {
  if (!uses_velocities(log)) return std::nullopt;
  if (const auto& found = log.calibration; found && found->fits() && found->velocity_delay_sigma > 0) {
    return LateVelocities{.delay = found->velocity_delay + written_offset - found->clock_offset,
                          .sigma = std::hypot(found->velocity_delay_sigma, found->clock_sigma),
                          .prior = priors_after(*found).velocity_delay};
  }
  const auto& velocity = log.gnss_health->velocity;
  if (const auto delay = velocity ? velocity->known_delay() : std::nullopt)
    return LateVelocities{.delay = *delay, .sigma = velocity->sigma_delay, .prior = late_prior(velocity->sigma_delay)};
  if (const double stated = log.gnss.velocity_latency; stated != 0)
    return LateVelocities{.delay = stated, .sigma = kStatedDelay, .prior = late_prior(kStatedDelay)};
  return std::nullopt;
}

// The largest priors of the delays of sources that are late or may be late [s].
struct LateSources {
  std::optional<double> velocity, attitude;
};

// The priors of a configuration. `delayed`: whether the delay of the fixes is estimated.
std::string priors_text(const Calibration* found, const LateSources& late, bool delayed, bool drifts) {
  Priors priors{.lever_arm = kMostArm};
  if (found != nullptr) priors = priors_after(*found);
  std::string text = fmt::format("lever_arm: {} m", plain(priors.lever_arm, kDigits));
  if (delayed) text += fmt::format(", gnss_delay: {} s", plain(priors.gnss_delay, kDigits));
  if (drifts) text += fmt::format(", clock_drift: {} ppm", plain(1e6 * priors.clock_drift, kDigits));
  if (late.velocity) text += fmt::format(", velocity_delay: {} s", plain(*late.velocity, kDigits));
  if (late.attitude) text += fmt::format(", attitude_delay: {} s", plain(*late.attitude, kDigits));
  return "{" + text + "}";
}

// The residual clock offset of the motions, beyond the clock that the receiver's log states.
std::string rest_of_clock(const LogMatch* match) {
  if (match == nullptr || !match->clock) return {};
  return fmt::format(
      "  # The motions fit best with an offset {:+.3f} s from this, +- {:.3f} s, or with velocities so late.\n",
      match->clock->offset, match->clock->sigma);
}

// The steps of a clock, as the value of `clock` has them; empty without any.
std::string steps_text(const std::vector<ClockStep>& steps) {
  std::vector<std::string> each;
  each.reserve(steps.size());
  for (const ClockStep& s : steps)
    each.push_back(fmt::format("[{} s, {} s]", with_decimals(s.time, 6), with_decimals(s.step, 6)));
  return each.empty() ? "" : fmt::format("steps: [{}]", fmt::join(each, ", "));
}

std::string as_likely(const MotionMatch& motion) {
  if (motion.as_likely.empty()) return "as the motion has them";
  return fmt::format("the IMU sits askew: as likely are {}; the angles are relative to these axes",
                     fmt::join(motion.as_likely, ", "));
}

// A comment on a key whose value the logs do not determine; empty where they do.
std::string doubt_text(const Inspection& inspection, const std::string& key) {
  const auto doubt = std::ranges::find(inspection.doubts, key, &InspectedDoubt::key);
  if (doubt == inspection.doubts.end()) return {};
  return fmt::format("# The logs do not determine {}: {}.\n", doubt->what, doubt->readings_text());
}

}  // namespace

std::optional<std::size_t> Inspection::first(LogKind kind) const {
  const auto place = std::find_if(logs.begin(), logs.end(), [kind](const InspectedLog& l) {
    return l.is(kind) && (l.imu_health || l.gnss_health || l.attitude_sampling);
  });
  if (place == logs.end()) return std::nullopt;
  return static_cast<std::size_t>(place - logs.begin());
}

std::string InspectedLog::repaired() const {
  const RepairedRows& rows = imu_health ? imu.repaired : gnss_health ? gnss.repaired : attitude.repaired;
  std::string text = fmt::format("{} rows sorted, {} of a repeated time dropped", rows.sorted, rows.dropped);
  if (rows.unreadable > 0) text += fmt::format(", {} left out as unreadable", rows.unreadable);
  return text;
}

std::string Calibration::why_no_arm() const {
  if (tells_arm()) return {};
  const std::string found =
      fmt::format("{:.2f} {:.2f} {:.2f} m +- {:.2f} {:.2f} {:.2f} (forward right down)", lever_arm.x(), lever_arm.y(),
                  lever_arm.z(), lever_arm_sigma.x(), lever_arm_sigma.y(), lever_arm_sigma.z());
  return fits()
             ? fmt::format("The motion determines the lever arm too roughly to be used: {}.", found)
             : fmt::format("The filter rejected {} of {} measurements, so that the lever arm it found is not used: {}.",
                           rejected, used + rejected, found);
}

const LogMatch* Inspection::first_match() const {
  const auto imu = first(LogKind::kImu), gnss = first(LogKind::kGnss);
  for (const InspectedMatch& m : matches) {
    if (imu == m.imu && gnss == m.gnss) return &m.match;
  }
  return nullptr;
}

const AttitudeMatch* Inspection::attitude_match(const InspectedLog& attitude) const {
  for (const InspectedAttitude& a : attitudes) {
    if (&logs[a.attitude] == &attitude) return &a.match;
  }
  return nullptr;
}

const Calibration* Inspection::calibration() const {
  const auto gnss = first(LogKind::kGnss);
  if (!gnss || !logs[*gnss].calibration || !logs[*gnss].calibration->fits()) return nullptr;
  return &*logs[*gnss].calibration;
}

std::string InspectedDoubt::readings_text() const {
  std::vector<std::string> texts;
  texts.reserve(readings.size());
  for (const InspectedReading& reading : readings) {
    const double more = reading.ln_p - readings.front().ln_p;
    texts.push_back(&reading == &readings.front() ? fmt::format("`{}`", reading.keys)
                                                  : fmt::format("`{}` (ln p {:+.1f})", reading.keys, more));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

void rank(std::vector<Suspicion>& suspicions) {
  std::stable_sort(suspicions.begin(), suspicions.end(),
                   [](const Suspicion& a, const Suspicion& b) { return a.fault < b.fault; });
  std::vector<Suspicion> once;
  once.reserve(suspicions.size());
  for (Suspicion& s : suspicions) {
    const bool said = std::any_of(once.begin(), once.end(), [&](const Suspicion& o) {
      return o.fault == s.fault && o.file == s.file && (s.fault != LogFault::kBadRows || o.what == s.what);
    });
    if (!said) once.push_back(std::move(s));
  }
  suspicions = std::move(once);
}

ImuSensor guess_sensor(const ImuHealth& health, const std::string& name) {
  constexpr double kUsualGyro = 0.05 * kDegree, kUsualAccel = 300e-6 * kStandardGravity;
  constexpr double kGyroBias = 10, kAccelBias = 25;  // times the noise of a mean over a second
  constexpr double kScale = 0.03;                    // the sensitivity tolerance in data sheets of cheap sensors
  const auto seen = [](double value) { return std::isfinite(value) ? value : 0; };
  const double interval = health.sampling.interval;
  ImuSensor sensor;
  sensor.name = name;
  sensor.gyro =
      guess_triad(health.gyro, interval, kUsualGyro, kGyroBias, seen(health.gyro.mean.cwiseAbs().maxCoeff()), kScale);
  sensor.accel =
      guess_triad(health.accel, interval, kUsualAccel, kAccelBias, std::abs(health.force - kStandardGravity), kScale);
  return rounded(sensor, kDigits);
}

ImuSensor guess_sensor(const Inspection& inspection) {
  if (const Calibration* found = inspection.calibration()) {
    return with_errors_of_class(rounded(found->sensor, kDigits));
  }
  return with_errors_of_class(
      guess_sensor(*inspection.logs[*inspection.first(LogKind::kImu)].imu_health, "measured at rest"));
}

ImuConditioning guess_conditioning(const Inspection& inspection) {
  ImuConditioning imu;
  const LogMatch* match = inspection.first_match();
  if (const ReceiverClock* clock = inspection.imu_clock()) {
    // The configuration counts the drift from the IMU's first row.
    const double first = inspection.logs[*inspection.first(LogKind::kImu)].imu.time.front();
    imu.clock_offset = first - clock->gps_time(first);
    imu.clock_drift = clock->drift;
  } else if (match != nullptr && match->clock &&
             std::abs(match->clock->offset) > std::max(kKnownClock, 5 * match->clock->sigma))
    imu.clock_offset = match->clock->offset;
  // The filter's estimate replaces that of the match of the motions if it is more accurate. Clocks as logged, or as a
  // log states them, are no coincidence: another offset or drift has to gain ln 1 + 3 in likelihood over them.
  if (const Calibration* found = inspection.calibration()) {
    imu.instantaneous = found->instantaneous;
    const bool known = inspection.imu_clock() != nullptr;
    const bool matched = !known && imu.clock_offset != 0 && match != nullptr && match->clock;
    const auto gains = [](double change, double sigma) { return std::abs(change) > kGains * sigma; };
    const bool better = matched ? found->clock_sigma < std::max(kSureClock, match->clock->sigma)
                                : gains(found->clock_offset - imu.clock_offset, found->clock_sigma) ||
                                      (found->clock_drift_sigma > 0 &&
                                       gains(found->clock_drift - imu.clock_drift, found->clock_drift_sigma));
    if (better) {
      imu.clock_offset = found->clock_offset;
      imu.clock_drift = found->clock_drift;
    }
  }
  if (inspection.axes) {
    imu.R_bs = *inspection.axes;
    return imu;
  }
  if (match != nullptr && match->motion && !match->motion->mirrored) {
    imu.R_bs = match->motion->R_bs;
    return imu;
  }
  const auto first = inspection.first(LogKind::kImu);
  if (!first) return imu;
  // From gravity alone: the axis along gravity is down, the others follow in a right-handed order.
  Vector3d mean = inspection.logs[*first].imu_health->accel.mean;
  if (!mean.allFinite()) mean = mean_of(inspection.logs[*first].imu.accel);  // never stationary: mean force is gravity
  Eigen::Index axis = 0;
  mean.cwiseAbs().maxCoeff(&axis);
  Vector3d down = Vector3d::Zero(), forward = Vector3d::Zero();
  down(axis) = mean(axis) < 0 ? 1 : -1;  // at rest the specific force points up
  forward(axis == 0 ? 2 : 0) = 1;
  imu.R_bs.row(0) = forward;
  imu.R_bs.row(1) = down.cross(forward);
  imu.R_bs.row(2) = down;
  return imu;
}

Priors priors_after(const Calibration& found, Priors priors) {
  constexpr double kLeastArm = 0.1, kMostDelay = 0.05;  // m, s; an offset that is not written may be larger
  const double most = found.in_housing ? kHousing : kMostArm;
  priors.lever_arm = found.tells_arm() ? std::clamp(kLoose * found.lever_arm_sigma.maxCoeff(), kLeastArm, most) : most;
  priors.gnss_delay =
      std::clamp(kLoose * found.clock_sigma, kLeastDelay, std::max(kMostDelay, kGains * found.clock_sigma));
  if (found.clock_drift_sigma > 0) priors.clock_drift = kLoose * found.clock_drift_sigma;
  if (found.velocity_delay_sigma > 0)
    priors.velocity_delay = std::max(kLoose * found.velocity_delay_sigma, kLeastDelay);
  return priors;
}

std::optional<double> written_velocity_delay(const Inspection& inspection, const InspectedLog& receiver) {
  if (!receiver.left_out.empty()) return std::nullopt;
  const auto late = late_velocities(receiver, guess_conditioning(inspection).clock_offset);
  return late ? std::optional(late->delay) : std::nullopt;
}

namespace {

// Removes a finding about the clock that the filter refutes. The filter also estimates the antenna's place, which the
// comparison of turn rates neglects.
void drop_refuted_clocks(Inspection& inspection) {
  constexpr double kSure = 3;
  const LogMatch* match = inspection.first_match();
  const Calibration* found = inspection.calibration();
  if (match == nullptr || !match->clock || found == nullptr || match->clock_told) return;
  const double apart = std::abs(found->clock_offset - match->clock->offset);
  if (!(found->clock_sigma < kSureClock && apart > kSure * std::hypot(found->clock_sigma, match->clock->sigma))) return;
  const std::string& file = inspection.logs[*inspection.first(LogKind::kImu)].log.file;
  for (Suspicion& s : inspection.suspicions) {
    if (s.fault != LogFault::kClockOffset || s.file != file) continue;
    s.what = fmt::format(
        "the filter, which also estimates the antenna's place, finds the IMU's clock {:.3f} ± {:.3f} s {} "
        "the receiver's",
        std::abs(found->clock_offset), found->clock_sigma, found->clock_offset > 0 ? "ahead of" : "behind");
    s.remedy = "the configuration has it";
  }
  std::erase_if(inspection.suspicions, [&](const Suspicion& s) {
    return s.fault == LogFault::kClockOffset && s.file == file &&
           std::abs(found->clock_offset) < 5 * found->clock_sigma;
  });
}

}  // namespace

void advise_as_written(Inspection& inspection) {
  drop_refuted_clocks(inspection);
  const auto receiver_of = [&](const Suspicion& s) -> const InspectedLog* {
    const auto imu = inspection.first(LogKind::kImu), gnss = inspection.first(LogKind::kGnss);
    if (imu && gnss && inspection.logs[*imu].log.file == s.file) return &inspection.logs[*gnss];
    const auto place = std::ranges::find_if(inspection.logs, [&](const InspectedLog& log) {
      return log.log.file == s.file && log.is(LogKind::kGnss) && log.gnss_health;
    });
    return place == inspection.logs.end() ? nullptr : &*place;
  };
  for (Suspicion& s : inspection.suspicions) {
    if (s.fault != LogFault::kVelocityDelay) continue;
    const InspectedLog* receiver = receiver_of(s);
    if (receiver == nullptr || !receiver->left_out.empty()) continue;
    if (!uses_velocities(*receiver)) {
      s.remedy =
          "nothing: the configuration leaves the velocities out (`use: position`), as they contradict the positions";
      const auto& fit = receiver->gnss_health->velocity;
      if (const auto delay = fit ? fit->known_delay() : std::nullopt) {
        s.remedy += fmt::format("; to use them all the same, `use: position velocity` and `velocity_delay: {} s`",
                                with_decimals(*delay, 3));
      }
    } else if (const auto delay = written_velocity_delay(inspection, *receiver)) {
      s.remedy = fmt::format(
          "`velocity_delay: {} s` in its `gnss:` source says so, as the configuration does; replay "
          "estimates it from there",
          with_decimals(*delay, 3));
    }
  }
}

std::optional<std::string> ready_config(const Inspection& inspection, const std::string& folder,
                                        const std::string& sensor_file) {
  const auto first = inspection.first(LogKind::kImu);
  if (!first || !inspection.first(LogKind::kGnss)) return std::nullopt;
  const ImuConditioning imu = guess_conditioning(inspection);
  const LogMatch* match = inspection.first_match();
  const bool from_motion = match != nullptr && match->motion && !match->motion->mirrored;
  std::string text = fmt::format(
      "# Made by inspect from the logs alone. Measure what is marked so, and give the sensor file your data sheet.\n"
      "{}{}imu:\n  {}  sensor: {}\n  axes: {}                # {}\n  sampling: {}\n",
      doubt_text(inspection, "gyro"), doubt_text(inspection, "axes"), file_keys(inspection.logs[*first], folder, "  "),
      sensor_file, axes_text(imu.R_bs),
      inspection.axes ? "as a replay of the whole log has them"
      : from_motion   ? as_likely(*match->motion)
                      : "down as gravity has it; forward and right are to be checked",
      imu.instantaneous ? "instant             # likelier than means over the intervals"
                        : "mean                # or instant");
  const Calibration* found = inspection.calibration();
  const std::string steps = steps_text(inspection.logs[*first].log.clock_steps);
  const std::string behind = steps.empty() ? "" : ", " + steps;
  const bool clock_written = inspection.imu_clock() != nullptr || imu.clock_offset != 0;
  if (const ReceiverClock* clock = inspection.imu_clock()) {
    text += fmt::format(
        "  # From the receiver's own two times, +- {:.3f} s each{}.\n{}"
        "  clock: {{offset: {:.4f} s, drift: {} ppm{}}}\n",
        clock->scatter,
        found != nullptr ? fmt::format(", and the motion, +- {:.3f} s", found->clock_sigma)
                         : "; its latency, of some ms to hundreds of ms, is in it",
        found != nullptr ? "" : rest_of_clock(match), imu.clock_offset, with_decimals(1e6 * imu.clock_drift, 2),
        behind);
  } else if (imu.clock_offset != 0) {
    text += fmt::format(
        "  clock: {{offset: {} s{}{}}}    # as the motion has it, +- {:.4f} s\n", with_decimals(imu.clock_offset, 4),
        imu.clock_drift != 0 ? fmt::format(", drift: {} ppm", with_decimals(1e6 * imu.clock_drift, 2)) : "", behind,
        found != nullptr ? found->clock_sigma : match->clock->sigma);
  }
  if (!steps.empty() && !clock_written) {
    text += fmt::format("  clock: {{{}}}   # the clock was set under way\n", steps);
  }
  text += "gnss:\n";
  bool reference = false;
  LateSources late_sources;
  for (const InspectedLog& log : inspection.logs) {
    if (!log.is(LogKind::kGnss) || !log.gnss_health) continue;
    if (!log.left_out.empty()) {
      text += fmt::format("  # {} is left out: {}\n", log.log.file, log.left_out);
      continue;
    }
    text += fmt::format("  - {}", file_keys(log, folder, "    "));
    if (log.calibration && log.calibration->fits() && log.calibration->in_housing) {
      text +=
          "    lever_arm: 0 0 0 m            # most likely with the antenna in the IMU's housing, as in a phone; "
          "measure "
          "it "
          "otherwise\n";
    } else if (log.calibration && log.calibration->tells_arm()) {
      const Vector3d &arm = log.calibration->lever_arm, &sigma = log.calibration->lever_arm_sigma;
      text += fmt::format(
          "    lever_arm: {} {} {} m   # as the motion has it, +- {:.2f} {:.2f} {:.2f}; "
          "measure it: from the IMU to the antenna\n",
          with_decimals(arm.x(), 2), with_decimals(arm.y(), 2), with_decimals(arm.z(), 2), sigma.x(), sigma.y(),
          sigma.z());
    } else {
      text += fmt::format(
          "{}    lever_arm: 0 0 0 m            # measure it: from the IMU to the antenna, forward right down\n",
          log.calibration ? fmt::format("    # {}\n", log.calibration->why_no_arm()) : "");
    }
    if (log.log.sigma) {
      text += fmt::format("    sigma: {} {} {} m                # the log has none: usual of a {} receiver\n",
                          plain(log.log.sigma->x()), plain(log.log.sigma->y()), plain(log.log.sigma->z()),
                          class_of(log).name);
    }
    if (log.log.sigma_velocity) {
      text += fmt::format("    sigma_velocity: {} m/s         # {}\n", plain(log.log.sigma_velocity->x()),
                          log.coarse_velocity_sigma > 0
                              ? fmt::format("measured: the log states {} m/s for all", plain(log.coarse_velocity_sigma))
                              : "the log has none");
    }
    if (const auto late = late_velocities(log, imu.clock_offset)) {
      text += fmt::format("    velocity_delay: {} s       # as the motion has it, +- {:.3f}\n",
                          with_decimals(late->delay, 3), late->sigma);
      late_sources.velocity = std::max(late->prior, late_sources.velocity.value_or(0));
    }
    if (log.calibration && log.calibration->fits()) {
      if (const double averaging = log.calibration->velocity_averaging; averaging > 0 && uses_velocities(log)) {
        text +=
            fmt::format("    velocity_averaging: {} s   # they are means, as the motion has it\n", plain(averaging));
      }
      text += receiver_noise(*log.calibration, log);
      if (const auto& sway = log.calibration->sway) {
        text += fmt::format(
            "    lever_arm_sway: {{sigma: {} m, correlation_time: {} s}}   # the antenna moves on the body\n",
            plain(sway->sigma.x(), kDigits), plain(sway->correlation_time, kDigits));
      }
    } else if (log.log.sigma) {
      const ReceiverClass& usual = class_of(log);
      text += drift_text(PositionDrift::of_share(Vector3d::Constant(usual.share), kSlowTime),
                         fmt::format("usual of a {} receiver", usual.name));
      if (has_own_factors(log)) text += scales_of_qualities(log, 1);
    }
    text += doubt_text(inspection, "use");
    text += fmt::format("    use: position{}\n", uses_velocities(log) ? " velocity"
                                                 : log.gnss_health->velocities > 0
                                                     ? "                 # its velocities contradict them"
                                                     : "");
  }
  for (const InspectedLog& log : inspection.logs) {
    if (!log.is(LogKind::kAttitude) || !log.attitude_sampling) continue;
    if (!log.left_out.empty()) {
      text += fmt::format("# {} is left out: {}\n", log.log.file, log.left_out);
      continue;
    }
    text += fmt::format("{}  - {}    correlation_time: 60 s        # of its errors\n", reference ? "" : "attitude:\n",
                        file_keys(log, folder, "    "));
    if (const AttitudeMatch* matched = inspection.attitude_match(log)) {
      // The rates determine one offset for the whole run: the IMU's clock is taken at its middle.
      const double offset = imu.clock_offset + imu.clock_drift * (matched->imu.end - matched->imu.start) / 2;
      if (matched->is_late(offset)) {
        text += fmt::format("    {}             # as the motion has it, +- {}\n",
                            attitude_delay_text(*matched->fit, offset), time_text(matched->fit->sigma_offset));
        late_sources.attitude = late_prior(matched->fit->sigma_offset);
      }
    }
    if (log.log.sigma) {
      const Vector3d deg = kDegreesPerRadian * *log.log.sigma;
      text += fmt::format("    sigma: {} {} {} deg              # the log has none: roll pitch heading\n",
                          plain(deg.x()), plain(deg.y()), plain(deg.z()));
    }
    reference = true;
  }
  if (found != nullptr && inspection.vehicle.is_car()) {
    text += fmt::format(
        "# It moves as a car: {}.\n# Not a car? Take this key out. `contact: x y z m`, from the IMU to the middle "
        "between "
        "the rear wheels, makes it better.\nvehicle: {{kind: car, mounting: auto}}\n",
        inspection.vehicle.why());
  }
  // If the receiver's log states the clock, no delay of fixes is estimated: a phone's fixes are late by their own
  // filter.
  const bool delayed = found == nullptr || inspection.imu_clock() == nullptr;
  const bool drifts = delayed && found != nullptr && found->clock_drift_sigma > 0;
  text += fmt::format(
      "initial: {{{}\nestimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale, "
      "gyro_cross_axis, accel_cross_axis, gyro_g_sensitivity, lever_arm{}{}{}{}{}]\npriors: {}\nsmoother: rts\n",
      inspection.any_heading ? "heading: 0 deg, sigma: 104 deg}   # not known: any is as likely" : "heading: auto}",
      delayed ? ", gnss_delay" : "", drifts ? ", clock_drift" : "", late_sources.velocity ? ", velocity_delay" : "",
      late_sources.attitude ? ", attitude_delay" : "", reference ? ", boresight" : "",
      priors_text(found, late_sources, delayed, drifts));
  return text;
}

}  // namespace piste
