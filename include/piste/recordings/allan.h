#pragma once
/// The stochastic model of an IMU from recordings at rest: `allan`.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "piste/allan/sensor_noise.h"
#include "piste/core/log.h"
#include "piste/filter/run.h"
#include "piste/io/config.h"
#include "piste/io/log_io.h"
#include "piste/math/statistics.h"

namespace piste {

/// Names of the six axes: gyro_x … accel_z.
inline constexpr std::array<std::string_view, 6> kAllanAxes{"gyro_x",  "gyro_y",  "gyro_z",
                                                            "accel_x", "accel_y", "accel_z"};

/// One recording, and how its format was recognised.
struct AllanSource {
  LogFile log;
  std::string why;                       ///< the evidence for its format
  std::vector<std::string> doubts = {};  ///< what the user should check
};

/// The white noise that `tune` estimates in motion.
struct NoiseInMotion {
  std::string file;
  std::optional<Measured> gyro, accel;
};

struct AllanOptions {
  std::string name = "IMU at rest";    ///< of the sensor
  std::optional<ImuSensor> base = {};  ///< gives bias, scale and range; without it they are guessed
  std::string base_file = {};          ///< its file
  std::optional<NoiseInMotion> tuned = {};
  bool robust = false;   ///< bound the influence of outliers
  bool at_rest = false;  ///< treat all rows as stationary
  GmwmOptions fit = {};
  std::size_t jobs = 1;             ///< number of parallel fits; the results do not depend on it
  double longest_disturbance = 10;  ///< s of motion that do not end a stationary stretch: a knock, a hand
  double shortest_rest = 60;        ///< s: shortest stationary stretch that is used
  std::size_t longest_hole = 10;    ///< missing rows that a straight line bridges
};

/// The summary of one recording.
struct AllanRecording {
  AllanSource source;
  std::size_t rows = 0, refused = 0;      ///< rows read, and unreadable rows
  std::string first_refused;              ///< why the first unreadable row is one
  double interval = 0, jitter = 0;        ///< s
  double span = 0;                        ///< from the first to the last row [s]
  std::size_t gaps = 0, missing = 0;      ///< number of gaps, and of rows missing in them
  std::size_t filled = 0;                 ///< missing rows that a straight line bridged
  std::vector<Interval> stretches;        ///< stationary times that were used, without a gap
  double moving = 0;                      ///< s left out because the IMU moved
  std::size_t disturbances = 0;           ///< short motions that were not left out
  bool rest_checked = true;               ///< false: the rows are too sparse to decide
  std::array<std::size_t, 6> outliers{};  ///< samples beyond six sigmas: replaced if robust, else only counted
  std::array<double, 6> step{};           ///< quantization step: all values are multiples of it; 0: none
  std::array<AllanCurve, 6> curves;
  std::optional<std::array<double, 2>> temperature;  ///< lowest and highest [°C]
  double used() const;                               ///< s
};

/// One IMU compared with the others of its type.
struct AllanImu {
  std::optional<GmwmFit> fit;
  AxisNoise noise;
};

/// One axis of all recordings.
struct AllanAxis {
  std::string name;
  bool is_gyro = true;
  AllanCurve curve;            ///< of all recordings together
  std::optional<GmwmFit> fit;  ///< nothing if the axis does not vary
  std::string why_not;
  AxisNoise noise;
  double step = 0, rounding = 0;  ///< step of the values; white noise of rounding [unit/√Hz]
  std::vector<AllanImu> imus;     ///< one for each recording, if there are several: the common model, fitted to it
  double spread = kNaN, spread_instability = kNaN;  ///< sd of the logarithms of noise and bias instability between IMUs
};

/// All results of `allan`.
struct AllanFindings {
  AllanOptions options;
  std::vector<AllanRecording> recordings;
  std::array<AllanAxis, 6> axes;
  ImuSensor sensor;
  std::vector<std::string> sensor_remarks;  ///< the origin of the sensor file's values, one line each
  std::vector<std::string> warnings;        ///< what the user should know first
  std::vector<std::string> undetermined;    ///< what recordings of this length do not determine
};

/// The input of `allan`: logs, or a configuration.
struct AllanRequest {
  std::vector<AllanSource> sources;
  AllanOptions options;
};

/// Guesses the format of each file, or reads the configuration if there is a single file and it is YAML
/// (docs/allan.md). Throws ConfigError if the configuration is wrong or a file is missing, DataError if a file is no
/// log of an IMU.
AllanRequest read_allan_request(const std::vector<std::string>& files);

/// Reads the configuration alone. Throws ConfigError `FILE:LINE: …`, DataError as above.
AllanRequest read_allan_config(const Config& config);

/// Reads `tune.json`. Throws ConfigError if the file is no `tune.json`.
NoiseInMotion read_tuned(const std::string& file);

/// Reads the recordings, leaves out motion, and fits each axis. Throws DataError if a file has no stationary stretch of
/// `shortest_rest`, if the unit of its forces is wrong, or if the rates of several files differ.
AllanFindings find_noise(const AllanRequest& request, const ProgressCallback& progress = {});

}  // namespace piste
