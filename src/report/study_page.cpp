#include "piste/report/study_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "piste/experiment/article.h"
#include "piste/experiment/study_tables.h"
#include "piste/math/units.h"
#include "piste/plot/markup.h"
#include "piste/report/study_figures.h"
#include "report/page.h"
#include "report/study_article.h"
#include "report/study_text.h"

namespace piste {
namespace {

using page::Row;
using page::wide;
using study_text::band_of;
using study_text::by_score;
using study_text::counted;
using study_text::digits;
using study_text::kNone;
using study_text::kTriads;
using study_text::number;
using study_text::percent;
using study_text::probability;
using study_text::Triad;
using study_text::triad_of;

constexpr double kStrong = 0.9;  // correlation from which on two numbers are hardly told apart
constexpr int kBiasDecimals = 4, kScaleDecimals = 5, kPrintedDecimals = 3;

constexpr std::string_view kHowToRead =
    R"(<p><strong>Sign.</strong> Biases and scales are corrections to add, as in the article: true = (1 + scale') · measured + bias'.
The errors that the sensor adds, measured = (1 + scale) · true + bias, have the other sign.</p>
<p><strong>Three sigmas.</strong> The formal one holds if noise were white; it is far too small, as samples that follow each other
tell the same. The error within a run knows how long the noise lasts, and what is wrong with the reference and the alignment. The
spread between runs knows all that changes from one run to the next: turn-on bias, temperature, mounting. Significance is that of
the mean over the runs against this spread, by Student's t.</p>
<p><strong>Holm.</strong> Of 18 numbers without any bias one is “significant” at 5 % in most tables. Holm's step-down keeps the
probability of even one such false finding in a table at 5 %. A star marks what stays significant.</p>
<p><strong>Rest and accelerometers.</strong> At rest an accelerometer shows bias + scale · gravity, and a boresight wrong by 0.1° tilts
0.017 m/s² of gravity into the level axes. The biases at rest of Table 1 are therefore sums; the truth that they are held to is
the same sum.</p>
<p><strong>Forward and reverse.</strong> The article regresses the reference on the IMU (forward). Noise of the IMU, or clocks that are
apart by milliseconds, flatten that line and make scale' negative; the reverse regression errs to the other side. The truth lies between.</p>
<p><strong>Score.</strong> Each method's errors are fed to a replay of GPS and the IMU, which is held against the reference solution.
The score is the geometric mean of the errors of position, velocity and attitude and of the drift without GNSS, each over that of a
replay that knows nothing; below 1 the method helps. Intervals pair the runs, as all IMUs of a run share its motion.</p>
)";

std::string axis_name(const Study& study, std::size_t sensor, int axis) {
  return fmt::format("{} {}", study.sensors[sensor], kSignalNames[static_cast<std::size_t>(axis)]);
}

std::string title_of(Method method) { return std::string(info(method).title); }

std::string paragraph(const std::string& text) { return "<p>" + escape_markup(text) + "</p>\n"; }

// ---- Result ----

std::string interval(const RankingRow& row) {
  return std::isfinite(row.low) ? fmt::format("{:.2f} to {:.2f}", row.low, row.high) : std::string(kNone);
}

std::string verdict(const Study& study, const Ranking& ranking) {
  if (!ranking.winner) return "<p><strong>The methods are not ranked.</strong></p>\n";
  std::vector<RankingRow> rows = by_score(ranking);
  std::erase_if(rows, [](const RankingRow& row) { return !info(row.method).competes; });
  std::string out = fmt::format(
      "<p><strong>The best navigation comes from “{}”</strong>: its errors are {:.2f} times those of a replay that "
      "knows "
      "nothing.",
      escape_markup(title_of(*ranking.winner)), rows.front().score);
  if (rows.size() > 1) {
    const RankingRow& next = rows[1];
    out += fmt::format(" Next is “{}”, with {:.2f} times the errors of the winner",
                       escape_markup(title_of(next.method)), next.versus_winner);
    if (std::isfinite(next.low)) out += fmt::format(" (95 % interval {})", interval(next));
    out += ".";
  }
  out += "</p>\n";
  if (!std::isfinite(ranking.confidence)) {
    return out + "<p>One run cannot say how sure that is.</p>\n";
  }
  std::vector<std::string> tied;
  for (const RankingRow& row : rows) {
    if (row.method != *ranking.winner && row.p_holm >= kSignificance)
      tied.push_back(escape_markup(title_of(row.method)));
  }
  out += fmt::format("<p>It wins in {} of 10 000 resamplings of the {}. ", percent(ranking.confidence),
                     counted(study.runs.size(), "run"));
  out += tied.empty() ? "Every other method is significantly worse."
                      : fmt::format("Not significantly worse: {}.", fmt::join(tied, "; "));
  out += "</p>\n";
  std::vector<std::string> others;
  for (const RankingRow& row : ranking.rows) {
    if (info(row.method).competes) continue;
    others.push_back(fmt::format("“{}” {:.2f}", escape_markup(title_of(row.method)), row.versus_winner));
  }
  if (!others.empty()) out += fmt::format("<p>For comparison, over the winner: {}.</p>\n", fmt::join(others, ", "));
  return out;
}

template <class Rows, class Of>
std::string significant(const Rows& rows, const Of& of) {
  const auto count = std::count_if(rows.begin(), rows.end(), [&](const auto& row) { return of(row).significant; });
  return fmt::format("{} of {}", count, rows.size());
}

std::vector<std::string> findings_of(const Study& study) {
  std::vector<std::string> out;
  const auto value = [](const AcrossRow& row) -> const Across& { return row.value; };
  if (const auto rest = table_of(study, Method::kRest, Quantity::kBias); !rest.empty()) {
    out.push_back(fmt::format("At rest {} biases differ from zero.", significant(rest, value)));
  }
  if (const auto both = before_after(study); !both.empty()) {
    out.push_back(
        fmt::format("From before to after the run {} biases change.",
                    significant(both, [](const BeforeAfterRow& row) -> const Across& { return row.difference; })));
  }
  if (const auto joint = table_of(study, Method::kJoint, Quantity::kScale); !joint.empty()) {
    const auto negative =
        std::count_if(joint.begin(), joint.end(), [](const AcrossRow& r) { return r.value.mean < 0; });
    out.push_back(fmt::format("In the run {} scales differ from zero; {} of {} are negative.",
                              significant(joint, value), negative, joint.size()));
  }
  std::array<int, kSignals> sensors{}, strong_sensors{};
  for (const CorrelationRow& row : correlations(study)) {
    ++sensors[static_cast<std::size_t>(row.axis)];
    if (std::abs(row.correlation) > kStrong) ++strong_sensors[static_cast<std::size_t>(row.axis)];
  }
  std::vector<std::string> strong;
  for (std::size_t axis = 0; axis < kSignals; ++axis) {
    if (strong_sensors[axis] == 0) continue;
    strong.push_back(fmt::format("{} of {} of {} sensors", kSignalNames[axis], strong_sensors[axis], sensors[axis]));
  }
  if (!strong.empty()) {
    out.push_back(fmt::format("Bias and scale are hardly told apart (correlation above {}): {}.", kStrong,
                              fmt::join(strong, ", ")));
  }
  return out;
}

std::string result(const Study& study, const Ranking& ranking) {
  std::string out = verdict(study, ranking);
  const std::vector<std::string> found = findings_of(study);
  if (!found.empty()) {
    out += page::list("What the signals say, at 5 % after Holm's correction:", found);
  }
  return out + page::list("What is missing, and why:", missing(study));
}

// ---- Tables ----

/// Of a bias, or of a scale, which is a ratio.
std::string_view unit_of(Quantity quantity, int axis) {
  return quantity == Quantity::kBias ? triad_of(axis).unit : "ratio";
}

std::string starred(const Across& a) { return probability(a.p_holm) + (a.significant ? " *" : ""); }

std::string estimate_table(const Study& study, const std::string& caption, Method method, Quantity quantity,
                           const PrintedTable& printed = {}) {
  const std::vector<AcrossRow> rows = table_of(study, method, quantity);
  if (rows.empty()) return paragraph(caption + ": no estimate.");
  const bool joint = method == Method::kJoint;
  const int decimals = quantity == Quantity::kBias ? kBiasDecimals : kScaleDecimals;
  Row head{"sensor, axis",
           "unit",
           "runs",
           quantity == Quantity::kBias ? "bias'" : "scale'",
           "std between runs",
           "error of the mean",
           "error within a run",
           "formal",
           "p",
           "p, Holm"};
  if (joint) head.emplace_back("reverse");
  if (study.simulated) head.emplace_back("put in");
  if (!printed.empty()) head.insert(head.end(), {"article", "its std"});
  std::vector<Row> lines;
  for (const AcrossRow& row : rows) {
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
    if (joint) line.push_back(number(row.reverse, decimals));
    if (study.simulated) line.push_back(row.truth ? decimal(*row.truth, decimals) : std::string(kNone));
    if (row.sensor >= printed.size()) {
      line.resize(head.size());
    } else {
      const Printed& p = printed[row.sensor][static_cast<std::size_t>(row.axis)];
      line.insert(line.end(), {number(p.value, kPrintedDecimals), number(p.std, kPrintedDecimals)});
    }
    lines.push_back(std::move(line));
  }
  return wide(page::table(caption, head, lines));
}

std::string before_after_table(const Study& study) {
  const std::vector<BeforeAfterRow> rows = before_after(study);
  const std::string caption = "Table 2. Biases at rest, before the start and after the stop";
  if (rows.empty()) return paragraph(caption + ": no run has both.");
  std::vector<Row> lines;
  for (const BeforeAfterRow& row : rows) {
    const Across& d = row.difference;
    const bool printed = row.sensor == 0;
    const auto axis = static_cast<std::size_t>(row.axis);
    lines.push_back({axis_name(study, row.sensor, row.axis), std::string(triad_of(row.axis).unit),
                     fmt::format("{}", d.runs), decimal(row.before, kBiasDecimals), decimal(row.after, kBiasDecimals),
                     decimal(d.mean, kBiasDecimals), digits(d.std), digits(d.standard_error), digits(d.within),
                     probability(d.p_value), starred(d),
                     printed ? decimal(article::kTable2Before[axis], kPrintedDecimals) : "",
                     printed ? decimal(article::kTable2After[axis], kPrintedDecimals) : ""});
  }
  return wide(page::table(caption,
                          {"sensor, axis", "unit", "runs", "before", "after", "after − before", "std between runs",
                           "error of the mean", "error within a run", "p", "p, Holm", "article: before", "after"},
                          lines));
}

std::string correlation_table(const Study& study) {
  const std::vector<CorrelationRow> rows = correlations(study);
  const std::string caption = "Table 5. Correlation of bias and scale, IMU on reference";
  if (rows.empty()) return paragraph(caption + ": no estimate.");
  std::vector<Row> lines;
  lines.reserve(rows.size());
  for (const CorrelationRow& row : rows) {
    lines.push_back({axis_name(study, row.sensor, row.axis), decimal(row.correlation, 2), decimal(row.lowest, 2),
                     decimal(row.highest, 2), decimal(row.inflation, 1),
                     row.sensor < article::kTable5.size()
                         ? decimal(article::kTable5[row.sensor][static_cast<std::size_t>(row.axis)], 2)
                         : ""});
  }
  return wide(page::table(
      caption, {"sensor, axis", "correlation", "lowest", "highest", "variances larger by", "article"}, lines));
}

std::string ranking_table(const Ranking& ranking) {
  const std::string caption = "Table 7. Navigation that each estimate leads to, best first";
  if (ranking.rows.empty()) return paragraph(caption + ": no replay was scored.");
  std::vector<Row> lines;
  for (const RankingRow& row : by_score(ranking)) {
    const bool wins = ranking.winner == row.method;
    const MethodInfo& m = info(row.method);
    const auto size = [](double value) { return value > 0 ? digits(value, 3) : std::string(kNone); };
    lines.push_back({title_of(row.method) + (wins         ? " (winner)"
                                             : m.competes ? ""
                                                          : " (for comparison)"),
                     std::string(m.estimates), size(row.position_rmse), size(row.velocity_rmse),
                     size(kDegreesPerRadian * row.attitude_rmse), size(row.outage_drift),
                     fmt::format("{:.3f}", row.score), fmt::format("{:.2f}", row.versus_winner),
                     wins ? std::string(kNone) : interval(row), wins ? std::string(kNone) : probability(row.p_holm)});
  }
  return wide(page::table(caption,
                          {"method", "estimates", "position [m]", "velocity [m/s]", "attitude [°]",
                           "drift without GNSS [m]", "score", "over the winner", "95 %", "p, Holm"},
                          lines));
}

std::string tables(const Study& study, const Ranking& ranking) {
  const CampaignTables article = article_tables();
  return "<p class=\"soft\">Corrections to add, m/s² and °/s; * significant at 5 % after Holm's correction over the "
         "table. "
         "The article's numbers are those of its sensors 1 to 3, other devices than those of this campaign.</p>\n" +
         estimate_table(study, "Table 1. Biases at rest before the start", Method::kRest, Quantity::kBias,
                        article.rest) +
         before_after_table(study) +
         estimate_table(study, "Table 3. Biases in the run, with scales", Method::kJoint, Quantity::kBias,
                        article.joint_bias) +
         estimate_table(study, "Table 4. Scales in the run", Method::kJoint, Quantity::kScale, article.joint_scale) +
         correlation_table(study) +
         estimate_table(study, "Table 6. Biases in the run, without scales", Method::kBiasOnly, Quantity::kBias,
                        article.bias_only) +
         estimate_table(study,
                        "Biases by Gauss-Markov in the GPS/MEMS filter, which the article has in Figures 16 and 17",
                        Method::kMarkovFiltered, Quantity::kBias) +
         ranking_table(ranking);
}

// ---- Every method against every other ----

/// Of a − b over sensors and axes.
struct Cell {
  double difference = 0, error = 0;  ///< root mean square, and that of the standard errors
  std::size_t count = 0;
  bool significant = false;
};

std::string short_text(double size) { return fmt::format("{:.{}f}", size, size < 1 ? 2 : size < 10 ? 1 : 0); }

std::string matrix(const std::vector<Comparison>& all, Quantity quantity, const Triad& triad) {
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
  Row head{quantity == Quantity::kBias ? fmt::format("[10⁻³ {}]", triad.unit) : std::string("[10⁻³]")};
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
  const char* what = quantity == Quantity::kBias ? "Bias'" : "Scale'";
  return "<div class=\"matrix\">\n" + wide(page::table(fmt::format("{} of the {}", what, triad.name), head, rows)) +
         "</div>\n";
}

std::string matrices(const Study& study) {
  std::string out =
      "<p>Root mean square over sensors and axes of the mean difference of two methods: above the diagonal the "
      "difference, below it its standard error. * at least one of them is significant at 5 % after Holm's correction. ";
  out += study.simulated ? "The last column is the difference to what was put in, as each method could see it. " : "";
  out += "Every single difference stands in comparisons.csv.</p>\n";
  for (const Quantity quantity : {Quantity::kBias, Quantity::kScale}) {
    const std::vector<Comparison> all = comparisons(study, quantity);
    for (const Triad& triad : kTriads) out += matrix(all, quantity, triad);
  }
  return out;
}

// ---- Against the truth ----

constexpr std::string_view kWhyNotCovered =
    R"(<p>A true interval holds the truth 19 times of 20. A much smaller share means that a method does not know of some error:</p>
<ul>
<li>“rest before” and “rest after” cannot tell an accelerometer's bias from scale · gravity, nor from a boresight that
tilts gravity into another axis. They are held to the sum bias + scale · gravity; taken for the bias alone they would be wrong by far
more than their sigma.</li>
<li>A bias at rest is held to that of its rest: what drifts from there to the run is not in its sigma, but in that of “run: scale”.</li>
<li>Random constants do not know of drift. Their sigma shrinks as the run goes on while the bias walks away from it.</li>
<li>Of a filter's estimates the mean over the run is held to that of the truth, with the sigma of one instant: where errors fade
within the run, as those of gyroscopes do, the mean is better than it claims.</li>
<li>“run: bias and scale” and its reverse lie on either side of the truth where the clocks are apart or the signals noisy; their
sigmas hold for the line, not for that shift.</li>
</ul>
)";

