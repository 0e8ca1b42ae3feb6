#pragma once
/// Runs a scenario: simulates all its sensors, and keeps the truth to compare results with.

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
  Truth trunk, plate;
  std::vector<Truth> bodies;  ///< of the IMUs
  std::vector<SimulatedImu> imus;
  std::vector<GnssRecording> gnss;
  std::vector<AttitudeRecording> attitude;
  SimulatedAids aids = {};

  /// The recording for a replay of one IMU: with all other sensors.
  Recording recording(std::size_t imu) const;
};

/// Called with the number of sensors that are done, and the number of all.
using SimulationProgress = std::function<void(std::size_t, std::size_t)>;

/// Simulates one run of a scenario. The same seed gives the same numbers to the last bit. The numbers of a sensor do
/// not depend on which other sensors there are.
Simulation simulate(const Scenario& scenario, std::uint64_t seed, const SimulationProgress& progress = {});

/// Lever arm p_ba_b from an IMU b to an antenna a.
Vector3d lever_arm(const ImuSetup& imu, const GnssSetup& gnss);

/// The correlation, as a magnitude, of bias and scale if both are fitted to the signal of the run: |mean| / rms, per
/// axis.
Vector3d bias_scale_correlation(const TriadDraw& draw);

// ---- The texts of the files that `simulate` writes. ----

std::string imu_csv(const ImuRecording& recording);
std::string gnss_csv(const GnssRecording& recording);
std::string attitude_csv(const AttitudeRecording& recording);
std::string speed_csv(const FixRecording<SpeedFix>& recording);
std::string height_csv(const FixRecording<HeightFix>& recording);
std::string heading_csv(const FixRecording<HeadingFix>& recording);
/// Position, velocity and attitude of the body at every `every`-th of the times, in the columns of `filtered.csv`
/// without sigmas.
std::string truth_csv(const Truth& body, const std::vector<double>& gps_time, std::size_t every);
/// The gates of the course, as `descents` reads them: `name, latitude_deg, longitude_deg, heading_deg`. @pre it has
/// some
std::string gates_csv(const Truth& body);
/// Every error that was added, and for each phase (rest before, run, rest after) the means of the in-run drift with its
/// warm-up and of the true signal. A phase that does not exist is null.
std::string truth_json(const Scenario& scenario, const Simulation& simulation, std::uint64_t seed);

}  // namespace piste
