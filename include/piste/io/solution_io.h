#pragma once
/// The output files of a replay, as text or as numbers. Equal solutions give equal bytes.

#include <memory>
#include <string>
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

/// The files of rows that a replay writes.
enum class RowFile { kNavigation, kBiases, kAttitude };

/// Writes one of these files from rows that come in pieces, in their order. The bytes are those of one single piece.
class RowCsv {
 public:
  /// `rate` [Hz]: rows that are nearest to the multiples of 1 / rate; 0: all.
  RowCsv(RowFile kind, const StateLayout& layout, double rate, TextSink sink);
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

/// `filtered.csv`, `smoothed.csv`: geodetic position, velocity in local north-east-down, angles, and their sigmas.
std::string navigation_csv(const Solution& solution);
/// The same at a rate [Hz], 0 being that of the IMU, piece by piece.
void navigation_csv(const Solution& solution, double rate, const TextSink& sink);
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
