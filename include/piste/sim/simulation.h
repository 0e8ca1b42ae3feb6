#pragma once
/// From a scenario to recordings, and to the truth that they are held against.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/core/log.h"
#include "piste/sim/scenario.h"

namespace piste {

/// All recordings of one run of a scenario, in the order of its lists.
struct Simulation {
  Truth plate;
  std::vector<Truth> bodies;  ///< of the IMUs
  std::vector<SimulatedImu> imus;
  std::vector<GnssRecording> gnss;
  std::vector<AttitudeRecording> attitude;

  /// What a replay of that IMU reads: it, with all receivers and reference attitudes.
  Recording recording(std::size_t imu) const;
};

/// Called with what has been done and what there is in all, of sensors.
using SimulationProgress = std::function<void(std::size_t, std::size_t)>;

/// Runs a scenario. The same seed gives the same numbers to the last bit; a sensor's numbers do not depend on which
/// others are carried.
Simulation simulate(const Scenario& scenario, std::uint64_t seed, const SimulationProgress& progress = {});

/// Lever arm b → antenna, in b.
Vector3d lever_arm(const ImuSetup& imu, const GnssSetup& gnss);

/// |corr| of bias and scale when both are fitted to the run's signal: |mean| / rms, per axis.
Vector3d bias_scale_correlation(const TriadDraw& draw);

// ---- As files: the text of each, to the contracts of `simulate`. ----

std::string imu_csv(const ImuRecording& recording);
std::string gnss_csv(const GnssRecording& recording);
std::string attitude_csv(const AttitudeRecording& recording);
/// Position, velocity and attitude of the body in the columns of `filtered.csv` without sigmas, at every n-th of the
/// times.
std::string truth_csv(const Truth& body, const std::vector<double>& gps_time, std::size_t every);
/// Every error that was put in, and the means over each phase, rest before, run, rest after, of the in-run drift with
/// its warm-up and of the true signal: null where there is no such phase.
std::string truth_json(const Scenario& scenario, const Simulation& simulation, std::uint64_t seed);

}  // namespace piste
