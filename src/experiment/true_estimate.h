#pragma once
/// The truth of a simulated run as the filter would hold it.

#include "piste/core/estimate.h"
#include "piste/sim/simulation.h"

namespace piste {

/// Every block's true value at any time of a run, in the world of a log: the world of the simulation has its origin at
/// the scenario's, that of a log at the first fix.
class TrueEstimate {
 public:
  /// Of the first IMU. Lever arm and delay are those of the first receiver, drifts those of the first receiver and of
  /// the first reference that have one. The simulation must outlive this.
  TrueEstimate(const Scenario& scenario, const Simulation& simulation, World world, std::uint64_t seed);

  /// Drifts are those of the nearest row or fix.
  Estimate at(double time) const;

 private:
  struct Sample {
    double time;
    Vector3d value;
  };
  template <class Recording>
  static std::vector<Sample> timed(const Recording& recording, const std::vector<Vector3d>& values);

  const Simulation& simulation_;
  World world_;
  Estimate constant_;
  std::vector<Sample> position_drift_, attitude_drift_;
};

}  // namespace piste