std::string coverage_table(const Study& study) {
  std::vector<Row> rows;
  const std::vector<Coverage> all = coverage(study);
  for (const MethodInfo& m : kMethods) {
    Row row{std::string(m.title)};
    bool any = false;
    for (const Quantity quantity : {Quantity::kBias, Quantity::kScale}) {
      for (const bool gyro : {false, true}) {
        const auto found = std::find_if(all.begin(), all.end(), [&](const Coverage& c) {
          return c.method == m.method && c.quantity == quantity && c.gyro == gyro;
        });
        if (found == all.end()) {
          row.insert(row.end(), 2, std::string(kNone));
          continue;
        }
        any = true;
        row.push_back(fmt::format("{}/{} ({})", found->inside, found->all, percent(found->rate())));
        row.push_back(fmt::format("{:.1f} σ", found->worst));
      }
    }
    if (any) rows.push_back(std::move(row));
  }
  if (rows.empty()) return "<p>No method has an answer.</p>\n";
  return wide(page::table(
      "Truth inside the 95 % interval, over sensors, runs and axes; and the largest error over its sigma",
      {"method", "accel bias", "worst", "gyro bias", "worst", "accel scale", "worst", "gyro scale", "worst"}, rows));
}

std::string truth(const Study& study) {
  return std::string(kWhyNotCovered) + coverage_table(study) + page::pictures(study_truth(study));
}

