#pragma once
/// The stochastic model of an IMU from recordings at rest: `allan`.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "piste/allan/sensor_noise.h"
#include "piste/core/log.h"
#include "piste/io/config.h"
#include "piste/io/log_io.h"
#include "piste/math/statistics.h"
#include "piste/solve/run.h"

namespace piste {

/// Names of the six axes: gyro_x … accel_z.
inline constexpr std::array<std::string_view, 6> kAllanAxes{"gyro_x",  "gyro_y",  "gyro_z",
                                                            "accel_x", "accel_y", "accel_z"};

/// One recording, and how it was understood.
struct AllanSource {
  LogFile log;
  std::string why;                       ///< what shows its format
  std::vector<std::string> doubts = {};  ///< what the user should check
};

/// The white noise that `tune` finds in motion.
struct NoiseInMotion {
  std::string file;
  std::optional<Measured> gyro, accel;
};

struct AllanOptions {
  std::string name = "IMU at rest";    ///< of the sensor
  std::optional<ImuSensor> base = {};  ///< gives bias, scale and range; without it they are guessed
  std::string base_file = {};          ///< its file
  std::optional<NoiseInMotion> tuned = {};
  bool robust = false;   ///< bound what outliers do
  bool at_rest = false;  ///< take all rows as at rest
  GmwmOptions fit = {};
  std::size_t jobs = 1;             ///< fits at a time; the results do not depend on it
  double longest_disturbance = 10;  ///< s of motion that do not end a stretch: a knock, a hand
  double shortest_rest = 60;        ///< s that the IMU must rest at least
  std::size_t longest_hole = 10;    ///< missing rows that a straight line bridges
};

/// What was read of one file.
struct AllanRecording {
  AllanSource source;
  std::size_t rows = 0, refused = 0;      ///< rows read, and rows that could not be
  std::string first_refused;              ///< why
  double interval = 0, jitter = 0;        ///< s
  double span = 0;                        ///< from the first to the last row [s]
  std::size_t gaps = 0, missing = 0;      ///< and rows missing in them
  std::size_t filled = 0;                 ///< of these, rows that a straight line bridged
  std::vector<Interval> stretches;        ///< that were used, without a gap or motion
  double moving = 0;                      ///< s left out as the IMU moved
  std::size_t disturbances = 0;           ///< short motions that were not left out
  bool rest_checked = true;               ///< false: rows are too rare to tell
  std::array<std::size_t, 6> outliers{};  ///< samples beyond six sigmas: replaced if robust, else only counted
  std::array<double, 6> step{};           ///< of which all values are multiples; 0: none
  std::array<AllanCurve, 6> curves;
  std::optional<std::array<double, 2>> temperature;  ///< lowest and highest [°C]
  double used() const;                               ///< s
};

/// One unit beside the others of its type.
struct AllanUnit {
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
  double step = 0, rounding = 0;  ///< of the values; its white noise [unit/√Hz]
  std::vector<AllanUnit> units;   ///< one for each recording, if there are several: the model of all, fitted to it
  double spread = kNaN, spread_instability = kNaN;  ///< of noise and bias instability between units, of the logarithm
};

/// All that was found.
struct AllanFindings {
  AllanOptions options;
  std::vector<AllanRecording> recordings;
  std::array<AllanAxis, 6> axes;
  ImuSensor sensor;
  std::vector<std::string> sensor_remarks;  ///< how the sensor file came about, one line each
  std::vector<std::string> warnings;        ///< what the user should know first
  std::vector<std::string> undetermined;    ///< what recordings of this length do not tell
};

/// What `allan` was told: logs, or a configuration.
struct AllanRequest {
  std::vector<AllanSource> sources;
  AllanOptions options;
};

/// Guesses the format of each file, or reads the configuration if there is one file and it is YAML (docs/allan.md).
/// Throws ConfigError where the configuration is wrong or a file is missing, DataError where a file is no log of an
/// IMU.
AllanRequest read_allan_request(const std::vector<std::string>& files);

/// Reads the configuration alone. Throws ConfigError `FILE:LINE: …`, DataError as above.
AllanRequest read_allan_config(const Config& config);

/// Reads `tune.json`. Throws ConfigError if it is none.
NoiseInMotion read_tuned(const std::string& file);

/// Reads the recordings, leaves out what moves, and fits each axis. Throws DataError where a file has no rest of
/// `shortest_rest`, where the unit of its forces is wrong, or where rates of several files differ.
AllanFindings find_noise(const AllanRequest& request, const ProgressCallback& progress = {});

}  // namespace piste
