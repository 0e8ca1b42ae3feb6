#include "condition/unit_axes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace piste {
namespace {

constexpr double kRightAngle = 1e-9;  // of an element of R beside 0 and 1
constexpr double kParted = 5.5;       // sigmas: beyond them an offset is learned anew

constexpr int kOffset = 0, kOwn = 3, kOfFirst = 6, kStates = 9;
using State = Eigen::Matrix<double, kStates, 1>;
using Row = Eigen::Matrix<double, 1, kStates>;

bool at_right_angles(const Matrix3d& R) {
  return ((R.array().abs() < kRightAngle) || ((R.array().abs() - 1).abs() < kRightAngle)).all();
}

// Squared density of the random walk as which a drift begins.
double growth_of(const DriftProcess& drift) {
  if (drift.kind == DriftProcess::Kind::kRandomWalk) return drift.density * drift.density;
  if (drift.kind == DriftProcess::Kind::kNone) return 0;
  return 2 * drift.sigma * drift.sigma / drift.correlation_time;
}

double offset_variance(const TriadErrors& errors) {
  const bool returns = errors.drift.kind == DriftProcess::Kind::kGaussMarkov;
  return errors.bias * errors.bias + (returns ? errors.drift.sigma * errors.drift.sigma : 0);
}

// The means over the windows in which both tell all.
struct Means {
  std::vector<Vector3d> signal, difference;
  std::vector<double> duration, since;  // of each, and since the one before
};

Means means_of(const UnitTriad& first, const UnitTriad& unit, const std::vector<double>& intervals,
               const std::vector<UnitWindow>& windows) {
  Means out;
  double since = 0;
  for (const UnitWindow& window : windows) {
    since += window.duration;
    bool whole = true;
    for (std::size_t k = window.begin; k < window.end; ++k) whole = whole && first.bad[k] == 0 && unit.bad[k] == 0;
    if (!whole) continue;
    out.signal.push_back(mean_over(first, window, intervals));
    out.difference.emplace_back(mean_over(unit, window, intervals) - out.signal.back());
    out.duration.push_back(window.duration);
    out.since.push_back(since);
    since = 0;
  }
  return out;
}

}  // namespace

Matrix3d take_out_cross_axis(const UnitTriad& first, const TriadErrors& of_first, const TurnedTriad& unit,
                             const std::vector<double>& intervals, const std::vector<UnitWindow>& windows) {
  const Matrix3d& R = unit.R;
  if (at_right_angles(R) || !(unit.errors.scale > 0)) return Matrix3d::Zero();
  const Means means = means_of(first, unit.samples, intervals, windows);
  const Vector3d shown = noise_of(means.difference, means.signal);
  const double density = of_first.noise * of_first.noise + unit.errors.noise * unit.errors.noise;
  const double growth = growth_of(of_first.drift) + growth_of(unit.errors.drift);

  State x = State::Zero();
  Eigen::Matrix<double, kStates, kStates> P = Eigen::Matrix<double, kStates, kStates>::Zero();
  P.diagonal() << Vector3d::Constant(offset_variance(of_first) + offset_variance(unit.errors)),
      Vector3d::Constant(unit.errors.scale * unit.errors.scale), Vector3d::Constant(of_first.scale * of_first.scale);
  for (std::size_t w = 0; w < means.signal.size(); ++w) {
    P.diagonal().segment<3>(kOffset).array() += growth * means.since[w];
    const Vector3d& u = means.signal[w];
    const Matrix3d by_own = R * (R.transpose() * u).asDiagonal();
    for (int axis = 0; axis < 3; ++axis) {
      Row h = Row::Zero();
      h(kOffset + axis) = 1;
      h.segment<3>(kOwn) = by_own.row(axis);
      h(kOfFirst + axis) = -u(axis);
      const double noise = std::max(shown(axis) * shown(axis), density / means.duration[w]);
      const double residual = means.difference[w](axis) - h.dot(x);
      double predicted = (h * P).dot(h) + noise;
      if (residual * residual > kParted * kParted * predicted) {
        P(kOffset + axis, kOffset + axis) += residual * residual;
        predicted += residual * residual;
      }
      const State gain = P * h.transpose() / predicted;
      x += gain * residual;
      P -= (gain * gain.transpose()).eval() * predicted;
    }
  }
  Matrix3d across = R * x.segment<3>(kOwn).asDiagonal() * R.transpose();
  across.diagonal().setZero();
  for (Vector3d& value : unit.samples.value) value -= across * value;
  return across;
}

}  // namespace piste
