// Causes that are constants: the filter itself finds them once they are states with a wide prior.

#include <fmt/format.h>

#include <algorithm>

#include "diagnosis/cause_support.h"
#include "math/words.h"
#include "piste/consistency/verdict.h"

namespace piste {
namespace {

// Priors of a tested constant, 1-sigma: wide enough for a configuration that is far off.
constexpr double kArm = 3, kLate = 0.5, kAttitudeLate = 0.3;  // m, s
constexpr double kLooser = 10;                                // times the configured prior
constexpr double kGyroScale = 0.05, kAccelScale = 0.05, kGyroBias = 0.05, kAccelBias = 0.5;  // at least; SI

std::string with_sigma(const Evidence& found, Block block) {
  const BlockInfo& row = info(block);
  const BlockValues value = row.factor * shown_value(found.last, block);
  const double sigma = row.factor * found.sigmas.segment(full_offset(block), row.size).maxCoeff();
  std::string text;
  for (int axis = 0; axis < row.size; ++axis) text += rounded(value(axis), sigma) + " ";
  return fmt::format("{}± {} {}", text, rounded(sigma, sigma), row.unit);
}

// Whether the configured value and prior are consistent with the estimate. Then they are no cause.
bool allows(const FilterOptions& options, Block block, const Evidence& found) {
  constexpr double kLikely = 2;  // 1-sigmas of the prior
  const BlockInfo& row = info(block);
  if (!options.estimates(block) || row.prior == nullptr) return false;
  const BlockValues change = (shown_value(found.last, block) - stated_value(options, block)).cwiseAbs(),
                    prior = row.prior(options);
  return (change.head(row.size).array() < kLikely * prior.head(row.size).array()).all();
}

// A delay that no receiver has is an offset of the clocks.
std::string described(const std::string& name, Block block, const FilterOptions& options, const Evidence& found) {
  constexpr double kLatest = 0.5;  // s
  const double later = shown_value(found.last, block).x() - stated_value(options, block).x();
  if (block == Block::kGnssDelay && std::abs(later) > kLatest) {
    return fmt::format("offset of the IMU's clock ({:+.3f} s more than the file's), or delay of the fixes", -later);
  }
  return fmt::format("{} ({} is likelier)", name, with_sigma(found, block));
}

// Whether a triad may have such scales. Data sheets of MEMS sensors allow 1 to 10 % (ADXL345: 10 %).
bool is_scale(const Vector3d& scales) {
  constexpr double kMost = 0.1;
  return scales.cwiseAbs().maxCoeff() <= kMost;
}

// A configuration that states the constant as it was found, or where it states none, a prior that allows it; nothing
// where that would be a scale that no sensor has.
Change stating(Block block, const Evidence& found) {
  const Estimate x = found.last;
  if ((block == Block::kGyroScale && !is_scale(x.gyro_scale)) ||
      (block == Block::kAccelScale && !is_scale(x.accel_scale)))
    return {};
  return [block, x](StatedModel& m) {
    GnssOptions* const receiver = m.options.gnss.empty() ? nullptr : &m.options.gnss.front();
    const auto allow = [&](double& sigma, const Vector3d& value) {
      sigma = std::max(sigma, value.cwiseAbs().maxCoeff());
    };
    switch (block) {
      case Block::kGnssDelay:
        m.clock_offset -= x.gnss_delay - receiver->delay;
        break;
      case Block::kVelocityDelay:
        receiver->velocity_delay = x.velocity_delay;
        break;
      case Block::kAttitudeDelay:
        m.options.attitude.front().delay = x.attitude_delay;
        break;
      case Block::kLeverArm:
        receiver->lever_arm = x.lever_arm;
        break;
      case Block::kGyroBias:
        allow(m.options.sensor.gyro.bias, x.gyro_bias);
        break;
      case Block::kAccelBias:
        allow(m.options.sensor.accel.bias, x.accel_bias);
        break;
      case Block::kGyroScale:
        allow(m.options.sensor.gyro.scale, x.gyro_scale);
        break;
      case Block::kAccelScale:
        allow(m.options.sensor.accel.scale, x.accel_scale);
        break;
      default:
        break;
    }
  };
}

template <class Widen>
Cause constant(Block block, const std::string& name, Widen&& widen) {
  return [=](const FilterInput& input, const Evidence& base, double end) {
    FilterOptions options = input.options;
    want(options, block);
    widen(options, input.options.estimates(block));
    const Evidence found = filter_again(input.log, options, input.start, end);
    if (allows(input.options, block, found)) return TestedCause{};
    const bool soon_found = block == Block::kGyroBias || block == Block::kAccelBias;
    const double gain = soon_found ? gained(found, base) : lasting_gain(found, base);
    return TestedCause{gain, described(name, block, input.options, found), stating(block, found)};
  };
}

// A prior of the options, widened.
Cause loose(Block block, const std::string& name, double Priors::*prior, double least) {
  return constant(block, name, [=](FilterOptions& options, bool estimated) {
    double& sigma = options.priors.*prior;
    sigma = std::max(least, estimated ? kLooser * sigma : 0);
  });
}

Cause loose_imu(Block block, const std::string& name, TriadErrors ImuSensor::*triad, double TriadErrors::*error,
                double least) {
  return constant(block, name, [=](FilterOptions& options, bool) {
    double& sigma = (options.sensor.*triad).*error;
    sigma = std::max(least, kLooser * sigma);
  });
}

Cause free_arm() { return loose(Block::kLeverArm, "lever arm", &Priors::lever_arm, kArm); }

// A lever arm longer than any that is carried, as with a wrong unit: it is tested as if none were configured.
Cause no_arm(const InitialHeading& heading) {
  return [heading](const FilterInput& input, const Evidence& base, double end) {
    FilterInput changed = input;
    changed.options.gnss.front().lever_arm.setZero();
    if (!start_anew(changed, heading)) return TestedCause{};
    return free_arm()(changed, base, end);
  };
}

}  // namespace

std::vector<Cause> constant_causes(const FilterInput& input, const InitialHeading& heading) {
  std::vector<Cause> causes;
  const FilterOptions& options = input.options;
  if (some_positions(options)) {
    causes.push_back(
        loose(Block::kGnssDelay, "delay of the fixes, or offset of the clock", &Priors::gnss_delay, kWideClock));
    if (has_velocities(input, 0))
      causes.push_back(loose(Block::kVelocityDelay, "delay of the velocities", &Priors::velocity_delay, kLate));
  }
  if (!options.attitude.empty())
    causes.push_back(loose(Block::kAttitudeDelay, "delay of the attitude", &Priors::attitude_delay, kAttitudeLate));
  if (options.gnss.size() == 1)
    causes.push_back(options.gnss.front().lever_arm.norm() > kArm ? no_arm(heading) : free_arm());
  causes.push_back(loose_imu(Block::kGyroBias, "gyroscope bias", &ImuSensor::gyro, &TriadErrors::bias, kGyroBias));
  causes.push_back(
      loose_imu(Block::kAccelBias, "accelerometer bias", &ImuSensor::accel, &TriadErrors::bias, kAccelBias));
  causes.push_back(loose_imu(Block::kGyroScale, "gyroscope scale", &ImuSensor::gyro, &TriadErrors::scale, kGyroScale));
  causes.push_back(
      loose_imu(Block::kAccelScale, "accelerometer scale", &ImuSensor::accel, &TriadErrors::scale, kAccelScale));
  return causes;
}

}  // namespace piste
