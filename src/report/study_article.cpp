#include "report/study_article.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>
#include <vector>

#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/study/study_tables.h"
#include "plot/markup.h"
#include "report/page.h"
#include "report/study_words.h"
#include "study/printed_tables.h"

namespace piste {
namespace {

using page::Row;
using page::wide;
using study_words::at;
using study_words::kNone;
using study_words::number;
using study_words::triad_of;

std::string axis_name(int axis) { return std::string(kSignalNames[at(axis)]); }

std::string axis_with_unit(int axis) { return fmt::format("{} [{}]", kSignalNames[at(axis)], triad_of(axis).unit); }

std::string heading(std::string_view text) { return fmt::format("<h3>{}</h3>\n", text); }

std::string p_text(double p) { return p < 1e-4 ? "< 0.0001" : fmt::format("{:.2g}", p); }

/// The article, or the campaign.
struct Source {
  std::string name;
  std::vector<std::string> sensors;
  CampaignTables tables;
  std::size_t runs;  ///< that its numbers average; at least two
};

/// The text, followed by a space.
std::string remark(const std::string& text) { return text.empty() ? "" : escape_markup(text) + " "; }

// ---- Tables 3, 4 and 6 are one data set ----

std::string between(const Band& band) { return fmt::format("{} to {}", decimal(band.low, 2), decimal(band.high, 2)); }

/// Whether the numbers are rounded. Exact numbers imply one mean each, and no bounds.
bool rounded(const ImpliedMeans& means) {
  return std::any_of(means.sensors.begin(), means.sensors.end(), [](const auto& sensor) {
    return std::any_of(sensor.begin(), sensor.end(),
                       [](const ImpliedMean& m) { return !m.bounds || m.bounds->high > m.bounds->low; });
  });
}

std::string means_table(const Source& source) {
  const ImpliedMeans means = implied_means(source.tables);
  const bool bounds = rounded(means);
  Row head{"axis"};
  head.insert(head.end(), source.sensors.begin(), source.sensors.end());
  if (bounds) head.emplace_back("all, with the rounding");
  std::vector<Row> rows;
  for (int axis = 0; axis < kSignals; ++axis) {
    Row row{axis_with_unit(axis)};
    for (const auto& sensor : means.sensors) {
      const ImpliedMean& m = sensor[at(axis)];
      row.push_back(!m.bounds ? "any" : number(m.value, 2) + (bounds ? fmt::format(" ({})", between(*m.bounds)) : ""));
    }
    const auto& common = means.common[at(axis)];
    if (bounds) row.push_back(common ? between(*common) : "contradict");
    rows.push_back(std::move(row));
  }
  return wide(page::table(fmt::format("Mean of the signal that Tables 3, 4 and 6 imply: {}", source.name), head, rows));
}

/// Middle of the range that all sensors allow. NaN if the sensors contradict one another.
std::array<double, kSignals> middles(const ImpliedMeans& means) {
  std::array<double, kSignals> out{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto& band = means.common[i];
    out[i] = band ? (band->low + band->high) / 2 : kNaN;
  }
  return out;
}

/// The mean force that the article implies, and whether it is possible.
std::string mean_force(const std::array<double, kSignals>& mean) {
  if (!std::isfinite(mean[0] + mean[1] + mean[2])) return "In the article they do not agree on a mean force. ";
  return fmt::format(
      "In the article they agree: the mean force is ({}, {}, {}) m/s², {} m/s² long, where gravity is 9.81, and such "
      "IMUs are pitched by {}°. ",
      number(mean[0], 2), number(mean[1], 2), number(mean[2], 2), number(std::hypot(mean[0], mean[1], mean[2]), 2),
      number(kDegreesPerRadian * std::atan2(mean[0], -mean[2]), 0));
}

std::string identity(const std::vector<Source>& sources, const ArticleRemarks& remarks) {
  if (sources.front().tables.joint_scale.empty() || sources.front().tables.bias_only.empty()) return {};
  std::string out =
      heading("Tables 3, 4 and 6 are of one data set") +
      "<p>Least squares pass through the mean point, so that bias alone = bias' + scale' · mean of the signal. "
      "Each sensor's three tables imply that mean, and sensors on one plate should agree on it.</p>\n";
  for (const Source& source : sources) out += means_table(source);
  return out + fmt::format("<p>{}{}</p>\n", mean_force(middles(implied_means(sources.front().tables))),
                           escape_markup(remarks.mean_signal));
}

// ---- Table 5 ----

std::string correlations_of(const Source& article, const ArticleRemarks& remarks) {
  const PrintedTable& table = article.tables.correlation;
  if (table.empty()) return {};
  const ImpliedMeans means = implied_means(article.tables);
  const auto mean = middles(means);
  Row head{"axis", "mean"};
  for (const std::string& sensor : article.sensors) head.push_back(sensor + ": spread");
  std::vector<Row> rows;
  for (int axis = 0; axis < kSignals; ++axis) {
    Row row{axis_with_unit(axis), number(mean[at(axis)], 2)};
    for (const PrintedRow& sensor : table.sensors) {
      const double correlation = sensor[at(axis)].value;
      row.push_back(
          fmt::format("{}: {}", number(correlation, 2), number(implied_spread(mean[at(axis)], correlation).std, 2)));
    }
    rows.push_back(std::move(row));
  }
  std::vector<std::string> wrong;
  for (const auto& [sensor, axis] : wrong_signs(article.tables, means)) {
    wrong.push_back(fmt::format("{} of {}", axis_name(axis), escape_markup(article.sensors[sensor])));
  }
  return heading("Table 5 and the motion") +
         "<p>The correlation of bias' and scale' is −mean / rms of the signal; with the mean above it implies the "
         "spread of the signal about its mean.</p>\n" +
         wide(page::table(
             fmt::format("Correlation in the article's {}: spread of the signal that it implies", table.name), head,
             rows)) +
         fmt::format("<p>{}The sign should be that of −mean; it is not on {} of {}{}{}.</p>\n",
                     remark(remarks.correlation), wrong.size(), kSignals * table.sensors.size(),
                     wrong.empty() ? "" : ": ", fmt::join(wrong, ", "));
}

// ---- Significance ----

void count_row(std::vector<Row>& rows, const Source& source, const PrintedTable& table) {
  const SignificantCount c = significant_count(table, source.runs);
  if (c.all == 0) return;
  rows.push_back({fmt::format("{}, {}", table.name, source.name), fmt::format("{}", c.all),
                  fmt::format("{}", c.above_one_sigma), fmt::format("{:.1f}", c.expected_by_chance),
                  fmt::format("{}", c.above_two_sigma), fmt::format("{}", c.holm_of_one),
                  fmt::format("{}", c.holm_of_mean)});
}

std::string significance(const std::vector<Source>& sources, const Article& article) {
  std::vector<Row> rows;
  for (const Source& source : sources) {
    const CampaignTables& t = source.tables;
    for (const PrintedTable* table : {&t.rest, &t.joint_bias, &t.joint_scale, &t.bias_only}) {
      count_row(rows, source, *table);
    }
  }
  if (rows.empty()) return {};
  return heading("How many numbers are significant") +
         fmt::format(
             "<p>{}Of numbers that are all zero nearly a third lie beyond one sigma. Student's t is taken "
             "with {} runs{}.</p>\n",
             remark(article.remarks.significance), sources.front().runs,
             article.runs ? "" : "; the article does not say how many it has") +
         wide(page::table("Significant numbers, by several rules",
                          {"table", "numbers", "beyond 1 σ", "expected by chance", "beyond 2 σ",
                           "Holm, σ of the number", "Holm, σ between runs"},
                          rows));
}

// ---- Signs, and timing ----

std::string signs(const std::vector<Source>& sources) {
  std::vector<Row> rows;
  for (const Source& source : sources) {
    if (source.tables.joint_scale.empty()) continue;
    const SignTest test = sign_test(source.tables.joint_scale);
    rows.push_back({source.name, fmt::format("{} of {}", test.negative, test.all), p_text(test.p_value)});
  }
  if (rows.empty()) return {};
  return heading("Scales that are negative throughout") +
         "<p>Scales of sensors that were calibrated one by one should have either sign. Where almost all are negative "
         "they "
         "have a common cause that is not in the sensors: a regression of the reference on the IMU is flattened by "
         "noise "
         "of the IMU and by clocks that are apart.</p>\n" +
         page::table("Negative scales in Table 4", {"", "negative", "p by chance"}, rows);
}

/// The delay [ms] at which the forward scale' has changed by `change`, interpolated between the evaluated delays.
std::string delay_for(const std::vector<TimingRow>& rows, int axis, double change) {
  const TimingRow* last = nullptr;
  for (const TimingRow& row : rows) {
    if (row.delay < 0) continue;
    const double here = row.forward[at(axis)];
    if (last && here <= change) {
      const double before = last->forward[at(axis)];
      const double share = (change - before) / (here - before);
      return fmt::format("{:.1f}", kMillisecondsPerSecond * (last->delay + share * (row.delay - last->delay)));
    }
    last = &row;
  }
  return last ? fmt::format("more than {:.0f}", kMillisecondsPerSecond * last->delay) : std::string(kNone);
}

std::string delays(const Study& study, const PrintedTable& scales) {
  const std::vector<TimingRow> rows = timing(study);
  if (rows.empty() || scales.empty()) return {};
  Row head{"axis", "article's mean"};
  for (const TimingRow& row : rows) head.push_back(decimal(kMillisecondsPerSecond * row.delay, 0) + " ms");
  head.emplace_back("delay needed [ms]");
  std::vector<Row> lines;
  for (int axis = 0; axis < kSignals; ++axis) {
    const double wanted = axis_mean(scales, axis);
    Row line{axis_name(axis), decimal(wanted, 4)};
    for (const TimingRow& row : rows) line.push_back(decimal(row.forward[at(axis)], 4));
    line.push_back(wanted < 0 ? delay_for(rows, axis, wanted) : std::string(kNone));
    lines.push_back(std::move(line));
  }
  return "<p>With the signals of this campaign a delay of the reference changes the forward scale' as follows. The "
         "last column is the delay that alone would make the article's mean; a delay explains its scales only "
         "where these agree.</p>\n" +
         wide(page::table(fmt::format("Change of scale' by a residual delay, forward, and the mean of the article's {}",
                                      scales.name),
                          head, lines));
}

// ---- Rest and run; copies ----

std::string shifts_table(const Source& source) {
  const auto all = shifts(source.tables);
  std::vector<Row> rows;
  Row head{"axis"};
  if (source.tables.rest.empty() || source.tables.bias_only.empty()) return {};
  for (const std::string& sensor : source.sensors) head.push_back(sensor + " (in σ)");
  head.emplace_back("same sign");
  for (int axis = 0; axis < kSignals; ++axis) {
    const Shift& shift = all[at(axis)];
    Row row{axis_with_unit(axis)};
    for (std::size_t s = 0; s < shift.value.size(); ++s) {
      row.push_back(fmt::format("{} ({})", number(shift.value[s], 3), number(shift.in_sigma[s], 1)));
    }
    row.emplace_back(shift.same_sign ? "yes" : "no");
    rows.push_back(std::move(row));
  }
  return wide(page::table(
      fmt::format("{} − {}: {}", source.tables.bias_only.name, source.tables.rest.name, source.name), head, rows));
}

std::string scales_at_rest(const CampaignTables& article, const ArticleRemarks& remarks) {
  if (article.joint_scale.empty()) return {};
  const auto mean = middles(implied_means(article));
  double by_scale = 0, bias = 0;
  for (std::size_t s = 0; s < article.rest.sensors.size(); ++s) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      by_scale = std::fmax(by_scale, std::abs(article.joint_scale.sensors[s][axis].value * mean[axis]));
      bias = std::fmax(bias, std::abs(article.rest.sensors[s][axis].value));
    }
  }
  return fmt::format(
      "<p>{}The scales of {} make up to {:.3f} m/s² of the mean force; the largest bias of an accelerometer at rest is "
      "{:.3f} m/s².</p>\n",
      remark(remarks.scale_at_rest), article.joint_scale.name, by_scale, bias);
}

