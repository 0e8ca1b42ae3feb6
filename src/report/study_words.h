#pragma once
/// Words and numbers that the figures and the page of a study share.

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "piste/study/ranking.h"
#include "piste/study/study_tables.h"

namespace piste::study_words {

/// Accelerometers or gyroscopes.
struct Triad {
  std::string_view stem, name, unit;
  int first;  ///< axis

  bool has(int axis) const { return axis >= first && axis < first + 3; }
};
inline constexpr std::array<Triad, 2> kTriads{
    {{"accel", "accelerometers", "m/s²", 0}, {"gyro", "gyroscopes", "°/s", 3}}};
constexpr const Triad& triad_of(int axis) { return kTriads[axis < 3 ? 0 : 1]; }

constexpr std::size_t at(int axis) { return static_cast<std::size_t>(axis); }

/// Half the width of the 95 % interval of the mean.
double half_width(const Across& across);

/// The text for a missing number.
inline constexpr std::string_view kNone = "–";

/// "1 run", "3 runs".
std::string counted(std::size_t count, std::string_view what);

/// The number of runs that the rows average: "3 runs", "2 to 4 runs".
std::string runs_of(const std::vector<AcrossRow>& rows);

/// The rows of a triad.
std::vector<AcrossRow> of(const Triad& triad, std::vector<AcrossRow> rows);

/// A number, or kNone if it is NaN.
std::string number(double value, int decimals);

/// "MT-9A 1 fx".
std::string axis_name(const Study& study, std::size_t sensor, int axis);

/// The name of a method on pages.
std::string title_of(Method method);

/// The interval of a row of a ranking, such as "0.98 to 1.07", or kNone.
std::string interval(const RankingRow& row);

/// The significant digits of a sigma, or more; kNone if it is NaN.
std::string digits(double size, int count = 2);

/// A p-value, such as "0.034" or "< 0.001".
std::string probability(double p);

/// A share in per cent: "93 %" for 0.934.
std::string percent(double share);

/// The band of both signals, such as "below 12 Hz".
std::string band_of(const Study& study);

/// The rows of a ranking, the best first.
std::vector<RankingRow> by_score(const Ranking& ranking);

}  // namespace piste::study_words
