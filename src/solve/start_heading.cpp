#include "start_heading.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "own_times.h"
#include "piste/core/error.h"
#include "piste/core/time_search.h"
#include "piste/model/alignment.h"
#include "piste/model/magnetometer.h"
#include "piste/solve/mounting.h"

namespace piste {
namespace {

constexpr double kReferenceSigma =
    5 * kDegree;                     // of a heading from the reference attitude: loose, as the filter uses it again
constexpr double kFirstSeconds = 3;  // s of motion that give roll and pitch

// Throws if gravity contradicts the attitude `q_wb`.
void check_small_boresight(const Quaterniond& q_wb, const Rest& rest, const Priors& priors) {
  const Vector3d down = q_wb * -rest.mean_force;
  const double tilt = std::atan2(down.head<2>().norm(), down.z());
  if (tilt <= 3 * std::numbers::sqrt2 * priors.boresight) return;
  throw DataError("start",
                  fmt::format("the boresight cannot be found: the body does not turn about two axes, and gravity says "
                              "that it sits some {:.0f} deg off the reference; add a stretch of motion, or bring both "
                              "nearly together by `axes`",
                              tilt / kDegree));
}

}  // namespace

Pointing point_by_reference(const Log& log, const FilterOptions& options, const Start& start,
                            const std::optional<Rest>& rest) {
  const auto source = std::find_if(log.attitude.begin(), log.attitude.end(), [](const auto& a) { return !a.empty(); });
  if (source == log.attitude.end())
    throw DataError("start", "from_attitude needs an attitude log that overlaps the IMU");
  const auto number = static_cast<std::size_t>(source - log.attitude.begin());
  const std::vector<AttitudeFix> fixes = at_own_times(*source, options.attitude[number]);
  const auto next = std::find_if(fixes.begin(), fixes.end(), [&](const auto& f) { return f.time >= start.time; });
  const AttitudeFix& fix = next == fixes.end() ? fixes.back() : *next;
  GyroBias bias = bias_before(log, options, fix.time);
  Pointing p{Quaterniond::Identity(), kReferenceSigma, "heading from the reference attitude"};
  if (estimates(options, Block::kBoresight)) {
    if (const auto mounting = find_mounting(log, options.attitude)) {
      const Vector3d down_r = fix.q_wr.conjugate() * Vector3d::UnitZ();
      p.q_wb = mounting->q_rb;
      p.sigma = std::hypot(p.sigma, 2 * std::sqrt(down_r.dot(mounting->covariance * down_r)));
      p.how += ", through the boresight that the rates of both tell";
      bias.value = mounting->gyro_bias;
    } else {
      // The boresight is taken to be small, as its prior says. The heading is as uncertain as that.
      p.sigma = 3 * options.priors.boresight;
      p.how += ", the boresight taken for small";
    }
  }
  const double lapse = std::max(0.0, fix.time - start.time);
  p.q_wb = carry_back(log, fix.q_wr * p.q_wb, fix.time - lapse, fix.time, bias.value);
  p.sigma = std::hypot(p.sigma, lapse * bias.sigma);
  if (!rest) return p;
  if (p.sigma >= 3 * options.priors.boresight) check_small_boresight(p.q_wb, *rest, options.priors);
  p.q_wb = levelled(p.q_wb, -rest->mean_force);
  return p;
}

Pointing point_by_heading(const Log& log, const FilterOptions& options, const Receiver& receiver, const Start& start,
                          const InitialHeading& heading, const std::optional<Rest>& rest) {
  const Vector3d force = rest ? rest->mean_force : average(log, {start.time, start.time + 1}).mean_force;
  double value = heading.value;
  Pointing p{Quaterniond::Identity(), heading.sigma, "heading from the configuration"};
  if (heading.source == InitialHeading::Source::kMagnetometer) {
    if (log.magnetic.empty())
      throw DataError("start", "from_magnetometer needs the columns mag_x_uT, mag_y_uT, mag_z_uT in the IMU log");
    value = options.declination - magnetic_azimuth(level(force, 0), log.magnetic.front().field);
    p.sigma =
        std::hypot(heading.sigma, 2 * kTiltSigma);  // at a dip of 60 deg a tilt turns the azimuth by twice as much
    p.how = "heading from the magnetometer";
  }
  p.q_wb = level(force, value);
  if (rest) return p;
  // On the move: roll and pitch from an alignment in the first seconds, the heading as given.
  const auto window = range(receiver.fixes, start.time, start.time + kFirstSeconds);
  const auto moving =
      align_in_motion(range(log.imu, start.time, start.time + kFirstSeconds + 1), window, receiver.options,
                      bias_before(log, options, start.time), log.world.gravity(receiver.fixes.front().position).value);
  if (moving) {
    const Vector3d euler = to_euler(moving->q_wb);
    p.q_wb = from_euler({euler.x(), euler.y(), value});
  }
  return p;
}

}  // namespace piste
