#include "points/placed.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "piste/core/error.h"
#include "piste/io/solution_io.h"
#include "piste/model/strapdown.h"
#include "piste/smoother/rts.h"
#include "points/body_motion.h"

namespace piste {
namespace {

// The rate at the end of a sample: the mean of it and the next one, where they adjoin.
class RateAtRows {
 public:
  explicit RateAtRows(const Replay& run) : run_(run), at_(run.log) {}
  void set(PlacedState& state) {
    const std::vector<ImuSample>& imu = run_.log.imu;
    const std::size_t i = at_(state.time);
    const auto rate = [&](std::size_t k) {
      const ImuSample& s = imu[k];
      return corrected_rate(s.dtheta / s.interval, s.dvel / s.interval, state.x);
    };
    const bool both = i + 1 < imu.size() && !imu[i + 1].gap && !imu[i].gap;
    const Vector3d R_earth = state.x.R_wb().transpose() * run_.log.world.earth_rate();
    state.rate = (both ? (0.5 * (rate(i) + rate(i + 1))).eval() : rate(i)) - R_earth;
    state.rate_variance = run_.options.sensor.gyro.noise_variance() / (imu[i].interval * (both ? 2 : 1));
  }

 private:
  const Replay& run_;
  SampleAt at_;
};

// The corrected step of sample k about the estimate before it.
ImuStep whole_step(const Log& log, std::size_t k) {
  const std::vector<ImuSample>& imu = log.imu;
  return make_step(k > 0 ? &imu[k - 1] : nullptr, imu[k], k + 1 < imu.size() ? &imu[k + 1] : nullptr);
}

void advance(const World& world, Estimate& x, const ImuStep& step) {
  mechanize(x, correct(step, x), world.earth_rate(), world.gravity(x.p_wb));
}

// The navigation part of an error.
FullError navigation_part(const FullError& error, double factor) {
  FullError part = FullError::Zero();
  part.head<9>() = factor * error.head<9>();
  return part;
}

PlacedState between(const Replay& run, const PlacedState& a, const PlacedState& b, double time) {
  const double u = (time - a.time) / (b.time - a.time);
  PlacedState state = u < 0.5 ? a : b;
  state.time = time;
  state.x = a.x;
  SampleAt at(run.log);
  const ImuStep step = whole_step(run.log, at(b.time));
  Estimate end = a.x;
  advance(run.log.world, end, step);
  const double tau = time - a.time;
  if (tau < step.dt) {
    advance(run.log.world, state.x, split(step, tau).first);
  } else {
    state.x = end;
  }
  state.x = boxplus(state.x, navigation_part(boxminus(b.x, end), u));
  state.P = (1 - u) * a.P + u * b.P;
  state.rate = (1 - u) * a.rate + u * b.rate;
  return state;
}

std::vector<std::size_t> bracketing_rows(const Solution& solution, const std::vector<double>& times,
                                         const std::string& file) {
  std::vector<double> all;
  all.reserve(solution.size());
  for (std::size_t i = 0; i < solution.size(); ++i) all.push_back(solution.time(i));
  std::vector<std::size_t> rows;
  for (const double time : times) {
    constexpr double kRounding = 1e-6;  // s, of the text of a file
    if (all.empty() || time < all.front() - kRounding || time > all.back() + kRounding) {
      throw DataError(file,
                      fmt::format("an instant at {:.6f} s lies outside the run, {:.6f} to {:.6f} s; are its clock "
                                  "and `offset` right?",
                                  time, all.empty() ? 0 : all.front(), all.empty() ? 0 : all.back()));
    }
    const auto after = static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), time) - all.begin());
    rows.push_back(std::clamp<std::size_t>(after, 1, all.size() - 1) - 1);
  }
  return rows;
}

}  // namespace

PlacedPoint place(const World& world, const PlacedState& state, const OutputPoint& point) {
  const Estimate& x = state.x;
  const Matrix3d R_wb = x.R_wb();
  const Vector3d arm = R_wb * point.lever_arm, swing = R_wb * state.rate.cross(point.lever_arm), p = x.p_wb + arm,
                 v = x.v_wb + swing;
  const auto [geodetic, R_wn] = world.local_level(p);
  const Matrix3d R_nw = R_wn.transpose(), R_np = R_nw * R_wb * point.q_bp.toRotationMatrix();
  NavigationCovariance J = NavigationCovariance::Identity();
  J.block<3, 3>(0, 6) = -skew(arm);
  J.block<3, 3>(3, 6) = -skew(swing);
  NavigationCovariance level = NavigationCovariance::Zero();
  const Vector3d euler = to_euler(R_np);
  level.block<3, 3>(0, 0) = level.block<3, 3>(3, 3) = R_nw;
  level.block<3, 3>(6, 6) = euler_axes(euler).inverse() * R_nw;
  const NavigationCovariance to_level = level * J * ordinary_from_invariant(x);
  PlacedPoint placed{state.time, {geodetic, R_nw * v, euler}, to_level * state.P * to_level.transpose()};
  const Matrix3d by_rate = R_nw * R_wb * skew(point.lever_arm);
  placed.covariance.block<3, 3>(3, 3) += by_rate * state.rate_variance.asDiagonal() * by_rate.transpose();
  return placed;
}

void placed_rows(const Replay& run, const std::vector<std::size_t>& rows,
                 const std::function<void(std::size_t row, const PlacedState&)>& take) {
  RateAtRows rates(run);
  const Solution& filtered = run.filtered.solution;
  smooth_rows(run.smoothable(), rows, [&](std::size_t row, const FilterState& before, const SmoothedState& after) {
    PlacedState state;
    state.time = before.time;
    state.x = run.smoothed ? after.x : filtered.estimate(row);
    state.P = (run.smoothed ? after.P : before.P).topLeftCorner<9, 9>();
    rates.set(state);
    take(row, state);
  });
}

std::vector<PlacedState> states_at(const Replay& run, const std::vector<double>& times, const std::string& file) {
  const std::vector<std::size_t> first = bracketing_rows(run.solution(), times, file);
  std::map<std::size_t, PlacedState> states;
  std::vector<std::size_t> rows;
  for (const std::size_t row : first) rows.insert(rows.end(), {row, row + 1});
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  placed_rows(run, rows, [&](std::size_t row, const PlacedState& state) { states.emplace(row, state); });
  std::vector<PlacedState> out;
  for (std::size_t i = 0; i < times.size(); ++i) {
    out.push_back(between(run, states.at(first[i]), states.at(first[i] + 1), times[i]));
  }
  return out;
}

NavigationSigmas sigmas_of(const PlacedPoint& point) {
  const Eigen::Matrix<double, 9, 1> sigma = point.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  return {sigma.head<3>(), sigma.segment<3>(3), sigma.tail<3>().cwiseMin(std::numbers::pi)};
}

}  // namespace piste
