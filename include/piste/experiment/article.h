#pragma once
/// A published campaign: what the tables of its article print, from a file such as config/articles/bonnaz_2008.yaml.
///
/// Values are corrections to add, true = (1 + scale') measured + bias', in m/s² and °/s; axes are fx fy fz wx wy wz.

#include <array>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "piste/experiment/signals.h"

namespace piste {

/// A printed number: value, standard deviation, and how far rounding may have moved the value; NaN where there is none.
struct Printed {
  double value = std::numeric_limits<double>::quiet_NaN(), std = std::numeric_limits<double>::quiet_NaN();
  double rounding = 0;
};
using PrintedRow = std::array<Printed, kSignals>;

struct PrintedTable {
  std::string name;                 ///< such as "Table 1"
  std::vector<PrintedRow> sensors;  ///< one each, and of NaN where the table does not have that sensor

  /// Whether it has any number.
  bool empty() const;
};

/// What a campaign came to, over its runs.
struct CampaignTables {
  PrintedTable rest;                     ///< bias at rest before the start
  PrintedTable before, after;            ///< the same of runs that have a rest before and one after
  PrintedTable joint_bias, joint_scale;  ///< both in the run
  PrintedTable correlation;              ///< of these two
  PrintedTable bias_only;                ///< bias alone in the run
};

/// What an article says of its numbers, in its own words or about them. Empty where it says nothing.
struct ArticleRemarks {
  std::string mean_signal;    ///< of the mean signal that biases and scales imply
  std::string correlation;    ///< of the spread that correlations imply
  std::string significance;   ///< of its rule for significance
  std::string scale_at_rest;  ///< of the influence of scales at rest
};

struct Article {
  std::string title;                 ///< author, title, journal
  std::optional<std::size_t> runs;   ///< of which its numbers are means; nothing where it does not say
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

/// An article, and which of its sensors a campaign's own are held against.
struct ArticleBeside {
  Article article;
  std::map<std::string, std::size_t> counterparts;  ///< by the campaign's name of a sensor: place in Article::sensors

  /// What `table` prints of the counterpart of that sensor; null where it has none.
  const PrintedRow* row(const PrintedTable& table, const std::string& sensor) const;
};

}  // namespace piste
