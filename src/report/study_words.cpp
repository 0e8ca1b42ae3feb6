#include "report/study_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "piste/math/statistics.h"
#include "plot/markup.h"

namespace piste::study_words {
double half_width(const Across& a) {
  const double dof = a.runs > 1 ? static_cast<double>(a.runs - 1) : std::numeric_limits<double>::infinity();
  return a.standard_error * student_quantile(1 - kSignificance / 2, dof);
}

std::string counted(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

std::string runs_of(const std::vector<AcrossRow>& rows) {
  if (rows.empty()) return "no run";
  const auto [least, most] = std::minmax_element(
      rows.begin(), rows.end(), [](const AcrossRow& a, const AcrossRow& b) { return a.value.runs < b.value.runs; });
  const std::size_t low = least->value.runs, high = most->value.runs;
  return low == high ? counted(high, "run") : fmt::format("{} to {} runs", low, high);
}

std::vector<AcrossRow> of(const Triad& triad, std::vector<AcrossRow> rows) {
  std::erase_if(rows, [&](const AcrossRow& row) { return !triad.has(row.axis); });
  return rows;
}

std::string number(double value, int decimals) {
  return std::isfinite(value) ? decimal(value, decimals) : std::string(kNone);
}

std::string axis_name(const Study& study, std::size_t sensor, int axis) {
  return fmt::format("{} {}", study.sensors[sensor], kSignalNames[static_cast<std::size_t>(axis)]);
}

std::string title_of(Method method) { return std::string(info(method).title); }

std::string interval(const RankingRow& row) {
  return std::isfinite(row.low) ? fmt::format("{:.2f} to {:.2f}", row.low, row.high) : std::string(kNone);
}

std::string digits(double size, int count) {
  if (!std::isfinite(size)) return std::string(kNone);
  return decimal(size, size > 0 ? std::clamp(count - 1 - static_cast<int>(std::floor(std::log10(size))), 0, 7) : 0);
}

std::string probability(double p) {
  if (!std::isfinite(p)) return std::string(kNone);
  return p < 0.001 ? "< 0.001" : fmt::format("{:.3f}", p);
}

std::string percent(double share) { return fmt::format("{:.0f} %", 100 * share); }

std::string band_of(const Study& study) {
  return study.low_pass > 0 ? fmt::format("below {:.4g} Hz", study.low_pass) : std::string("unfiltered");
}

std::vector<RankingRow> by_score(const Ranking& ranking) {
  std::vector<RankingRow> rows = ranking.rows;
  std::ranges::stable_sort(rows, {}, &RankingRow::score);
  return rows;
}

}  // namespace piste::study_words
