#include "report/study_article.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "piste/experiment/article.h"
#include "piste/experiment/study_tables.h"
#include "piste/math/units.h"
#include "piste/plot/markup.h"
#include "report/page.h"
#include "report/study_text.h"

namespace piste {
namespace {

using page::Row;
using page::wide;
using study_text::kNone;
using study_text::number;
using study_text::triad_of;

constexpr double kMilliseconds = 1e3;

std::size_t at(int axis) { return static_cast<std::size_t>(axis); }

std::string axis_name(int axis) { return std::string(kSignalNames[at(axis)]); }

std::string axis_with_unit(int axis) { return fmt::format("{} [{}]", kSignalNames[at(axis)], triad_of(axis).unit); }

std::string heading(std::string_view text) { return fmt::format("<h3>{}</h3>\n", text); }

std::string p_text(double p) { return p < 1e-4 ? "< 0.0001" : fmt::format("{:.2g}", p); }

/// The article, and the campaign where it has numbers.
struct Source {
  std::string name;
  CampaignTables tables;
};

// ---- Tables 3, 4 and 6 are one data set ----

std::string between(const Band& band) { return fmt::format("{} to {}", decimal(band.low, 2), decimal(band.high, 2)); }

/// Numbers that were not rounded imply one mean each, and no bounds.
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
  for (std::size_t s = 0; s < means.sensors.size(); ++s) head.push_back(fmt::format("sensor {}", s + 1));
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

/// Middles of what all sensors allow, NaN where they contradict one another.
std::array<double, kSignals> middles(const ImpliedMeans& means) {
  std::array<double, kSignals> out{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto& band = means.common[i];
    out[i] = band ? (band->low + band->high) / 2 : std::numeric_limits<double>::quiet_NaN();
  }
  return out;
}

std::string identity(const std::vector<Source>& sources) {
  const auto mean = middles(implied_means(sources.front().tables));
  std::string out =
      heading("Tables 3, 4 and 6 are of one data set") +
      "<p>Least squares pass through the mean point, so that bias alone = bias' + scale' · mean of the signal. "
      "Each sensor's three tables imply that mean, and sensors on one plate should agree on it.</p>\n";
  for (const Source& source : sources) out += means_table(source);
  out += fmt::format(
      "<p>In the article they agree: the mean force is ({}, {}, {}) m/s², {} m/s² long, which is gravity. So the "
      "printed "
      "numbers obey true = (1 + Table 4) · measured + Table 3, not the equation that is printed; Table 6 is the mean "
      "difference in the run and not the result of the Gauss-Markov process in whose section it stands; and the IMUs "
      "were "
      "pitched by {}°.</p>\n",
      number(mean[0], 2), number(mean[1], 2), number(mean[2], 2), number(std::hypot(mean[0], mean[1], mean[2]), 2),
      number(kDegreesPerRadian * std::atan2(mean[0], -mean[2]), 0));
  return out;
}

// ---- Table 5 ----

std::string correlations_of(const Source& article) {
  const ImpliedMeans means = implied_means(article.tables);
  const auto mean = middles(means);
  std::vector<Row> rows;
  for (int axis = 0; axis < kSignals; ++axis) {
    Row row{axis_with_unit(axis), number(mean[at(axis)], 2)};
    for (const auto& sensor : article.tables.correlation) {
      const ImpliedSpread spread = implied_spread(mean[at(axis)], sensor[at(axis)]);
      row.push_back(fmt::format("{}: {}", decimal(sensor[at(axis)], 2), number(spread.std, 2)));
    }
    rows.push_back(std::move(row));
  }
  std::vector<std::string> wrong;
  for (const auto& [sensor, axis] : wrong_signs(article.tables, means)) {
    wrong.push_back(fmt::format("{} of sensor {}", axis_name(axis), sensor + 1));
  }
  Row head{"axis", "mean"};
  for (std::size_t s = 0; s < article.tables.correlation.size(); ++s) {
    head.push_back(fmt::format("sensor {}: spread", s + 1));
  }
  return heading("Table 5 and the motion") +
         "<p>The correlation of bias' and scale' is −mean / rms of the signal; with the mean above it implies the "
         "spread of "
         "the signal about its mean.</p>\n" +
         wide(page::table("Correlation in the article's Table 5: spread of the signal that it implies", head, rows)) +
         fmt::format(
             "<p>The spread along fy contradicts the text, for which it is the axis with the largest signal. The "
             "sign should be that of −mean; it is not on {} of {}: {}.</p>\n",
             wrong.size(), kSignals * article.tables.correlation.size(), fmt::join(wrong, ", "));
}

// ---- Significance ----

void count_row(std::vector<Row>& rows, const std::string& name, const PrintedTable& table, std::size_t runs) {
  const SignificantCount c = significant_count(table, runs);
  if (c.all == 0) return;
  rows.push_back({name, fmt::format("{}", c.all), fmt::format("{}", c.above_one_sigma),
                  fmt::format("{:.1f}", c.expected_by_chance), fmt::format("{}", c.above_two_sigma),
                  fmt::format("{}", c.holm_of_one), fmt::format("{}", c.holm_of_mean)});
}

std::string significance(const std::vector<Source>& sources, std::size_t runs) {
  std::vector<Row> rows;
  for (const Source& source : sources) {
    count_row(rows, "Table 1, " + source.name, source.tables.rest, runs);
    count_row(rows, "Table 3, " + source.name, source.tables.joint_bias, runs);
    count_row(rows, "Table 4, " + source.name, source.tables.joint_scale, runs);
    count_row(rows, "Table 6, " + source.name, source.tables.bias_only, runs);
  }
  const SignificantCount six = significant_count(sources.front().tables.bias_only, runs);
  return heading("How many numbers are significant") +
         fmt::format(
             "<p>The article calls a number significant where its error bar of one sigma does not cross zero. "
             "Of numbers that are all zero nearly a third pass that. Student's t is taken with {} runs; the "
             "article does not say how many it has.</p>\n",
             runs) +
         wide(page::table("Significant numbers, by several rules",
                          {"table", "numbers", "beyond 1 σ", "expected by chance", "beyond 2 σ",
                           "Holm, σ of the number", "Holm, σ between runs"},
                          rows)) +
         fmt::format("<p>The text calls the biases of Table 6 not significant; by its own rule {} of {} are.</p>\n",
                     six.above_one_sigma, six.all);
}

// ---- Signs, and timing ----

std::string signs(const std::vector<Source>& sources) {
  std::vector<Row> rows;
  for (const Source& source : sources) {
    const SignTest test = sign_test(source.tables.joint_scale);
    rows.push_back({source.name, fmt::format("{} of {}", test.negative, test.all), p_text(test.p_value)});
  }
  return heading("Scales that are negative throughout") +
         "<p>Scales of sensors that were calibrated one by one should have either sign. Where almost all are negative "
         "they "
         "have a common cause that is not in the sensors: a regression of the reference on the IMU is flattened by "
         "noise "
         "of the IMU and by clocks that are apart.</p>\n" +
         page::table("Negative scales in Table 4", {"", "negative", "p by chance"}, rows);
}

/// Delay [ms] from which on the forward scale' has changed by as much, between the delays that were tried.
std::string delay_for(const std::vector<TimingRow>& rows, int axis, double change) {
  const TimingRow* last = nullptr;
  for (const TimingRow& row : rows) {
    if (row.delay < 0) continue;
    const double here = row.forward[at(axis)];
    if (last && here <= change) {
      const double before = last->forward[at(axis)];
      const double share = (change - before) / (here - before);
      return fmt::format("{:.1f}", kMilliseconds * (last->delay + share * (row.delay - last->delay)));
    }
    last = &row;
  }
  return last ? fmt::format("more than {:.0f}", kMilliseconds * last->delay) : std::string(kNone);
}

std::string delays(const Study& study) {
  const std::vector<TimingRow> rows = timing(study);
  if (rows.empty()) return {};
  Row head{"axis", "article's mean"};
  for (const TimingRow& row : rows) head.push_back(decimal(kMilliseconds * row.delay, 0) + " ms");
  head.emplace_back("delay needed [ms]");
  std::vector<Row> lines;
  for (int axis = 0; axis < kSignals; ++axis) {
    const double wanted = study_text::article_scale(axis);
    Row line{axis_name(axis), decimal(wanted, 4)};
    for (const TimingRow& row : rows) line.push_back(decimal(row.forward[at(axis)], 4));
    line.push_back(wanted < 0 ? delay_for(rows, axis, wanted) : std::string(kNone));
    lines.push_back(std::move(line));
  }
  return "<p>With the signals of this campaign a delay of the reference changes the forward scale' as follows. The "
         "last column is the delay that alone would make the article's mean; a delay explains Table 4 as far as these "
         "agree.</p>\n" +
         wide(page::table("Change of scale' by a residual delay, forward, and the mean of the article's Table 4", head,
                          lines));
}

// ---- Rest and run; copies ----

std::string shifts_table(const Source& source) {
  const auto all = shifts(source.tables);
  std::vector<Row> rows;
  Row head{"axis"};
  for (std::size_t s = 0; s < all.front().value.size(); ++s) head.push_back(fmt::format("sensor {} (in σ)", s + 1));
  if (head.size() == 1) return {};
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
  return wide(page::table(fmt::format("Table 6 − Table 1: {}", source.name), head, rows));
}

std::string scales_at_rest(const CampaignTables& article) {
  const auto mean = middles(implied_means(article));
  double by_scale = 0, bias = 0;
  for (std::size_t s = 0; s < article.rest.size(); ++s) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      by_scale = std::max(by_scale, std::abs(article.joint_scale[s][axis].value * mean[axis]));
      bias = std::max(bias, std::abs(article.rest[s][axis].value));
    }
  }
  return fmt::format(
      "<p>Table 7 calls the influence of the scales at rest negligible. The scales of Table 4 make up to "
      "{:.3f} m/s² of the mean force; the largest bias of an accelerometer at rest is {:.3f} m/s².</p>\n",
      by_scale, bias);
}