std::string rest_and_run(const std::vector<Source>& sources, const ArticleRemarks& remarks) {
  const CampaignTables& article = sources.front().tables;
  if (article.rest.empty() || article.bias_only.empty()) return {};
  std::string out =
      heading("From rest to run") +
      fmt::format(
          "<p>In the article the biases at rest and in the run, over sensors and axes, have a correlation of {} on the "
          "gyroscopes and of {} on the accelerometers. A shift that has the same sign on all sensors is "
          "not of the sensors: a boresight that is wrong by 0.5° turns 0.086 m/s² of gravity from one axis to "
          "another, and a lever arm of 0.1 m adds 0.11 m/s² at 60 °/s.</p>\n",
          number(table_correlation(article.rest, article.bias_only, true), 2),
          number(table_correlation(article.rest, article.bias_only, false), 2));
  for (const Source& source : sources) out += shifts_table(source);
  return out + scales_at_rest(article, remarks);
}

/// Smallest and largest ratio of the gyroscopes' standard deviations. Nothing if the tables have none.
std::optional<Band> gyro_std_ratio(const PrintedTable& a, const PrintedTable& b) {
  std::vector<double> ratios;
  for (const auto& sensor : std_ratios(a, b)) {
    std::copy_if(sensor.begin() + 3, sensor.end(), std::back_inserter(ratios),
                 [](double ratio) { return std::isfinite(ratio); });
  }
  if (ratios.empty()) return std::nullopt;
  const auto [low, high] = std::minmax_element(ratios.begin(), ratios.end());
  return Band{*low, *high};
}

