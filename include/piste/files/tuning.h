#pragma once
/// The files of `tune`: tune.json, and the configuration and sensor file with the estimated noise.

#include <string>

#include "piste/configuration/replay_config.h"
#include "piste/files/output.h"
#include "piste/tune/likeliest_noise.h"

namespace piste {

/// `tune.json`: under `noises`, each number by its name with `unit`, `value`, `interval` (95 %: [low, high]), `start`
/// and `determined`; `log_likelihood` (`start`, `found`, `rows`, `filter_runs`); `coloured_gnss_error` (`gain`,
/// `penalty`, `kept`) if it was tested; `at_rest` (the noise of the stationary samples, and the ratio of the noise in
/// motion to it); and `nis`, the mean normalised innovation squared of each source in motion. What does not exist is
/// null. Equal tunings give equal bytes.
std::string tune_json(const Tuning& tuning);

/// The same as a table of text.
std::string tuning_text(const Tuning& tuning);

/// The sensor file with the maximum-likelihood noise, along the sensor's own axes.
std::string tuned_sensor(const ReplayConfig& config, const Tuning& tuning);

/// Writes `sensor.yaml`, `replay.yaml` and `tune.json`. `replay.yaml` builds on `config`'s file (`base:`) and overrides
/// only sensor file, sigmas and correlation times.
void write_tuning(OutputFolder& output, const ReplayConfig& config, const Tuning& tuning);

}  // namespace piste
