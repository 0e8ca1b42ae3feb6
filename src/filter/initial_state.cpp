#include "piste/filter/initial_state.h"

#include "model/imu_errors.h"
#include "piste/math/so3.h"

namespace piste {
namespace {

BlockValues initial_variance(const BlockInfo& row, const FilterOptions& options) {
  if (row.prior) return row.prior(options).cwiseAbs2();
  const std::optional<BlockProcess> process = row.process(options);
  if (!process) return BlockValues::Zero();
  const double sigma = initial_sigma(process->law);
  return blocks::of_axes(sigma * sigma * process->weight);
}

}  // namespace

void set_known(Estimate& x, const FilterOptions& options) {
  if (options.vehicle) {
    x.q_vb = options.vehicle->mounting.value_or(Quaterniond::Identity());
    x.vehicle_contact = options.vehicle->contact;
  }
  if (!options.gnss.empty()) {
    x.gnss_delay = options.gnss.front().delay;
    x.velocity_delay = options.gnss.front().delay_of_velocity();
  }
  if (!options.attitude.empty()) x.attitude_delay = options.attitude.front().delay;
}

Covariance initial_covariance(const StateLayout& layout, const FilterOptions& options, const Start& start) {
  if (start.covariance.rows() == layout.size()) return start.covariance;
  Covariance P = Covariance::Zero(layout.size(), layout.size());
  P.topLeftCorner<9, 9>() = start.covariance;
  for (const Block b : layout.blocks()) {
    if (is_navigation(b)) continue;
    const int size = info(b).size;
    P.diagonal().segment(layout.offset(b), size) = initial_variance(info(b), options).head(size);
  }
  // The IMU is at the antenna less the lever arm: ρ = (error of the antenna) − θ × C l − C (error of l).
  Covariance from_antenna = Covariance::Identity(layout.size(), layout.size());
  const Matrix3d C = start.x.R_wb();
  from_antenna.block<3, 3>(0, 6) = skew(C * start.x.lever_arm);
  if (const int lever_arm = layout.offset(Block::kLeverArm); lever_arm >= 0) {
    from_antenna.block<3, 3>(0, lever_arm) = -C;
  }
  P = (from_antenna * P * from_antenna.transpose()).eval();
  return 0.5 * (P + P.transpose());
}

}  // namespace piste
