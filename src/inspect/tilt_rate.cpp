#include "tilt_rate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "piste/math/so3.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kTiltStep = 0.25, kLongestTilt = 2;  // s: of the means that are compared, and a longer one spans a gap
constexpr std::size_t kFewestTilts = 40;              // steps

// The direction of the mean force over a step, and the turns from its middle to that of the next, with each factor.
struct TiltStep {
  Vector3d up = Vector3d::Zero();
  double middle = 0;
};

std::vector<TiltStep> tilt_steps(const ImuRecording& imu) {
  std::vector<TiltStep> steps;
  for (std::size_t begin = 0, end = 0; begin < imu.time.size(); begin = end) {
    Vector3d sum = Vector3d::Zero();
    double time = 0;
    while (end < imu.time.size() && imu.time[end] - imu.time[begin] < kTiltStep) {
      sum += imu.accel[end];
      time += imu.time[end];
      ++end;
    }
    steps.push_back({sum.normalized(), time / static_cast<double>(end - begin)});
  }
  return steps;
}

// Mean square of what the turns between neighbouring steps leave of the change of the direction.
double left_by(const ImuRecording& imu, const std::vector<TiltStep>& steps, double factor) {
  double squares = 0;
  std::size_t row = 0, count = 0;
  for (std::size_t k = 0; k + 1 < steps.size(); ++k) {
    const double from = steps[k].middle, to = steps[k + 1].middle;
    if (!(to > from && to - from < kLongestTilt)) continue;
    while (row < imu.time.size() && imu.time[row] <= from) ++row;
    Quaterniond turn = Quaterniond::Identity();
    double time = from;
    for (std::size_t i = row; i < imu.time.size() && time < to; ++i) {
      const double until = std::min(imu.time[i], to);
      turn = turn * so3_exp(factor * (until - time) * imu.gyro[i]);
      time = until;
    }
    const double off = (turn.conjugate() * steps[k].up - steps[k + 1].up).squaredNorm();
    if (!std::isfinite(off)) continue;
    squares += off;
    ++count;
  }
  return count < kFewestTilts ? std::numeric_limits<double>::quiet_NaN() : squares / static_cast<double>(count);
}

}  // namespace

std::optional<double> rate_factor_by_tilt(const ImuRecording& imu) {
  constexpr double kExplained = 0.5, kClearly = 0.5;  // of the squares without turns, and of those of the rivals
  if (imu.increments || imu.time.size() < kFewestTilts) return std::nullopt;
  const std::vector<TiltStep> steps = tilt_steps(imu);
  constexpr std::array<double, 3> kFactors{1, kDegree, kDegreesPerRadian};
  std::array<double, 3> left{};
  for (std::size_t i = 0; i < kFactors.size(); ++i) left[i] = left_by(imu, steps, kFactors[i]);
  const double still = left_by(imu, steps, 0);
  const auto* const best = std::min_element(left.begin(), left.end());
  if (!(*best < kExplained * still)) return std::nullopt;
  for (const double& other : left) {
    if (&other != best && !(*best < kClearly * other)) return std::nullopt;
  }
  return kFactors[static_cast<std::size_t>(best - left.begin())];
}

}  // namespace piste
