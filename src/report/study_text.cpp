#include "report/study_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "piste/math/statistics.h"
#include "piste/report/markup.h"

namespace piste::study_text {

double half_width(const Across& a) {
  const double dof = a.runs > 1 ? static_cast<double>(a.runs - 1) : std::numeric_limits<double>::infinity();
  return a.standard_error * student_quantile(1 - kSignificance / 2, dof);
}

std::string runs_of(const std::vector<AcrossRow>& rows) {
  if (rows.empty()) return "no run";
  const auto [least, most] = std::minmax_element(
      rows.begin(), rows.end(), [](const AcrossRow& a, const AcrossRow& b) { return a.value.runs < b.value.runs; });
  const std::size_t low = least->value.runs, high = most->value.runs;
  return low == high ? fmt::format("{} run{}", high, high == 1 ? "" : "s") : fmt::format("{} to {} runs", low, high);
}

std::vector<AcrossRow> of(const Triad& triad, std::vector<AcrossRow> rows) {
  std::erase_if(rows, [&](const AcrossRow& row) { return !triad.has(row.axis); });
  return rows;
}

std::string rounded(double value, double sigma) {
  if (!std::isfinite(value)) return "–";
  const bool known = std::isfinite(sigma) && sigma > 0;
  return decimal(value, known ? std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 7) : 5);
}

std::string sigma_text(double sigma) { return rounded(sigma, sigma); }

std::string probability(double p) {
  if (!std::isfinite(p)) return "–";
  return p < 0.001 ? "< 0.001" : fmt::format("{:.3f}", p);
}

std::string percent(double share) { return fmt::format("{:.0f} %", 100 * share); }

}  // namespace piste::study_text
