#include "evaluate/path.h"

#include <algorithm>
#include <cmath>

namespace piste {

FramedRow FramedPath::row(std::size_t i) const {
  FramedRow row;
  row.time = time(i);
  if (track_.geodetic) {
    row.position = frame_->place(track_.place[i]);
    row.local = frame_->local(track_.place[i]);
  } else {
    row.position = track_.position[i];
  }
  // Velocities and attitudes on the Earth are against the local level.
  const Matrix3d R = track_.geodetic ? row.local : Matrix3d::Identity();
  if (has_velocity()) row.velocity = R * track_.velocity[i];
  if (has_attitude()) row.attitude = Quaterniond(R) * track_.attitude[i];
  if (!track_.sigma_position.empty()) row.sigma_position = track_.sigma_position[i];
  if (!track_.sigma_velocity.empty()) row.sigma_velocity = track_.sigma_velocity[i];
  if (!track_.sigma_euler.empty()) row.sigma_euler = track_.sigma_euler[i];
  if (!track_.covariance.empty()) row.covariance = track_.covariance[i];
  return row;
}

FramedRow FramedPath::between(std::size_t i, double time) const {
  const FramedRow a = row(i), b = row(i + 1);
  const double dt = b.time - a.time, u = (time - a.time) / dt;
  const auto linear = [u](const auto& from, const auto& to) { return (from + u * (to - from)).eval(); };
  FramedRow row = a;
  row.time = time;
  row.position = linear(a.position, b.position);
  if (has_velocity()) {  // Hermite's cubic
    const double v = 1 - u;
    row.position +=
        u * v * (v * (dt * a.velocity - (b.position - a.position)) - u * (dt * b.velocity - (b.position - a.position)));
    row.velocity = linear(a.velocity, b.velocity);
  }
  if (has_attitude()) row.attitude = a.attitude.slerp(u, b.attitude);
  if (u > 0.5) row.local = b.local;  // within a second the level does not turn
  row.sigma_position = linear(a.sigma_position, b.sigma_position);
  row.sigma_velocity = linear(a.sigma_velocity, b.sigma_velocity);
  row.sigma_euler = linear(a.sigma_euler, b.sigma_euler);
  row.covariance = linear(a.covariance, b.covariance);
  return row;
}

std::optional<FramedRow> FramedPath::at(double time) const {
  const auto& times = track_.time;
  const auto after =
      static_cast<std::size_t>(std::lower_bound(times.begin(), times.end(), time - shift_) - times.begin());
  for (const std::size_t i : {after, after - 1}) {
    if (i < size() && std::abs(this->time(i) - time) <= kSameTime) return row(i);
  }
  if (after == 0 || after >= size()) return std::nullopt;
  if (times[after] - times[after - 1] > kLongestInterpolation + kSameTime) return std::nullopt;
  return between(after - 1, time);
}

}  // namespace piste
