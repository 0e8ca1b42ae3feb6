#include "report/study_matrices.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "piste/study/study_tables.h"
#include "report/page.h"
#include "report/study_words.h"

namespace piste {
namespace {

using page::Row;
using page::wide;
using study_words::kNone;
using study_words::kTriads;
using study_words::Triad;

/// The difference a − b over sensors and axes.
struct Cell {
  double difference = 0, error = 0;  ///< rms of the differences, and rms of their standard errors
  std::size_t count = 0;
  bool significant = false;
};

std::string short_text(double size) { return fmt::format("{:.{}f}", size, size < 1 ? 2 : size < 10 ? 1 : 0); }

std::string matrix(const std::vector<Comparison>& all, StudyQuantity quantity, const Triad& triad) {
  constexpr std::size_t n = kMethods.size();
  std::array<std::array<Cell, n>, n> cells{};
  std::array<bool, n> seen{};
  for (const Comparison& c : all) {
    if (!triad.has(c.axis)) continue;
    const auto a = static_cast<std::size_t>(c.a), b = static_cast<std::size_t>(c.b);
    Cell& cell = cells[a][b];
    cell.difference += c.difference.mean * c.difference.mean;
    cell.error += c.difference.standard_error * c.difference.standard_error;
    cell.significant = cell.significant || c.difference.significant;
    ++cell.count;
    seen[a] = seen[b] = true;
  }
  Row head{quantity == StudyQuantity::kBias ? fmt::format("[10⁻³ {}]", triad.unit) : std::string("[10⁻³]")};
  std::vector<Row> rows;
  for (std::size_t a = 0; a < n; ++a) {
    if (!seen[a]) continue;
    head.push_back(fmt::format("{}", a));
    Row row{fmt::format("{} {}", a, kMethods[a].title)};
    for (std::size_t b = 0; b < n; ++b) {
      if (!seen[b]) continue;
      const Cell& cell = cells[std::min(a, b)][std::max(a, b)];
      if (cell.count == 0) {
        row.emplace_back(a == b ? "" : kNone);
        continue;
      }
      const double square = (a < b ? cell.difference : cell.error) / static_cast<double>(cell.count);
      row.push_back(short_text(1e3 * std::sqrt(square)) + (a < b && cell.significant ? "*" : ""));
    }
    rows.push_back(std::move(row));
  }
  if (rows.empty()) return {};
  const char* what = quantity == StudyQuantity::kBias ? "Bias'" : "Scale'";
  return "<div class=\"matrix\">\n" + wide(page::table(fmt::format("{} of the {}", what, triad.name), head, rows)) +
         "</div>\n";
}

}  // namespace

std::string study_matrices(const Study& study) {
  std::string out =
      "<p>Root mean square over sensors and axes of the mean difference of two methods: above the diagonal the "
      "difference, below it its standard error. * at least one of them is significant at 5 % after Holm's correction. ";
  out += study.simulated ? "The last column is the difference to what was put in, as each method could see it. " : "";
  out += "Every single difference stands in comparisons.csv.</p>\n";
  for (const StudyQuantity quantity : {StudyQuantity::kBias, StudyQuantity::kScale}) {
    const std::vector<Comparison> all = comparisons(study, quantity);
    for (const Triad& triad : kTriads) out += matrix(all, quantity, triad);
  }
  return out;
}

}  // namespace piste
