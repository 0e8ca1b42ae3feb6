#include "motion_windows.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/time.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr std::size_t kMost = 40;        // windows
constexpr std::size_t kMostClipped = 2;  // rows of a window
constexpr double kLeastChange = 0.7;     // m/s: least rms of the velocity's change in a window

}  // namespace

std::optional<MotionWindow> MotionSource::window(double begin, double offset) const {
  const auto cells = static_cast<std::size_t>(std::lround(kWindow / kCell));
  const double first = begin + offset, last = first + kWindow;
  if (!imu.covers(first, last) || imu.clipped(first, last) > kMostClipped) return std::nullopt;
  MotionWindow w;
  w.begin = begin;
  ImuIntegral::Value before = imu.at(first);
  Vector3d mean = Vector3d::Zero();
  for (std::size_t i = 0; i <= cells; ++i) {
    const double t = begin + static_cast<double>(i) * kCell;
    if (i > 0) {
      const ImuIntegral::Value now = imu.at(t + offset);
      w.cells.push_back({now.angle - before.angle - kCell * bias, now.velocity - before.velocity});
      before = now;
    }
    if (i % kEvery != 0) continue;
    const auto v = track.velocity(t);
    if (!v) return std::nullopt;
    w.velocity.push_back(*v);
    mean += *v;
  }
  mean /= static_cast<double>(w.velocity.size());
  for (const Vector3d& v : w.velocity) w.change += (v - mean).squaredNorm();
  w.change = std::sqrt(w.change / static_cast<double>(w.velocity.size()));
  if (w.change < kLeastChange) return std::nullopt;
  return w;
}

std::vector<MotionWindow> MotionSource::windows(double offset) const {
  constexpr double kLooks = 4000;
  const double begin = std::max(track.start(), imu.start() - offset), end = std::min(track.end(), imu.end() - offset);
  const double stride = std::max(kStride, (end - begin) / kLooks);
  std::vector<MotionWindow> all;
  for (double t = begin; t + kWindow < end; t += stride) {
    if (auto w = window(t, offset)) all.push_back(std::move(*w));
  }
  if (all.size() <= kMost) return all;
  std::vector<MotionWindow> some;  // spread over the log
  some.reserve(kMost);
  for (std::size_t i = 0; i < kMost; ++i) some.push_back(std::move(all[i * all.size() / kMost]));
  return some;
}

Vector3d gyro_bias(const ImuIntegral& imu, const std::vector<Interval>& rest, double offset) {
  Vector3d angle = Vector3d::Zero();
  double time = 0;
  for (const Interval& r : rest) {
    const double begin = r.start + offset, end = r.end + offset;
    if (!imu.covers(begin, end)) continue;
    angle += imu.at(end).angle - imu.at(begin).angle;
    time += end - begin;
  }
  if (time > 5) return angle / time;
  std::vector<Vector3d> rates;
  // Pieces of 1 s, spread over the log: at most as many as a day has seconds.
  const double stride = std::max(1.0, (imu.end() - imu.start()) / kDay);
  for (double t = imu.start(); t + 1 < imu.end(); t += stride) {
    rates.emplace_back(imu.at(t + 1).angle - imu.at(t).angle);
  }
  return rates.empty() ? Vector3d::Zero() : median_by_axis(rates);
}

}  // namespace piste
