#pragma once
/// The truth of a simulated run in the form of an estimate.

#include <vector>

#include "piste/core/estimate.h"
#include "piste/sim/simulation.h"

namespace piste {

/// The true value of every block at any time of a run, in the world frame of a log. (The world frame of the simulation
/// has its origin at the scenario's origin; that of a log has it at the first fix.)
class TrueEstimate {
 public:
  /// The truth of the first IMU. `imus`: the sensors of several IMUs, which must be all IMUs of the scenario. The
  /// errors are then those of the mean and of the parities (core/imu_array.h). Lever arm and delay belong to the first
  /// receiver. Drifts belong to the first receiver and to the first reference that have a drift. The simulation must
  /// outlive this object.
  TrueEstimate(const Scenario& scenario, const Simulation& simulation, World world, std::uint64_t seed,
               std::vector<ImuSensor> imus = {});

  /// Stamps given to at() are from a drifting clock of the IMU, which is right at the time `from` [s].
  void set_clock(double drift, double from);

  /// The true values at the time `stamp`. Drifts are taken from the nearest row or fix.
  Estimate at(double stamp) const;

 private:
  struct Sample {
    double time;
    Vector3d value;
  };
  template <class Recording>
  static std::vector<Sample> timed(const Recording& recording, const std::vector<Vector3d>& values);

  Vector3d in_first(std::size_t imu, const Vector3d& value) const;
  void split(Estimate& x, double time) const;

  const Simulation& simulation_;
  std::vector<ImuSensor> imus_;
  std::vector<Matrix3d> axes_;  // of the IMUs, relative to the first
  World world_;
  Estimate constant_;
  double clock_from_ = 0;
  std::array<std::vector<Sample>, kDriftingReceivers> position_drift_;
  std::array<Vector3d, kDriftingReceivers> stated_;  // constant sigmas of these receivers
  std::vector<Sample> attitude_drift_;
  std::vector<Sample> wheel_slip_, barometer_offset_;  // along x
};

}  // namespace piste
