#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "filter/covariance_inflation.h"
#include "filter/filter_walk.h"
#include "filter/kalman_filter.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste {

// The error-state Kalman filter (ρ, ν, θ, biases, …), closed loop: Groves 2013, sections 3.2.2 and 14.2; Farrell 2008,
// section 5.10. `state_` is the estimate x with the covariance P of its error.

// x ← f(x, ω_ib, f_ib)        P ← Φ P Φᵀ + Q, with Φ and Q linearised along the step
Transition KalmanFilter::predict(const ImuStep& step, const StepNoise& noise) {
  const Estimate before = state_.x;
  const ImuStep corrected_step = correct(step, before);
  const Vector3d& earth_rate = setup_->world.earth_rate();
  setup_->world.follow(gravity_, before.p_wb);
  mechanize(state_.x, corrected_step, earth_rate, gravity_);
  motion_.add(step, state_.x.q_wb);
  steps_.add(step);
  const Vector3d* standing = standing_.add(resting(), state_.x, gravity_.value, step.dt);
  Transition t = linearize(before, state_.x, corrected_step, earth_rate, gravity_, noise, standing);
  if (reference_ && standing == nullptr) {  // factors of the scales without the noise of the samples
    t.rate = t.step.rate = known_.rate;
    t.force = t.step.force = known_.force;
  }
  t.imu_scales = imu_scales_.get();
  add_processes(t, layout(), options(), step.dt);
  decay(state_.x, layout(), t);
  propagate(state_.P, layout(), t);
  if (reference_) propagate(state_.mean, layout(), t);
  if (!resting()) stood_.reset();
  state_.time += step.dt;
  return t;
}

// z = measured − h(x)        S = H P Hᵀ + R        Innovation test: zᵀ S⁻¹ z is within its chi-squared bound.
// FaultDetection decides by it whether the fix is used.
std::pair<Update, FaultDetection::Ruling> KalmanFilter::test(int source, double late, const Linearization& lin) {
  const Update u = innovate(state_.P, layout(), lin);
  if (!(u.nis >= 0) || !std::isfinite(u.nis)) fail("at " + setup_->names[static_cast<std::size_t>(source)]);
  const FaultDetection::Ruling ruling =
      fault_detection_.rule(source, state_.time, lin, u, gate(lin), state_.x, state_.P);
  const Matrix3d shown = along_world(lin) ? gravity_.R_wn.transpose() : Matrix3d::Identity().eval();
  innovations_.push_back({.time = state_.time,
                          .source = source,
                          .dof = lin.rows,
                          .residual = shown * u.residual,
                          .sigma = (shown * u.S * shown.transpose()).diagonal().cwiseSqrt(),
                          .nis = u.nis,
                          .gate = gate(lin),
                          .outcome = ruling.outcome,
                          .late = late,
                          .log_determinant = std::log(u.S.determinant())});
  if (!resting()) adaptation_.learn(source, state_.time, u, gate(lin));
  return {u, ruling};
}

// K = P Hᵀ S⁻¹        δ = K z        P ← (I − K H) P        considered.h has what considered states change of it.
ErrorVector KalmanFilter::update(const Update& u) {
  ErrorVector correction = considered_.correction(u);
  considered_.update(state_.P, u);
  return correction;
}

// Where a boresight is estimated, a reference determines the attitude far better than standstill determines tilt and
// bias: the body counts as moving.
std::optional<Standing> KalmanFilter::standing() const {
  if (!resting() || layout().has(Block::kBoresight)) return std::nullopt;
  return Standing{gravity_.value.normalized(), stood_.value_or(state_.x.q_wb)};
}

// x ← x ⊞ δ        P ← G P Gᵀ, as the error is now relative to the new estimate.
// About a reference, which stays, m ← m + δ.
ResetJacobian KalmanFilter::reset(const ErrorVector& correction, const std::optional<Standing>& standing) {
  if (reference_) {
    state_.mean += correction;
    return reset_jacobian(FullError::Zero());
  }
  ResetJacobian G = transport_jacobian(state_.x, layout(), correction, standing);
  piste::reset(state_.P, layout(), G);
  state_.x = corrected(state_.x, layout(), correction, standing.has_value());
  stood_.reset();
  if (standing) stood_ = state_.x.q_wb;
  return G;
}

KalmanFilter::KalmanFilter(const FilterOptions& options, const World& world, const Start& start,
                           std::shared_ptr<const Reference> reference) {
  options.validate();
  const StateLayout layout = filter_layout(options);
  considered_ = Considered(options, layout);
  state_ = {start.time, start.x, initial_covariance(layout, options, start), ErrorVector::Zero(layout.size())};
  if (reference) {
    state_.x = reference->start;
    state_.mean = boxminus(start.x, state_.x, layout);
    reference_.emplace(std::move(reference));
  }
  walker_ = Walker(options, layout, start.time, state_.x);
  auto setup = std::make_shared<Setup>();
  setup->world = world;
  setup->names = walker_.sources().names();
  for (std::size_t n = 1; n <= 3; ++n)
    setup->gate[n] = chi_squared_quantile(options.behaviour.trust.gate, static_cast<int>(n));
  setup_ = std::move(setup);
  imu_scales_ = ImuScales::across(options);
  gravity_ = world.gravity(start.x.p_wb);
  fault_detection_ = FaultDetection(walker_.sources().all(), options.behaviour.trust);
  errors_in_variables_ = ErrorsInVariables(options, layout);
  adaptation_ = Adaptation(options, layout, walker_.sources());
  innovations_.reserve(256);
}

