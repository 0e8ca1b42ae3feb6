#pragma once
/// The output files of a replay, as text. The same solution gives the same bytes.

#include <string>

#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

/// `filtered.csv`, `smoothed.csv`: geodetic position, velocity in local north-east-down, angles, and their sigmas.
std::string navigation_csv(const Solution& solution);

/// Roll, pitch and heading in local north-east-down and their sigmas, as another replay takes them for a reference. Of
/// the epochs nearest to the multiples of 1 / rate [Hz]; all, where they are sparser. The name of the file is empty.
AttitudeRecording attitude_recording(const Solution& solution, double rate);

/// `attitude.csv`: the same as an attitude log that another replay reads (`attitude:`).
std::string attitude_csv(const Solution& solution, double rate);

/// `biases.csv`, `biases_smoothed.csv`: of each estimated block beyond navigation its axes, such as
/// `gyro_bias_x_deg_s`, and their sigmas, `sigma_gyro_bias_x_deg_s`, in the units of kBlocks; boresight as (roll,
/// pitch, heading) of R_rb; then bias and drift together, `gyro_total_bias_*` and `accel_total_bias_*`.
std::string biases_csv(const Solution& solution);

/// `innovations.csv`: every measurement against its prediction, SI, and what became of it.
std::string innovations_csv(const Solution& solution);

}  // namespace piste
