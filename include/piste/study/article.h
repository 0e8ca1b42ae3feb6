#pragma once
/// The printed tables of a published campaign, from a file such as config/articles/bonnaz_2008.yaml. `study` shows them
/// next to the tables of a user's campaign.
///
/// Values are corrections to add, true = (1 + scale') measured + bias', in m/s² and °/s; axes are fx fy fz wx wy wz.

#include <array>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "piste/math/statistics.h"
#include "piste/study/signals.h"

namespace piste {

/// A printed number: its value, its standard deviation, and the largest rounding error of the value. NaN if it is not
/// printed.
struct Printed {
  double value = kNaN, std = kNaN;
  double rounding = 0;
};
using PrintedRow = std::array<Printed, kSignals>;

struct PrintedTable {
  std::string name;                 ///< such as "Table 1"
  std::vector<PrintedRow> sensors;  ///< one for each sensor; NaN if the table does not have the sensor

  /// Whether the table has no number at all.
  bool empty() const;
};

/// The tables of a campaign: means and standard deviations over its runs.
struct CampaignTables {
  PrintedTable rest;                     ///< bias at rest before the start
  PrintedTable before, after;            ///< bias at rest, over the runs that have a rest before and one after
  PrintedTable joint_bias, joint_scale;  ///< estimated jointly in the run
  PrintedTable correlation;              ///< correlation of joint_bias and joint_scale
  PrintedTable bias_only;                ///< bias alone in the run
};

/// Remarks about the numbers of an article. Empty if there is none.
struct ArticleRemarks {
  std::string mean_signal;    ///< on the mean signal that biases and scales imply
  std::string correlation;    ///< on the spread that correlations imply
  std::string significance;   ///< on its rule for significance
  std::string scale_at_rest;  ///< on the influence of scales at rest
};

/// A published campaign.
struct Article {
  std::string title;                 ///< author, title, journal
  std::optional<std::size_t> runs;   ///< number of runs that its numbers average, if stated
  std::vector<std::string> sensors;  ///< their names
  CampaignTables tables;             ///< in the order of `sensors`
  ArticleRemarks remarks;
};

/// Reads and checks the file of an article:
/// ```yaml
/// title: Author, title, journal
/// sensors: [sensor 1, sensor 2]
/// runs: 9                         # optional, as are all tables and remarks
/// tables:                         # rest, before, after, joint_bias, joint_scale, correlation, bias_only
///   rest:
///     name: Table 1
///     significant_digits: 2       # optional: trailing zeros beyond them are no digits
///     rows:                       # a sensor that a table does not have is left out of it
///       - {sensor: sensor 1, accel: 0.034 -0.087 -0.021 m/s^2, accel_std: 0.020 0.100 0.024 m/s^2,
///          gyro: -0.072 0.170 1.000 deg/s, gyro_std: 0.076 0.076 0.160 deg/s}   # the std is optional
/// remarks: {mean_signal: text, correlation: text, significance: text, scale_at_rest: text}
/// ```
/// Throws ConfigError `FILE:LINE: …`.
Article read_article(const std::filesystem::path& file);

/// An article, and which of its sensors correspond to sensors of a campaign.
struct ArticleBeside {
  Article article;
  std::map<std::string, std::size_t> counterparts;  ///< index in Article::sensors, by the campaign's name

  /// The row of `table` for the counterpart of a sensor, or null if there is none.
  const PrintedRow* row(const PrintedTable& table, const std::string& sensor) const;
};

}  // namespace piste
