#pragma once
/// Runs of a scenario, replayed, and the errors of filter and smoother against their covariances.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "piste/sim/simulation.h"
#include "piste/solve/rts.h"

namespace piste::test {

/// One IMU and one receiver, and how they are replayed.
struct Experiment {
  Scenario scenario;  ///< with one IMU and one receiver
  ImuSensor sensor;   ///< what the filter holds of the IMU
  /// Nothing known of the heading; else the start is drawn about the truth from a known covariance.
  bool find_heading = false;
  double every = 5;  ///< s between the epochs that are looked at
};

/// The shipped scenario `name` with its first IMU and one receiver, made short: rests before and after, and the run.
Experiment experiment(const std::string& name, const std::string& receiver, double rest_before, double run,
                      double rest_after);

/// truth ⊟ estimate of the estimated blocks, and the covariance that is claimed of it.
struct ErrorSample {
  double time = 0;  ///< since the run began: negative at rest before it
  ErrorVector error;
  Covariance P;
};

struct ReplayedRun {
  StateLayout layout;
  std::vector<ErrorSample> filtered, smoothed;
};

ReplayedRun replay(const Experiment& experiment, std::uint64_t seed);

/// Seeds 1 to `runs`, on all cores; the order is that of the seeds.
std::vector<ReplayedRun> replay_all(const Experiment& experiment, int runs);

/// NEES of some blocks, averaged over the runs and over the epochs in [from, to].
struct Consistency {
  int dof = 0;               ///< of one sample
  double mean = 0;           ///< NEES / dof: 1 where the covariance is true
  double low = 0, high = 0;  ///< two-sided band of the mean over runs at one epoch: the more so of many
  double beyond = 0;         ///< share of single errors beyond 3 sigma: 0.0027
  bool within() const { return mean > low && mean < high; }
};
Consistency consistency(const std::vector<ReplayedRun>& runs, bool smoothed, std::span<const Block> blocks, double from,
                        double to, double probability = 0.999);

}  // namespace piste::test
