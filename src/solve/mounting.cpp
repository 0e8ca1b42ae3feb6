#include "piste/solve/mounting.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "condition/boresight.h"
#include "own_times.h"
#include "piste/math/units.h"
#include "stretch.h"

namespace piste {
namespace {

// Shortest and longest time [s] between two fixes whose attitudes are subtracted. Over 0.5 s, white noise of 0.1 deg in
// each fix is a rate of 0.3 deg/s.
constexpr double kStep = 0.5;
constexpr double kLongestTurn = 2;
constexpr double kLargestTurn = 2.5;     // rad in a step: near π the rotation vector is ambiguous
constexpr double kKnown = 10 * kDegree;  // largest 1-sigma of a result
constexpr std::size_t kFewestSteps = 10;

struct Turns {
  std::vector<Vector3d> rate_r, rate_b;
};

Turns turns(const Log& log, const std::vector<AttitudeFix>& fixes, const Vector3d& bias) {
  Turns turns;
  for (std::size_t i = 0, next = 1; next < fixes.size(); ++next) {
    const AttitudeFix &from = fixes[i], &to = fixes[next];
    const double lapse = to.time - from.time;
    if (lapse < kStep - 1e-6) continue;
    i = next;
    if (lapse > kLongestTurn) continue;
    const auto spoilt = [](const ImuSample& s) { return s.gap || s.clipped_gyro != 0; };
    const auto samples = range(log.imu, from.time, to.time + log.imu.front().interval);
    if (std::any_of(samples.begin(), samples.end(), spoilt)) continue;
    const Vector3d r = so3_log(from.q_wr.conjugate() * so3_exp(lapse * log.world.earth_rate()) * to.q_wr);
    const Vector3d b = so3_log(turned(log, from.time, to.time, bias));
    if (r.norm() > kLargestTurn || b.norm() > kLargestTurn) continue;
    turns.rate_r.emplace_back(r / lapse);
    turns.rate_b.emplace_back(b / lapse);
  }
  return turns;
}

}  // namespace

std::optional<Mounting> find_mounting(const Log& log, std::span<const AttitudeOptions> sources) {
  const auto source =
      std::find_if(log.attitude.begin(), log.attitude.end(), [](const auto& fixes) { return !fixes.empty(); });
  if (source == log.attitude.end()) return std::nullopt;
  const auto number = static_cast<std::size_t>(source - log.attitude.begin());
  const std::vector<AttitudeFix> fixes =
      at_own_times(*source, number < sources.size() ? sources[number] : AttitudeOptions{});
  Mounting mounting{Quaterniond::Identity(), Matrix3d::Zero(), Vector3d::Zero()};
  // Two passes: the rotations of the second are without the bias that the first has found.
  for (int pass = 0; pass < 2; ++pass) {
    const Turns t = turns(log, fixes, mounting.gyro_bias);
    if (t.rate_r.size() < kFewestSteps) return std::nullopt;
    const BoresightFromRates found = boresight_from_rates(t.rate_r, t.rate_b);
    if (!found.covariance.allFinite()) return std::nullopt;
    mounting.q_rb = found.q_rb;
    mounting.covariance = found.covariance;
    mounting.gyro_bias += found.gyro_bias;
  }
  const double variance = Eigen::SelfAdjointEigenSolver<Matrix3d>(mounting.covariance).eigenvalues()(2);
  if (!(variance < kKnown * kKnown)) return std::nullopt;
  return mounting;
}

}  // namespace piste