// ---- Runs ----

std::string length(const std::optional<Interval>& phase) {
  return phase ? fmt::format("{:.1f}–{:.1f}", phase->start, phase->end) : std::string(kNone);
}

/// Three numbers that stay in one line.
std::string triple(const Vector3d& value, double factor, int decimals) {
  return fmt::format("{}, {}, {}", decimal(factor * value.x(), decimals), decimal(factor * value.y(), decimals),
                     decimal(factor * value.z(), decimals));
}

std::string degrees(const Vector3d& angles) { return triple(angles, kDegreesPerRadian, 3); }

std::string runs(const Study& study) {
  std::vector<Row> of_runs, of_sensors;
  std::vector<std::string> failures, warnings;
  for (const StudyRun& r : study.runs) {
    if (!r.failure.empty()) failures.push_back(fmt::format("{}: {}", r.name, r.failure));
    for (const std::string& w : r.warnings) warnings.push_back(fmt::format("{}: {}", r.name, w));
    of_runs.push_back({r.name, r.activity, length(r.phases.before), length(r.phases.run), length(r.phases.after),
                       fmt::format("{:.3g}", r.sigma_position), degrees(r.sigma_attitude),
                       fmt::format("{}", r.outages)});
  }
  for (const SensorRun& r : study.results) {
    const std::string name = fmt::format("{}, {}", study.runs[r.run].name, study.sensors[r.sensor]);
    if (!r.failure.empty()) {
      failures.push_back(fmt::format("{}: {}", name, r.failure));
      continue;
    }
    for (const std::string& w : r.warnings) warnings.push_back(fmt::format("{}: {}", name, w));
    of_sensors.push_back({name, decimal(r.clock_offset, 5), decimal(1e6 * r.clock_drift, 2), degrees(r.boresight),
                          degrees(r.sigma_boresight), triple(r.lever_arm, 1e3, 1)});
  }
  if (of_runs.empty()) return "<p>There is no run.</p>\n";
  std::string out = wide(page::table("Runs; phases in seconds of GPS time",
                                     {"run", "activity", "rest before [s]", "run [s]", "rest after [s]",
                                      "σ position of the reference [m]", "σ roll, pitch, heading [°]", "outages"},
                                     of_runs));
  if (!of_sensors.empty()) {
    out += wide(page::table("Alignment of each IMU",
                            {"run, sensor", "clock offset [s]", "clock drift [ppm]",
                             "boresight: roll, pitch, heading [°]", "σ [°]", "lever arm from the reference [mm]"},
                            of_sensors));
  }
  return out + page::list("Failed:", failures) + page::list("To be known:", warnings);
}

