#include "report/study_page_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "piste/math/statistics.h"
#include "piste/study/study_tables.h"
#include "plot/markup.h"
#include "report/page.h"
#include "report/study_words.h"

namespace piste {
namespace {

using page::Row;
using page::wide;
using study_words::axis_name;
using study_words::by_score;
using study_words::digits;
using study_words::interval;
using study_words::kNone;
using study_words::number;
using study_words::probability;
using study_words::title_of;
using study_words::triad_of;

constexpr int kBiasDecimals = 4, kScaleDecimals = 5, kPrintedDecimals = 3;

std::string paragraph(const std::string& text) { return "<p>" + escape_markup(text) + "</p>\n"; }

/// The unit of a bias; a scale is a ratio.
std::string_view unit_of(StudyQuantity quantity, int axis) {
  return quantity == StudyQuantity::kBias ? triad_of(axis).unit : "ratio";
}

std::string starred(const Across& a) { return probability(a.p_holm) + (a.significant ? " *" : ""); }

/// The article's number for an axis of a sensor, as text. Empty if it has none.
std::string printed_text(const Study& study, const PrintedTable& table, std::size_t sensor, int axis,
                         double Printed::*part = &Printed::value, int decimals = kPrintedDecimals) {
  const PrintedRow* row = study.article ? study.article->row(table, study.sensors[sensor]) : nullptr;
  const double value = row ? (*row)[static_cast<std::size_t>(axis)].*part : kNaN;
  return std::isfinite(value) ? decimal(value, decimals) : "";
}

/// The article's table if it has a number for a sensor of the campaign; else null, and the page omits it.
const PrintedTable* article_table(const Study& study, PrintedTable CampaignTables::*which) {
  if (!study.article) return nullptr;
  const PrintedTable& table = study.article->article.tables.*which;
  const bool any = !table.empty() && std::ranges::any_of(study.sensors, [&](const std::string& sensor) {
    return study.article->row(table, sensor) != nullptr;
  });
  return any ? &table : nullptr;
}

/// The lines of a table: first the single IMUs, then the fused IMU. Holm's correction is over each of the two groups
/// alone, because the fused IMU adds no information to that of the single ones.
template <class LinesOf>
std::vector<Row> with_all_as_one(const Study& study, LinesOf&& lines_of) {
  std::vector<Row> out = lines_of(study);
  if (study.as_one.empty()) return out;
  for (Row& line : lines_of(of_all_as_one(study))) out.push_back(std::move(line));
  return out;
}

std::vector<Row> estimate_lines(const Study& study, Method method, StudyQuantity quantity,
                                const PrintedTable* printed) {
  const int decimals = quantity == StudyQuantity::kBias ? kBiasDecimals : kScaleDecimals;
  std::vector<Row> lines;
  for (const AcrossRow& row : table_of(study, method, quantity)) {
    const Across& a = row.value;
    Row line{axis_name(study, row.sensor, row.axis),
             std::string(unit_of(quantity, row.axis)),
             fmt::format("{}", a.runs),
             number(a.mean, decimals),
             digits(a.std),
             digits(a.standard_error),
             digits(a.within),
             digits(a.formal),
             probability(a.p_value),
             starred(a)};
    if (method == Method::kJoint) line.push_back(number(row.reverse, decimals));
    if (study.simulated) line.push_back(row.truth ? decimal(*row.truth, decimals) : std::string(kNone));
    if (printed) {
      line.push_back(printed_text(study, *printed, row.sensor, row.axis));
      line.push_back(printed_text(study, *printed, row.sensor, row.axis, &Printed::std));
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

std::string estimate_table(const Study& study, const std::string& caption, Method method, StudyQuantity quantity,
                           const PrintedTable* printed = nullptr) {
  if (table_of(study, method, quantity).empty()) return paragraph(caption + ": no estimate.");
  const bool joint = method == Method::kJoint;
  Row head{"sensor, axis",
           "unit",
           "runs",
           quantity == StudyQuantity::kBias ? "bias'" : "scale'",
           "std between runs",
           "error of the mean",
           "error within a run",
           "formal",
           "p",
           "p, Holm"};
  if (joint) head.emplace_back("reverse");
  if (study.simulated) head.emplace_back("put in");
  if (printed) head.insert(head.end(), {"article, " + printed->name, "its std"});
  return wide(page::table(caption, head, with_all_as_one(study, [&](const Study& of) {
                            return estimate_lines(of, method, quantity, printed);
                          })));
}

Row before_after_line(const Study& study, const BeforeAfterRow& row) {
  const Across& d = row.difference;
  return {axis_name(study, row.sensor, row.axis),
          std::string(triad_of(row.axis).unit),
          fmt::format("{}", d.runs),
          decimal(row.before, kBiasDecimals),
          decimal(row.after, kBiasDecimals),
          decimal(d.mean, kBiasDecimals),
          digits(d.std),
          digits(d.standard_error),
          digits(d.within),
          probability(d.p_value),
          starred(d)};
}

std::string before_after_table(const Study& study) {
  const std::string caption = "Table 2. Biases at rest, before the start and after the stop";
  if (before_after(study).empty()) return paragraph(caption + ": no run has both.");
  const PrintedTable* before = article_table(study, &CampaignTables::before);
  const PrintedTable* after = article_table(study, &CampaignTables::after);
  Row head{"sensor, axis",
           "unit",
           "runs",
           "before",
           "after",
           "after − before",
           "std between runs",
           "error of the mean",
           "error within a run",
           "p",
           "p, Holm"};
  if (before && after) head.insert(head.end(), {fmt::format("article, {}: before", before->name), "after"});
  return wide(page::table(caption, head, with_all_as_one(study, [&](const Study& of) {
                            std::vector<Row> lines;
                            for (const BeforeAfterRow& row : before_after(of)) {
                              lines.push_back(before_after_line(of, row));
                              if (!before || !after) continue;
                              lines.back().push_back(printed_text(of, *before, row.sensor, row.axis));
                              lines.back().push_back(printed_text(of, *after, row.sensor, row.axis));
                            }
                            return lines;
                          })));
}

std::string correlation_table(const Study& study) {
  const std::string caption = "Table 5. Correlation of bias and scale, IMU on reference";
  if (correlations(study).empty()) return paragraph(caption + ": no estimate.");
  const PrintedTable* printed = article_table(study, &CampaignTables::correlation);
  Row head{"sensor, axis", "correlation", "lowest", "highest", "variances larger by"};
  if (printed) head.push_back("article, " + printed->name);
  return wide(
      page::table(caption, head, with_all_as_one(study, [&](const Study& of) {
                    std::vector<Row> lines;
                    for (const CorrelationRow& row : correlations(of)) {
                      lines.push_back({axis_name(of, row.sensor, row.axis), decimal(row.correlation, 2),
                                       decimal(row.lowest, 2), decimal(row.highest, 2), decimal(row.inflation, 1)});
                      if (!printed) continue;
                      lines.back().push_back(printed_text(of, *printed, row.sensor, row.axis, &Printed::value, 2));
                    }
                    return lines;
                  })));
}

std::string ranking_table(const Ranking& ranking) {
  const std::string caption = "Table 7. Navigation that each estimate leads to, best first";
  if (ranking.rows.empty()) return paragraph(caption + ": no replay was scored.");
  std::vector<Row> lines;
  const std::vector<RankingRow> first = leaders(ranking);
  for (const RankingRow& row : by_score(ranking)) {
    const bool wins = ranking.winner == row.method;
    const bool leads = std::ranges::find(first, row.method, &RankingRow::method) != first.end();
    const MethodInfo& m = info(row.method);
    const auto size = [](double value) { return value > 0 ? digits(value, 3) : std::string(kNone); };
    const char* place = !leads                ? (m.competes ? "" : " (for comparison)")
                        : first.size() > 1    ? " (tie)"
                        : has_winner(ranking) ? " (winner)"
                                              : " (lowest)";
    lines.push_back({title_of(row.method) + place, std::string(m.estimates), size(row.position_rmse),
                     size(row.velocity_rmse), size(kDegreesPerRadian * row.attitude_rmse), size(row.outage_drift),
                     fmt::format("{:.3f}", row.score), fmt::format("{:.2f}", row.versus_winner),
                     wins ? std::string(kNone) : interval(row), wins ? std::string(kNone) : probability(row.p_holm)});
  }
  return wide(page::table(caption,
                          {"method", "estimates", "position [m]", "velocity [m/s]", "attitude [°]",
                           "drift without GNSS [m]", "score", "over the lowest", "95 %", "p, Holm"},
                          lines));
}

std::string cross_axis_table(const Study& study) {
  const std::string caption = "Cross-axis errors, with the accelerometers' axes as those of the body";
  const std::vector<CrossAxisRow> rows = cross_axis(study);
  if (rows.empty()) return paragraph(caption + ": no estimate.");
  std::vector<Row> lines;
  lines.reserve(rows.size());
  for (const CrossAxisRow& row : rows) {
    const Across& a = row.value;
    lines.push_back({fmt::format("{} {}", axis_name(study, row.sensor, row.axis), row.element),
                     fmt::format("{}", a.runs), number(a.mean, kScaleDecimals), digits(a.std), digits(a.standard_error),
                     digits(a.within), probability(a.p_value), starred(a)});
  }
  return wide(page::table(caption,
                          {"sensor, axis, element", "runs", "correction", "std between runs", "error of the mean",
                           "error within a run", "p", "p, Holm"},
                          lines));
}

std::string scale_scatter_table(const Study& study) {
  const std::string caption = "Scatter of scales between runs, and how much of it cross-axis errors explain";
  const std::vector<ScaleScatter> rows = scale_scatter(study);
  if (rows.empty()) return paragraph(caption + ": fewer than two runs.");
  std::vector<Row> lines;
  lines.reserve(rows.size());
  for (const ScaleScatter& row : rows) {
    lines.push_back({axis_name(study, row.sensor, row.axis), fmt::format("{}", row.runs), digits(row.alone),
                     digits(row.with_cross_axis), number(100 * row.explained, 0) + " %"});
  }
  return wide(page::table(
      caption, {"sensor, axis", "runs", "std, scale alone", "std, with cross-axis errors", "explained"}, lines));
}

/// Comparison of the IMUs, and of the fused IMU.
std::string imus_table(const Study& study) {
  const std::string caption =
      "The IMUs compared, and all as one: navigation of a replay that estimates the errors of its IMU itself";
  const std::vector<ImuCompared> rows = imus_compared(study);
  if (rows.empty()) return paragraph(caption + ": no replay was scored.");
  std::vector<Row> lines;
  lines.reserve(rows.size());
  for (const ImuCompared& row : rows) {
    lines.push_back({row.name, fmt::format("{}", row.runs), digits(row.position_rmse, 3), digits(row.velocity_rmse, 3),
                     digits(kDegreesPerRadian * row.attitude_rmse, 3), digits(row.outage_drift, 3),
                     number(row.attitude_over_single, 2), number(row.drift_over_single, 2)});
  }
  return wide(page::table(caption,
                          {"IMU", "runs", "position [m]", "velocity [m/s]", "attitude [°]", "drift without GNSS [m]",
                           "attitude over the mean of the single ones", "drift over it"},
                          lines));
}

std::string article_words(const Study& study) {
  if (!study.article || study.article->counterparts.empty()) return {};
  return fmt::format(" The columns “article” are what {} prints of other devices than those of this campaign.",
                     escape_markup(study.article->article.title));
}

}  // namespace

std::string study_page_tables(const Study& study, const Ranking& ranking) {
  const auto estimates = [&](const char* caption, Method method, StudyQuantity quantity,
                             PrintedTable CampaignTables::*printed) {
    return estimate_table(study, caption, method, quantity, article_table(study, printed));
  };
  return "<p class=\"soft\">Corrections to add, m/s² and °/s; * significant at 5 % after Holm's correction over the "
         "table." +
         article_words(study) + "</p>\n" +
         estimates("Table 1. Biases at rest before the start", Method::kRest, StudyQuantity::kBias,
                   &CampaignTables::rest) +
         before_after_table(study) +
         estimates("Table 3. Biases in the run, with scales", Method::kJoint, StudyQuantity::kBias,
                   &CampaignTables::joint_bias) +
         estimates("Table 4. Scales in the run", Method::kJoint, StudyQuantity::kScale, &CampaignTables::joint_scale) +
         correlation_table(study) +
         estimates("Table 6. Biases in the run, without scales", Method::kBiasOnly, StudyQuantity::kBias,
                   &CampaignTables::bias_only) +
         estimate_table(study, "Biases by Gauss-Markov in the GPS/MEMS filter", Method::kMarkovFiltered,
                        StudyQuantity::kBias) +
         cross_axis_table(study) + scale_scatter_table(study) + ranking_table(ranking) + imus_table(study);
}

}  // namespace piste