std::string rest_and_run(const std::vector<Source>& sources) {
  const CampaignTables& article = sources.front().tables;
  std::string out =
      heading("From rest to run") +
      fmt::format(
          "<p>In the article the biases at rest and in the run agree on the gyroscopes (correlation {} over "
          "sensors and axes) and not on the accelerometers ({}). A shift that has the same sign on all sensors is "
          "not of the sensors: a boresight that is wrong by 0.5° turns 0.086 m/s² of gravity from one axis to "
          "another, and a lever arm of 0.1 m adds 0.11 m/s² at 60 °/s.</p>\n",
          number(table_correlation(article.rest, article.bias_only, true), 2),
          number(table_correlation(article.rest, article.bias_only, false), 2));
  for (const Source& source : sources) out += shifts_table(source);
  return out + scales_at_rest(article);
}

std::string copies(const CampaignTables& article) {
  std::vector<std::string> pairs;
  for (const auto& [a, b] : equal_std(article.rest)) pairs.push_back(axis_name(a) + " and " + axis_name(b));
  const auto ratios = std_ratios(article.joint_bias, article.bias_only);
  std::vector<double> gyro;
  for (const auto& sensor : ratios) gyro.insert(gyro.end(), sensor.begin() + 3, sensor.end());
  const auto [low, high] = std::minmax_element(gyro.begin(), gyro.end());
  std::string out = heading("Standard deviations");
  if (!pairs.empty()) {
    out += fmt::format(
        "<p>In Table 1 the standard deviations of {} are the same on every sensor, most likely by "
        "copying.</p>\n",
        fmt::join(pairs, ", "));
  }
  return out + fmt::format(
                   "<p>Those of the gyroscopes in Table 3 are {:.2f} to {:.2f} times those in Table 6: both are "
                   "spreads between runs, and no statement about how precise least squares are.</p>\n",
                   *low, *high);
}

}  // namespace

std::string article_section(const Study& study) {
  std::vector<Source> sources{{"the article", article_tables()}};
  if (CampaignTables own = campaign_tables(study); !own.joint_scale.empty()) {
    sources.push_back({"this campaign", std::move(own)});
  }
  const CampaignTables& article = sources.front().tables;
  return identity(sources) + correlations_of(sources.front()) +
         significance(sources, std::max<std::size_t>(2, study.runs.size())) + signs(sources) + delays(study) +
         rest_and_run(sources) + copies(article);
}

}  // namespace piste
