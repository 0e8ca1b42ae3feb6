#include "tune/white_noise_range.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace piste {
namespace {

// Squares of the differences between adjacent means over some time, of samples at rest or under way.
struct AdjacentMeans {
  double gyro = 0, accel = 0;  // times the time, halved: sums over three axes
  int pairs = 0;

  // That which would make the Allan deviation alone.
  WhiteNoise white_noise() const { return {std::sqrt(gyro / (3 * pairs)), std::sqrt(accel / (3 * pairs))}; }
};

AdjacentMeans adjacent_means(const Log& log, double time, bool at_rest) {
  struct Mean {
    Vector3d rate, force;
  };
  AdjacentMeans sums;
  std::optional<Mean> before;
  Vector3d turned = Vector3d::Zero(), pushed = Vector3d::Zero();
  double duration = 0;
  for (const ImuSample& sample : log.imu) {
    if (sample.at_rest != at_rest || sample.gap) {
      before.reset();
      turned = pushed = Vector3d::Zero();
      duration = 0;
      continue;
    }
    turned += sample.dtheta;
    pushed += sample.dvel;
    duration += sample.interval;
    if (duration < time * (1 - 1e-6)) continue;
    const Mean now{turned / duration, pushed / duration};
    if (before) {
      sums.gyro += (now.rate - before->rate).squaredNorm() * duration / 2;
      sums.accel += (now.force - before->force).squaredNorm() * duration / 2;
      ++sums.pairs;
    }
    before = now;
    turned = pushed = Vector3d::Zero();
    duration = 0;
  }
  return sums;
}

}  // namespace

WhiteNoiseRange white_noise_range(const Log& log) {
  constexpr double kUnderWay = 0.1;  // s
  constexpr std::array kStill{0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0};
  constexpr int kFewest = 30;
  constexpr double kBoundless = std::numeric_limits<double>::infinity();
  WhiteNoiseRange range{.most = {kBoundless, kBoundless}};
  if (const AdjacentMeans moving = adjacent_means(log, kUnderWay, false); moving.pairs >= kFewest)
    range.most = moving.white_noise();
  WhiteNoise least = range.most;
  bool measured = false;
  for (const double time : kStill) {
    const AdjacentMeans still = adjacent_means(log, time, true);
    if (still.pairs < kFewest) break;
    // Two neighbours share a mean, so that some two thirds of the differences count; three axes; 1 % of a normal.
    const double chance = 2.33 / std::sqrt(2 * 3 * still.pairs * 2 / 3.0);
    least.gyro = std::min(least.gyro, still.white_noise().gyro / (1 + chance));
    least.accel = std::min(least.accel, still.white_noise().accel / (1 + chance));
    measured = true;
  }
  if (measured) range.least = least;
  return range;
}

}  // namespace piste