std::string copies(const CampaignTables& article) {
  std::vector<std::string> pairs;
  for (const auto& [a, b] : equal_std(article.rest)) pairs.push_back(axis_name(a) + " and " + axis_name(b));
  std::string out;
  if (!pairs.empty()) {
    out += fmt::format(
        "<p>In {} the standard deviations of {} are the same on every sensor, most likely by copying.</p>\n",
        article.rest.name, fmt::join(pairs, ", "));
  }
  if (const auto ratio = gyro_std_ratio(article.joint_bias, article.bias_only)) {
    out += fmt::format(
        "<p>Those of the gyroscopes in {} are {:.2f} to {:.2f} times those in {}: both are spreads between runs, and "
        "no statement about how precise least squares are.</p>\n",
        article.joint_bias.name, ratio->low, ratio->high, article.bias_only.name);
  }
  return out.empty() ? out : heading("Standard deviations") + out;
}

}  // namespace

std::string article_section(const Study& study) {
  const Article& article = study.article->article;
  const std::size_t own_runs = std::max<std::size_t>(2, study.runs.size());
  std::vector<Source> sources{
      {"the article", article.sensors, article.tables, std::max<std::size_t>(2, article.runs.value_or(own_runs))}};
  if (CampaignTables own = campaign_tables(study); !own.joint_scale.empty()) {
    sources.push_back({"this campaign", study.sensors, std::move(own), own_runs});
  }
  const CampaignTables& its = sources.front().tables;
  return fmt::format("<p class=\"soft\">The article: {}.</p>\n", escape_markup(article.title)) +
         identity(sources, article.remarks) + correlations_of(sources.front(), article.remarks) +
         significance(sources, article) + signs(sources) + delays(study, its.joint_scale) +
         rest_and_run(sources, article.remarks) + copies(its);
}

}  // namespace piste
