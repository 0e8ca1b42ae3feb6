#include "piste/study/navigation_score.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "piste/core/error.h"
#include "piste/filter/filter.h"
#include "piste/filter/run.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kStartPosition = 0.05, kStartVelocity = 0.05,
                 kStartAttitude = 0.1 / kDegreesPerRadian;  // 1-sigma of the start

template <class Item>
void keep(std::vector<Item>& items, const Interval& span) {
  std::erase_if(items, [&](const Item& item) { return !span.contains(item.time); });
}

// Of errors that were calibrated the navigation takes the estimates, and of their remainders nothing is known.
TriadErrors noise_alone(TriadErrors triad) {
  triad.bias = triad.scale = 0;
  triad.drift = {};
  triad.cross_axis.reset();
  return triad;
}

bool inside_any(const std::vector<Interval>& windows, double time) {
  return std::any_of(windows.begin(), windows.end(), [&](const Interval& w) { return w.contains(time); });
}

}  // namespace

std::vector<Interval> outages(const OutagePlan& plan, const Interval& run) {
  std::vector<Interval> out;
  for (double start = run.start + plan.first; start + plan.length <= run.end; start += plan.every) {
    out.push_back({start, start + plan.length});
  }
  return out;
}

Course::Course(const Log& log, FilterOptions options, const Interval& run, const ReferenceTrack& track,
               BodyMounting body, const OutagePlan& plan)
    : options_(std::move(options)), track_(track.in(log.world)), body_(std::move(body)) {
  if (track.empty()) throw DataError("", "the reference solution has no epoch in the run");
  const Interval span{std::max(run.start, track.span().start), std::min(run.end, track.span().end)};
  log_.world = log.world;
  log_.imu = log.imu;
  keep(log_.imu, span);
  // The first sample gives the start: it ends there.
  if (log_.imu.size() < 2) throw DataError("", "no sample of the IMU lies in the run of the reference solution");
  log_.imu.erase(log_.imu.begin());
  for (ImuSample& sample : log_.imu) sample.at_rest = false;
  log_.gnss = log.gnss;
  for (auto& fixes : log_.gnss) keep(fixes, span);
  log_.parity = log.parity;
  for (auto& fixes : log_.parity) keep(fixes, span);
  options_.attitude.clear();
  options_.estimate = position_drifts(options_);
  outages_ = outages(plan, span);
}

Solution Course::replay(const std::vector<ImuSample>& imu, const FilterOptions& options, bool with_outages) const {
  Log log;
  log.world = log_.world;
  log.imu = imu;
  log.gnss = log_.gnss;
  if (!options.imus.empty()) log.parity = log_.parity;
  if (with_outages) {
    for (auto& fixes : log.gnss) {
      std::erase_if(fixes, [&](const GnssFix& fix) { return inside_any(outages_, fix.time); });
    }
  }
  Start start;
  start.time = imu.front().time - imu.front().interval;
  const ReferenceTrack::State truth = track_.at(start.time, body_);
  start.x.q_wb = truth.q_wb;
  start.x.v_wb = truth.v_wb;
  start.x.p_wb = truth.p_wb;
  start.x.lever_arm = options.gnss.front().lever_arm;
  Eigen::Matrix<double, 9, 1> sigma;
  sigma << Vector3d::Constant(kStartPosition), Vector3d::Constant(kStartVelocity), Vector3d::Constant(kStartAttitude);
  start.covariance = sigma.cwiseAbs2().asDiagonal();
  return run_filter(log, options, start).solution;
}

NavigationScore Course::score(Method method, const std::optional<KnownErrors>& errors) const {
  FilterOptions options = options_;
  std::vector<ImuSample> imu = log_.imu;
  if (errors) {
    for (ImuSample& sample : imu) sample = corrected(sample, *errors);
    options.sensor.gyro = noise_alone(options.sensor.gyro);
    options.sensor.accel = noise_alone(options.sensor.accel);
    options.sensor.gyro_g_sensitivity.reset();
    options.imus.clear();
    options.unit_axes.clear();  // differences between the IMUs inform only about errors that are not estimated
  } else {
    const std::vector<Block> own = imu_error_blocks(options.sensor);
    options.estimate.insert(options.estimate.end(), own.begin(), own.end());
    if (!options.imus.empty()) options.estimate = with_implied_blocks(options, std::move(options.estimate));
  }
  const Solution whole = replay(imu, options, false);
  NavigationScore out{.method = method};
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const Estimate x = whole.estimate(i);
    const ReferenceTrack::State truth = track_.at(whole.time(i), body_);
    const double angle = truth.q_wb.angularDistance(x.q_wb);
    out.position_rmse += (truth.p_wb - x.p_wb).squaredNorm();
    out.velocity_rmse += (truth.v_wb - x.v_wb).squaredNorm();
    out.attitude_rmse += angle * angle;
  }
  const auto epochs = static_cast<double>(whole.size());
  for (double* sum : {&out.position_rmse, &out.velocity_rmse, &out.attitude_rmse}) *sum = std::sqrt(*sum / epochs);
  if (outages_.empty()) return out;

  const Solution held = replay(imu, options, true);
  for (const Interval& window : outages_) {
    std::size_t last = 0;
    while (last + 1 < held.size() && held.time(last + 1) <= window.end) ++last;
    out.outage_drift += (track_.at(held.time(last), body_).p_wb - held.estimate(last).p_wb).squaredNorm();
  }
  out.outage_drift = std::sqrt(out.outage_drift / static_cast<double>(outages_.size()));
  return out;
}

}  // namespace piste
