#include "start/start_heading.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "core/time_search.h"
#include "model/alignment.h"
#include "piste/core/error.h"
#include "piste/model/magnetometer.h"
#include "start/mounting.h"
#include "walker/own_times.h"

namespace piste {
namespace {

// Throws if gravity contradicts the attitude `q_nb`.
void check_small_boresight(const Quaterniond& q_nb, const Rest& rest, const Priors& priors) {
  const Vector3d down = q_nb * -rest.mean_force;
  const double tilt = std::atan2(down.head<2>().norm(), down.z());
  if (tilt <= 3 * std::numbers::sqrt2 * priors.boresight) return;
  throw DataError("start",
                  fmt::format("the boresight cannot be found: the body does not turn about two axes, and gravity says "
                              "that it sits some {:.0f} deg off the reference; add a stretch of motion, or bring both "
                              "nearly together by `axes`",
                              tilt / kDegree));
}

// Throws if the observed field is zero, or if its dip differs from that of the Earth. `shown`: the field, levelled,
// with any azimuth. That azimuth would otherwise pass for the heading.
void check_dip(const MagneticSample& sample, const Vector3d& shown) {
  // Iron of a carrier, 30 uT, changes the dip by asin(30 uT / field) at most. That is below 45 deg only if the field is
  // above 42 uT. In weaker fields, down to 22 uT, the test may reject a right magnetometer near much iron.
  constexpr double kIron = 45 * kDegree;
  constexpr std::string_view kInstead = "or find the heading by `auto`, or state it";
  if (shown.isZero()) {
    throw DataError("start", fmt::format("from_magnetometer: the field at {:.3f} s is zero; does the magnetometer "
                                         "work? Check its columns, {}",
                                         sample.time, kInstead));
  }
  const auto dip = [](const Vector3d& field) { return std::atan2(field.z(), field.head<2>().norm()); };
  if (std::abs(dip(shown) - dip(sample.earth)) <= kIron) return;
  throw DataError("start", fmt::format("from_magnetometer: the field at {:.3f} s dips by {:.0f} deg, that of the Earth "
                                       "by {:.0f} deg; check the axes of the magnetometer and the iron near by, {}",
                                       sample.time, dip(shown) / kDegree, dip(sample.earth) / kDegree, kInstead));
}

}  // namespace

Pointing point_by_reference(const Log& log, const FilterOptions& options, const Receiver& receiver, const Start& start,
                            const std::optional<Rest>& rest) {
  const Quaterniond q_wn = local_level(log.world, receiver, start.time);
  const auto source = std::find_if(log.attitude.begin(), log.attitude.end(), [](const auto& a) { return !a.empty(); });
  if (source == log.attitude.end())
    throw DataError("start", "from_attitude needs an attitude log that overlaps the IMU");
  const auto number = static_cast<std::size_t>(source - log.attitude.begin());
  const std::vector<AttitudeFix> fixes = at_own_times(*source, options.attitude[number]);
  const auto next = std::find_if(fixes.begin(), fixes.end(), [&](const auto& f) { return f.time >= start.time; });
  const AttitudeFix& fix = next == fixes.end() ? fixes.back() : *next;
  GyroBias bias = bias_before(log, options, fix.time);
  Pointing p{Quaterniond::Identity(), options.behaviour.start.reference_sigma,
             "heading at the start from the reference attitude"};
  if (options.estimates(Block::kBoresight)) {
    if (const auto mounting = find_mounting(log, options.attitude)) {
      const Vector3d down_r = fix.q_wr.conjugate() * (q_wn * Vector3d::UnitZ());
      p.q_wb = mounting->q_rb;
      p.sigma = std::hypot(p.sigma, 2 * std::sqrt(down_r.dot(mounting->covariance * down_r)));
      p.how += ", through the boresight from the rates of both";
      bias.value = mounting->gyro_bias;
    } else {
      // The boresight is taken to be small, as its prior states. The heading is as uncertain as the boresight.
      p.sigma = 3 * options.priors.boresight;
      p.how += ", the boresight taken for small";
    }
  }
  const double lapse = std::max(0.0, fix.time - start.time);
  p.q_wb = carry_back(log, fix.q_wr * p.q_wb, fix.time - lapse, fix.time, bias.value);
  p.sigma = std::hypot(p.sigma, lapse * bias.sigma);
  if (!rest) return p;
  const Quaterniond q_nb = q_wn.conjugate() * p.q_wb;
  if (p.sigma >= 3 * options.priors.boresight) check_small_boresight(q_nb, *rest, options.priors);
  p.q_wb = q_wn * levelled(q_nb, -rest->mean_force);
  return p;
}

Pointing point_by_heading(const Log& log, const FilterOptions& options, const Receiver& receiver, const Start& start,
                          const InitialHeading& heading, const std::optional<Rest>& rest) {
  const Quaterniond q_wn = local_level(log.world, receiver, start.time);
  const auto levelled_to = [&](double value) {
    return rest ? (q_wn * level(rest->mean_force, value)).normalized()
                : start_on_the_move(log, options, receiver, start.time, value, heading.sigma).x.q_wb;
  };
  if (heading.source == InitialHeading::Source::kValue)
    return {levelled_to(heading.value), heading.sigma, "heading at the start from the configuration"};
  if (log.magnetic.empty())
    throw DataError("start", "from_magnetometer needs the columns mag_x_uT, mag_y_uT, mag_z_uT in the IMU log");
  const auto field = first_at_or_after(log.magnetic, start.time);
  const MagneticSample& magnetic = field == log.magnetic.end() ? log.magnetic.back() : *field;
  const Vector3d shown = q_wn.conjugate() * (levelled_to(0) * magnetic.field);
  check_dip(magnetic, shown);
  // At a dip of 60 deg, a tilt changes the azimuth by twice its size.
  return {levelled_to(azimuth(magnetic.earth) - azimuth(shown)),
          std::hypot(heading.sigma, 2 * options.behaviour.start.tilt_sigma),
          "heading at the start from the magnetometer"};
}

}  // namespace piste