bool KalmanFilter::add(const ImuSample& sample) { return FilterWalk(*this, kUnrecorded).add(sample); }

void KalmanFilter::add(int sensor, const AnyFix& fix) { FilterWalk(*this, kUnrecorded).add(sensor, fix); }

bool KalmanFilter::finish() { return FilterWalk(*this, kUnrecorded).finish(); }

Estimate KalmanFilter::predicted() const {
  Estimate x = state_.x;
  if (walker_.has_sample()) {
    mechanize(x, correct(walker_.step(nullptr, imu_scales_.get(), x), x), setup_->world.earth_rate(), gravity_);
  }
  return x;
}

// Sets the estimate of the reference at the end of the sample, and the motion to it.
void KalmanFilter::follow_reference(double dt) {
  target_ = reference_->at(walker_.sample().time).x;
  known_ = motion_between(state_.x, target_, dt, setup_->world.earth_rate(), gravity_);
}

// At the end of a sample the estimate moves to the reference, and the mean of the error changes by the difference.
// Returns this change.
ErrorVector KalmanFilter::arrive_at_reference() {
  ErrorVector moved = boxminus(state_.x, target_, layout());
  state_.mean += moved;
  state_.x = target_;
  return moved;
}

// Where the reference ends, the estimate is corrected by the mean, and the filter continues about its own estimate. The
// covariance stays, as the reference is smoothed and thus near. Returns the change of the mean.
ErrorVector KalmanFilter::leave_reference() {
  ErrorVector moved = -state_.mean;
  state_.x = boxplus(state_.x, layout(), state_.mean);
  state_.mean.setZero();
  reference_.reset();
  if (walker_.delays_change()) find_delays();
  return moved;
}

// Variance of the error of a delay.
double KalmanFilter::variance_of(const FixDelay& delay) const {
  const int own = delay.block ? layout().offset(*delay.block) : -1;
  double variance = own < 0 ? 0 : state_.P(own, own);
  if (const double slope = delay.by_clock_drift; slope != 0) {
    const int drift = layout().offset(Block::kClockDrift);
    variance += slope * slope * state_.P(drift, drift) + (own < 0 ? 0 : 2 * slope * state_.P(own, drift));
  }
  return variance;
}

// Whether the body certainly moves.
bool KalmanFilter::moves() const {
  return !resting() &&
         state_.x.v_wb.norm() > 3 * sigmas_of(setup_->world, state_.x, layout(), state_.P).velocity.norm();
}

// Returns the variances that it adds.
ErrorVector KalmanFilter::inflate(const Linearization& lin, double lapse) {
  const ErrorVector before = state_.P.diagonal();
  inflate_covariance(state_.P, layout(), lin, lapse, options().behaviour.trust);
  return state_.P.diagonal() - before;
}

// Returns the variances that it adds: at most up to what is known of such an error beforehand. `change`: relative to
// that (SlowLevel).
std::optional<ErrorVector> KalmanFilter::change_slow_error(int receiver, const Vector3d& change) {
  const std::optional<PositionDrift>& drift = options().gnss[static_cast<std::size_t>(receiver)].drift;
  if (!drift || !drift->of_stated) return std::nullopt;
  const Block block = position_drift_block(receiver, true);
  if (!layout().has(block)) return std::nullopt;
  ErrorVector added = ErrorVector::Zero(layout().size());
  auto variance = state_.P.diagonal().segment<3>(layout().offset(block));
  const Vector3d prior = drift->sigma.cwiseAbs2();
  const Vector3d more = prior.cwiseProduct(change).cwiseMin(prior - variance).cwiseMax(0);
  variance += more;
  added.segment<3>(layout().offset(block)) = more;
  return added;
}

// Removes information from the scales, and returns the update that does so.
std::optional<Update> KalmanFilter::remove_information(const Vector3d& information, Block scales) {
  if (!layout().has(scales)) return std::nullopt;
  // At most the information of the fixes: that of the prior is not affected by noise.
  const Vector3d before = info(scales).prior(options()).head<3>().cwiseAbs2();
  const Vector3d now = state_.P.diagonal().segment<3>(layout().offset(scales));
  const Vector3d of_fixes = (now.cwiseInverse() - before.cwiseInverse()).cwiseMax(0);
  std::optional<Update> u = removing(information.cwiseMin(of_fixes), layout(), scales, state_.P);
  if (u) considered_.update(state_.P, *u);
  return u;
}

void KalmanFilter::fail(const std::string& where) const {
  throw DataError(fmt::format("t = {:.3f} s", state_.time),
                  fmt::format("the filter diverged {}: check units, axes and time stamps of the logs", where));
}

}  // namespace piste
