#pragma once
/// The output files of a replay, as text or as numbers. Equal solutions give equal bytes.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/solution.h"
#include "piste/io/text_sink.h"

namespace piste {

/// The numbers of such a file in full, row by row, under the names of its columns.
struct NumberTable {
  std::vector<std::string> names;
  std::vector<double> values;
};

/// The time that a file of rows has in addition to time_s.
enum class RowTime {
  kSeconds,  ///< none
  kGpsWeek,  ///< `gps_week`
  kUtc,      ///< `time_utc`, such as 2022-03-09T11:59:42.500000Z
  kUnix      ///< `time_unix_s`
};

/// Columns that the files of navigation have besides, behind the usual ones.
struct RowExtras {
  RowTime time = RowTime::kSeconds;
  std::optional<int> week = std::nullopt;  ///< GPS week of time_s; @pre known if `time` needs it
  bool sea_height = false;                 ///< `height_sea_m`, above EGM96
  bool enu = false;                        ///< `east_m, north_m, up_m` from the origin of the run, in its level
  bool ecef = false;                       ///< `ecef_{x,y,z}_m`
  bool utm = false;  ///< `utm_easting_m, utm_northing_m, utm_zone` of the zone of the first row; south: negative zone
  std::vector<int> epsg = {};  ///< `epsg_CODE_easting_m, epsg_CODE_northing_m` of each code
  bool speed = false;          ///< `speed_m_s, course_deg`, horizontal
  bool acceleration = false;   ///< `acceleration_{north,east,down}_m_s2` over the ground, needs `motion`
  bool rates = false;          ///< `rate_{x,y,z}_deg_s, force_{x,y,z}_m_s2`, without the IMU's errors, needs `motion`
  /// Angular rate and specific force of the body at a row, without the IMU's errors.
  std::function<std::pair<Vector3d, Vector3d>(double time, const Estimate& x)> motion = {};

  bool needs_log() const { return acceleration || rates; }
  bool any() const {
    return time != RowTime::kSeconds || sea_height || enu || ecef || utm || !epsg.empty() || speed || needs_log();
  }
};

/// The files of rows that a replay writes.
enum class RowFile { kNavigation, kBiases, kAttitude };

/// Writes one of these files from rows that come in pieces, in their order. The bytes are those of one single piece.
class RowCsv {
 public:
  /// `rate` [Hz]: rows that are nearest to the multiples of 1 / rate; 0: all.
  RowCsv(RowFile kind, const StateLayout& layout, double rate, TextSink sink, const RowExtras& extras = {});
  ~RowCsv();
  RowCsv(RowCsv&&) noexcept;
  RowCsv& operator=(RowCsv&&) noexcept;
  /// @pre of the same run as the rows before, and after them
  void add(const Solution& rows);
  /// Writes the last row, which waits for its successor. Nothing may be added afterwards.
  void finish();

 private:
  struct Writer;
  std::unique_ptr<Writer> writer_;
};

/// Writes rows in the columns of smoothed.csv for any point of the body.
class PlaceCsv {
 public:
  /// @pre `extras` needs no motion
  PlaceCsv(const RowExtras& extras, const World& world, TextSink sink);
  ~PlaceCsv();
  PlaceCsv(const PlaceCsv&) = delete;
  PlaceCsv& operator=(const PlaceCsv&) = delete;
  void add(double time, const Navigation& navigation, const NavigationSigmas& sigmas);
  /// Gives the remaining text to the sink.
  void finish();

 private:
  struct Writer;
  std::unique_ptr<Writer> writer_;
};

/// `filtered.csv`, `smoothed.csv`: geodetic position, velocity in local north-east-down, angles, and their sigmas.
std::string navigation_csv(const Solution& solution);
/// The same at a rate [Hz], 0 being that of the IMU, piece by piece.
void navigation_csv(const Solution& solution, double rate, const TextSink& sink, const RowExtras& extras = {});
NumberTable navigation_table(const Solution& solution, double rate = 0);

/// Roll, pitch and heading in local north-east-down with their sigmas, as a reference attitude for another replay. It
/// has the epochs nearest to the multiples of 1 / rate [Hz], or all epochs if there are fewer. The name of its file is
/// empty.
AttitudeRecording attitude_recording(const Solution& solution, double rate);

/// `attitude.csv`: the same as text, which another replay reads by its key `attitude`.
std::string attitude_csv(const Solution& solution, double rate);

/// `biases.csv`, `biases_smoothed.csv`: every estimated block beyond navigation, axis by axis in the units of kBlocks,
/// such as `gyro_bias_x_deg_s`, and its sigmas, such as `sigma_gyro_bias_x_deg_s`. The boresight stands as roll, pitch
/// and heading of R_rb. Last come the sums of bias and drift, `gyro_total_bias_*` and `accel_total_bias_*`.
std::string biases_csv(const Solution& solution);
void biases_csv(const Solution& solution, double rate, const TextSink& sink);
NumberTable biases_table(const Solution& solution, double rate = 0);

/// `adapted.csv`: the factors of the stated sigmas that the filter estimated, one row per second.
std::string adapted_csv(const AdaptedNoise& adapted);

/// `innovations.csv`: for every measurement its residual, sigma, NIS and outcome, in SI. Cells of unmeasured quantities
/// are empty: the second and third row of a height, and all rows of a repeated fix.
std::string innovations_csv(const Solution& solution);
void innovations_csv(const Solution& solution, const TextSink& sink);

}  // namespace piste
