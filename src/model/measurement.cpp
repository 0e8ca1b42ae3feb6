#include "piste/model/measurement.h"

namespace piste {

Jacobian assemble(const StateLayout& layout, const Linearization& lin) {
  Jacobian H = Jacobian::Zero(3, layout.size());
  for (int i = 0; i < lin.count(); ++i) {
    const auto& term = lin.term(i);
    if (!layout.has(term.block)) continue;
    H.block(0, layout.offset(term.block) + term.column, lin.rows, term.size()) =
        term.jacobian.topLeftCorner(lin.rows, term.size());
  }
  return H;
}

FixDelay with_clock_drift(FixDelay delay, const StateLayout& layout, const Estimate& x, double elapsed) {
  if (!layout.has(Block::kClockDrift)) return delay;
  delay.value -= x.clock_drift * elapsed;
  delay.by_clock_drift = -elapsed;
  return delay;
}

void add_delay(Linearization& lin, const Lag& lag, const Vector3d& derivative) {
  Matrix3d column = Matrix3d::Zero();
  column.col(0) = derivative;
  if (lag.block) lin.add(*lag.block, column);
  if (lag.by_clock_drift != 0) lin.add(Block::kClockDrift, lag.by_clock_drift * column);
}

void add_curvature(Linearization& lin, const Lag& lag, const Vector3d& curvature) {
  lin.residual -= 0.5 * lag.variance * curvature;
  lin.covariance += 0.5 * lag.variance * lag.variance * curvature * curvature.transpose();
}

Vector3d beyond_noise(const Vector3d& mean, double variance) {
  const double square = mean.squaredNorm();
  return square > 3 * variance ? Vector3d((1 - 3 * variance / square) * mean) : Vector3d::Zero();
}

BodyMotion MeasurementContext::motion(const Estimate& x) const {
  const ImuStep s = correct(step, x);
  const double from_middle = into_step - 0.5 * s.dt;
  return {s.mean_rate() + from_middle * s.rate_slope, s.mean_force() + from_middle * s.force_slope, rate_variance};
}

Vector3d MeasurementContext::rate_without_noise(const Estimate& x) const {
  if (still) return Vector3d::Zero();
  const Vector3d force = step.mean_force() + (into_step - 0.5 * step.dt) * step.force_slope;
  const Vector3d neighbours = corrected_rate(neighbour_rate, force, x);
  return rate_regression ? Vector3d(rate_regression->matrix() * neighbours) : neighbours;
}

double MeasurementContext::observed_noise() const {
  if (still) return 0;
  return rate_regression ? rate_regression->matrix().trace() / 3 : 1;
}

BodyMotion MeasurementContext::mean_motion(const Estimate& x) const {
  const ImuStep second{1, recent.rate, recent.force, Vector3d::Zero(), Vector3d::Zero()};
  const ImuStep s = correct(second, x);
  return {.rate = s.dtheta, .force = s.dvel};
}

}  // namespace piste