// ---- Methods ----

std::string methods(const Study& study) {
  std::string out = "<ol start=\"0\">\n";
  for (const MethodInfo& m : kMethods) {
    if (m.method == Method::kTruth && !study.simulated) continue;
    out += fmt::format("<li><strong>{}</strong> <code>{}</code>{}. {}</li>\n", escape_markup(m.title), m.name,
                       m.competes ? "" : ", not ranked", escape_markup(m.how));
  }
  return out + "</ol>\n";
}

}  // namespace

std::string study_html(const Study& study, const std::string& version, const std::string& config_text) {
  const Ranking ranks = ranking(study);
  const std::string subtitle =
      fmt::format("piste {} · {} in {} · both signals {} · {}", escape_markup(version),
                  counted(study.sensors.size(), "IMU"), counted(study.runs.size(), "run"), band_of(study),
                  study.simulated ? "simulated: what was put in is known" : "recorded: the truth is not known");
  std::vector<page::Section> sections{
      {"result", "Result", result(study, ranks)},
      {"tables", "Tables", tables(study, ranks)},
      {"ranking", "Ranking", page::pictures(study_ranking(study))},
      {"signals", "Signals", page::pictures(study_signals(study))},
      {"estimates", "Biases and scales", page::pictures(study_estimates(study))},
      {"correlation", "Bias and scale together", page::pictures(study_correlations(study))},
      {"comparison", "Methods compared", page::pictures(study_comparisons(study)) + matrices(study)}};
  if (study.simulated) sections.push_back({"truth", "Against the truth", truth(study)});
  sections.push_back({"timing", "Timing errors", page::pictures(study_timing(study))});
  sections.push_back({"article", "What the article's numbers imply", article_section(study)});
  sections.push_back({"runs", "Runs", runs(study)});
  sections.push_back({"methods", "Methods", methods(study)});
  sections.push_back({"reading", "How to read it", std::string(kHowToRead)});
  sections.push_back({"configuration", "Configuration", fmt::format("<pre>{}</pre>\n", escape_markup(config_text))});
  return page::render(study.name, subtitle, sections);
}

}  // namespace piste
