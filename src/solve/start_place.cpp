#include "start_place.h"

#include <algorithm>
#include <iterator>

#include "own_times.h"
#include "piste/core/error.h"
#include "start_rest.h"
#include "stretch.h"

namespace piste {

Receiver first_receiver(const Log& log, const FilterOptions& options) {
  for (std::size_t i = 0; i < log.gnss.size(); ++i) {
    if (!log.gnss[i].empty()) return {at_own_times(log.gnss[i], options.gnss[i]), options.gnss[i]};
  }
  throw DataError("start", "no GNSS fix within the span of the IMU; check the clocks, the span and the outages");
}

Quaterniond carry_back(const Log& log, const Quaterniond& q_end, double begin, double end, const Vector3d& bias) {
  const Quaterniond earth = so3_exp((end - begin) * log.world.earth_rate());
  return (earth * q_end * turned(log, begin, end, bias).conjugate()).normalized();
}

Quaterniond levelled(const Quaterniond& q_wb, const Vector3d& down_b) {
  return (rotation_between(q_wb * down_b, Vector3d::UnitZ()) * q_wb).normalized();
}

namespace {

// Whether one body can have been at both fixes without being faster than it may be.
bool agree(const GnssFix& a, const GnssFix& b, bool still) {
  const double fastest = still ? 1 : 100;  // m/s
  return (b.position - a.position).norm() <
         fastest * (b.time - a.time) + 5 * (a.sigma_position + b.sigma_position).norm();
}

}  // namespace

void place(Start& start, const Receiver& receiver, bool still) {
  const auto& fixes = receiver.fixes;
  auto fix = first_at_or_after(fixes, start.time);
  if (fix == fixes.end()) fix = std::prev(fix);
  while (fixes.end() - fix > 2 && !agree(fix[0], fix[1], still) && agree(fix[1], fix[2], still)) ++fix;
  start.x.lever_arm = receiver.options.lever_arm;
  start.x.p_wb = fix->position - start.x.q_wb * receiver.options.lever_arm;
  start.x.v_wb.setZero();
  if (!still) {
    if (std::next(fix) != fixes.end()) {
      start.x.v_wb = (std::next(fix)->position - fix->position) / (std::next(fix)->time - fix->time);
    }
    if (fix->velocity) {
      start.x.v_wb.head<2>() = fix->velocity->value.head<2>();
      if (fix->velocity->has_down()) start.x.v_wb.z() = fix->velocity->value.z();
    }
    start.x.p_wb -= (fix->time - start.time) * start.x.v_wb;
  }
  const Vector3d sigma = (3 * fix->sigma_position).cwiseMax(1.0);
  start.covariance.topLeftCorner<6, 6>().setZero();
  start.covariance.diagonal().head<6>() << sigma.cwiseAbs2(), Vector3d::Constant(still ? 0.01 : 4.0);
}

void set_attitude_sigma(Start& start, const Vector3d& sigma) {
  start.covariance.bottomRightCorner<3, 3>() = sigma.cwiseAbs2().asDiagonal();
}

bool estimates(const FilterOptions& options, Block block) {
  return std::find(options.estimate.begin(), options.estimate.end(), block) != options.estimate.end();
}

void set_boresight(Start& start, const Log& log, const FilterOptions& options) {
  if (!estimates(options, Block::kBoresight)) return;
  for (std::size_t i = 0; i < log.attitude.size(); ++i) {
    const std::vector<AttitudeFix> fixes = at_own_times(log.attitude[i], options.attitude[i]);
    const auto fix = first_at_or_after(fixes, start.time);
    if (fix == fixes.end()) continue;
    const Quaterniond q_wb =
        start.x.q_wb * turned(log, start.time, fix->time, bias_before(log, options, fix->time).value);
    start.x.q_rb = (fix->q_wr.conjugate() * q_wb).normalized();
    return;
  }
}

}  // namespace piste
