#include "piste/model/vehicle.h"

#include "model/imu_error_model.h"

namespace piste {
namespace {

using Row = Eigen::RowVector3d;

void add_row(Linearization& lin, Block block, const Row& row) {
  Matrix3d J = Matrix3d::Zero();
  J.row(0) = row;
  lin.add(block, J);
}

WheelMotion motion_of(const MeasurementContext& context, const Estimate& x) {
  const BodyMotion mean = context.mean_motion(x);
  const RecentMotion& recent = context.recent;
  return {mean.rate,
          beyond_noise(mean.rate, recent.rate_variance),
          mean.force,
          recent.rate_variance,
          recent.force_variance,
          context.earth_rate};
}

}  // namespace

Linearization linearize_wheel(VehicleAxis axis, const Estimate& x, const WheelMotion& motion) {
  const int k = static_cast<int>(axis);
  const Matrix3d R_bw = x.R_wb().transpose(), R_vb = x.q_vb.toRotationMatrix();
  const Vector3d& l = x.vehicle_contact;
  const Vector3d earth_b = R_bw * motion.earth_rate, rate = motion.rate - earth_b,
                 reference = motion.reference_rate - earth_b;
  const Vector3d u = R_vb * (R_bw * x.v_wb + rate.cross(l)), turn = R_vb * rate, force = R_vb * motion.force;

  // The velocity changes by `by_u` with u, and by `by_turn` with the rate in v.
  Row by_u = Row::Unit(k), by_turn = Row::Zero();
  double velocity = u(k);
  if (axis == VehicleAxis::kRight) {
    const double square = u.x() * u.x();
    velocity += x.cornering * square * turn.z() + x.side_slip;
    by_u.x() += 2 * x.cornering * u.x() * turn.z();
    by_turn.z() = x.cornering * square;
  }
  if (axis == VehicleAxis::kForward) velocity += x.wheel_slip;
  Row by_force = Row::Zero();
  if (axis == VehicleAxis::kDown) {
    const double pitch = x.dive * force.x() + x.spring_pitch;
    velocity -= turn.y() * x.pitch_centre + pitch * u.x();
    by_u.x() = -pitch;
    by_turn.y() = -x.pitch_centre;
    by_force.x() = -x.dive * u.x();
  }
  const Row by_rate = by_turn * R_vb - by_u * R_vb * skew(l);

  Linearization lin;
  lin.rows = 1;
  lin.observes = Block::kVelocity;
  lin.residual.x() = -velocity;
  lin.covariance(0, 0) = by_rate.squaredNorm() * motion.rate_variance + by_force.squaredNorm() * motion.force_variance;
  add_row(lin, Block::kVelocity, by_u * R_vb * R_bw);
  add_row(lin, Block::kAttitude, -by_rate * R_bw * skew(motion.earth_rate));
  MotionPart part{Matrix3d::Zero(), Matrix3d::Zero(), {.rate = motion.reference_rate, .force = motion.force}};
  part.by_rate.row(0) = by_rate;
  part.by_force.row(0) = by_force * R_vb;
  add_imu_errors(lin, x, {&part, 1});
  add_row(lin, Block::kVehicleMounting, -by_u * skew(u) - by_turn * skew(turn) - by_force * skew(force));
  add_row(lin, Block::kVehicleContact, by_u * R_vb * skew(reference));
  if (axis == VehicleAxis::kForward) add_row(lin, Block::kWheelSlip, Row::UnitX());
  if (axis == VehicleAxis::kRight) {
    add_row(lin, Block::kSideSlip, Row::UnitX());
    add_row(lin, Block::kCornering, Row(u.x() * u.x() * (R_vb * reference).z(), 0, 0));
  }
  if (axis == VehicleAxis::kDown) {
    add_row(lin, Block::kPitchCentre, Row(-(R_vb * reference).y(), 0, 0));
    add_row(lin, Block::kDive, Row(-force.x() * u.x(), 0, 0));
    add_row(lin, Block::kSpringPitch, Row(-u.x(), 0, 0));
  }
  return lin;
}

std::optional<Linearization> VehicleConstraint::linearize(const VehicleFix&, int, int channel,
                                                          const MeasurementContext& context, const Estimate& x) {
  if (context.still) return std::nullopt;
  const VehicleOptions& vehicle = *context.options.vehicle;
  const VehicleAxis axis = channel == 0 ? VehicleAxis::kRight : VehicleAxis::kDown;
  const int k = static_cast<int>(axis);
  Linearization lin = linearize_wheel(axis, x, motion_of(context, x));
  const double white = vehicle.white(k), by_speed = vehicle.white_by_speed(k);
  lin.covariance(0, 0) += white * white + by_speed * by_speed * x.v_wb.squaredNorm();
  return lin;
}

std::optional<Linearization> Odometer::linearize(const SpeedFix& fix, int, int, const MeasurementContext& context,
                                                 const Estimate& x) {
  Linearization lin = linearize_wheel(VehicleAxis::kForward, x, motion_of(context, x));
  const double forward = -lin.residual.x();
  const auto direction = [&] {
    if (!context.side) return forward;
    return -linearize_wheel(VehicleAxis::kForward, *context.side, motion_of(context, *context.side)).residual.x();
  };
  const double sign = !context.options.odometer->is_signed && direction() < 0 ? -1 : 1;
  const double factor = sign * (1 + x.odometer_scale);
  Matrix3d scaled = Matrix3d::Zero();
  scaled(0, 0) = factor;
  lin.turn(scaled);
  lin.residual.x() += fix.speed;
  lin.covariance(0, 0) += fix.sigma * fix.sigma;
  add_row(lin, Block::kOdometerScale, Row(sign * forward, 0, 0));
  return lin;
}

}  // namespace piste
