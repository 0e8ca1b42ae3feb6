#include "filter/recent_motion.h"

namespace piste {
namespace {

// s. A shorter mean would contain the vibration of an engine, a longer one would miss the turns of a skier.
constexpr double kSmoothing = 0.1;
constexpr double kNoiseLeft = 1.25 / kSmoothing;

}  // namespace

void MotionMean::add(const ImuStep& step, const Quaterniond& q_wb) {
  const double part = step.dt / (kSmoothing + step.dt);
  const auto smooth = [&](Smoothed& s, const Vector3d& value) {
    if (!begun_) s.once = s.twice = value;
    s.once += part * (value - s.once);
    s.twice += part * (s.once - s.twice);
  };
  smooth(rate_, q_wb * step.mean_rate());
  smooth(force_, q_wb * step.mean_force());
  begun_ = true;
}

RecentMotion MotionMean::at(const Quaterniond& q_wb, const ImuSensor& sensor) const {
  const auto in_b = [&](const Vector3d& w) { return Vector3d(q_wb.conjugate() * w); };
  const auto now = [&](const Smoothed& s) { return in_b(2 * s.once - s.twice); };
  const auto change = [&](const Smoothed& s) { return in_b((s.once - s.twice) / kSmoothing); };
  const double accel = sensor.accel.noise, gyro = sensor.gyro.noise;
  return {.rate = now(rate_),
          .force = now(force_),
          .force_change = change(force_),
          .force_variance = kNoiseLeft * accel * accel,
          .rate_variance = kNoiseLeft * gyro * gyro};
}

}  // namespace piste
