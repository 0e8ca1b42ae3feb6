#pragma once
/// The state of a run at any epoch or instant with the covariance of its navigation, and of any point of the body.

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/configuration/replay_config.h"
#include "piste/replay/replay.h"

namespace piste {

using NavigationCovariance = Eigen::Matrix<double, 9, 9>;

/// The state at an instant. It needs the histories of the run (ReplayOptions::history).
struct PlacedState {
  double time = 0;
  Estimate x;
  NavigationCovariance P;                     ///< of the error (ρ, ν, θ) as in Estimate
  Vector3d rate = Vector3d::Zero();           ///< angular rate against the Earth, in b
  Vector3d rate_variance = Vector3d::Zero();  ///< of its white noise
};

/// Position, velocity and attitude of a point of the body in the local level, with the covariance of north, east, down,
/// their velocities, roll, pitch and heading, in SI and radians.
struct PlacedPoint {
  double time = 0;
  Navigation navigation;
  NavigationCovariance covariance;
};

/// p = p_wb + R_wb l, v = v_wb + R_wb (ω × l), R_wp = R_wb R_bp. The rate's white noise is in the covariance.
PlacedPoint place(const World& world, const PlacedState& state, const OutputPoint& point);

/// The states of these rows of the run's solution, the last first. @pre `rows` ascend.
void placed_rows(const Replay& run, const std::vector<std::size_t>& rows,
                 const std::function<void(std::size_t row, const PlacedState&)>& take);

/// The states at these instants, in their order. Between two epochs the state is mechanized from the earlier one with
/// the sample between them, and what the later one differs by is added in proportion to time; the covariance is linear
/// between both. Throws DataError if an instant is outside the run, naming `file` and it.
std::vector<PlacedState> states_at(const Replay& run, const std::vector<double>& times, const std::string& file);

/// The roots of the diagonal.
NavigationSigmas sigmas_of(const PlacedPoint& point);

}  // namespace piste
