#include "piste/report/study_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string_view>
#include <vector>

#include "piste/math/units.h"
#include "piste/report/study_figures.h"
#include "piste/study/ranking.h"
#include "piste/study/study_tables.h"
#include "plot/markup.h"
#include "report/drawing.h"
#include "report/page.h"
#include "report/study_article.h"
#include "report/study_matrices.h"
#include "report/study_page_tables.h"
#include "report/study_result.h"
#include "report/study_words.h"

namespace piste {
namespace {

using page::Row;
using page::wide;
using study_words::band_of;
using study_words::counted;
using study_words::interval;
using study_words::kNone;
using study_words::percent;
using study_words::probability;

constexpr std::string_view kHowToRead =
    R"(<p><strong>Sign.</strong> Biases and scales are corrections to add: true = (1 + scale') · measured + bias'.
The errors that the sensor adds, measured = (1 + scale) · true + bias, have the other sign.</p>
<p><strong>Three sigmas.</strong> The formal one holds if noise were white; it is far too small, as successive samples are
correlated. The error within a run includes the correlation of the noise, and the errors of the reference and the alignment. The
spread between runs knows all that changes from one run to the next: turn-on bias, temperature, mounting. Significance is that of
the mean over the runs against this spread, by Student's t.</p>
<p><strong>Holm.</strong> Of 18 numbers without any bias one is “significant” at 5 % in most tables. Holm's step-down keeps the
probability of even one such false finding in a table at 5 %. A star marks what stays significant.</p>
<p><strong>Rest and accelerometers.</strong> At rest an accelerometer shows bias + scale · gravity, and a boresight wrong by 0.1° tilts
0.017 m/s² of gravity into the level axes. The biases at rest of Table 1 are therefore sums; the truth that they are held to is
the same sum.</p>
<p><strong>Forward and reverse.</strong> Tables 3 and 4 regress the reference on the IMU (forward). Noise of the IMU, or clocks that are
apart by milliseconds, flatten that line and make scale' negative; the reverse regression errs to the other side. The truth lies between.</p>
<p><strong>All as one.</strong> Where a run has several IMUs, they are also studied as one: their weighted mean, in the axes and at the
place of the first, with their differences as measurements. Its rows stand below those of the single IMUs. It adds no information to
that of the single IMUs, so it is not in the ranking, nor in the counts and means over sensors.</p>
<p><strong>Score.</strong> Each method's errors are fed to a replay of GPS and the IMU, which is held against the reference solution.
The score is the geometric mean of the errors of position, velocity and attitude and of the drift without GNSS, each over that of a
replay that knows nothing; below 1 the method helps. Intervals pair the runs, as all IMUs of a run share its motion.</p>
)";

// ---- Against the truth ----

constexpr std::string_view kWhyNotCovered =
    R"(<p>A true interval holds the truth 19 times of 20. A much smaller share means that a method does not know of some error:</p>
<ul>
<li>“rest before” and “rest after” cannot separate an accelerometer's bias from scale · gravity, nor from a boresight that
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
    for (const StudyQuantity quantity : {StudyQuantity::kBias, StudyQuantity::kScale}) {
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

std::string truth(const Study& study, page::Drawing& drawing) {
  return std::string(kWhyNotCovered) + coverage_table(study) + drawing.add(study_truth(study));
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
  const auto add = [&](const SensorRun& r, std::string_view sensor) {
    const std::string name = fmt::format("{}, {}", study.runs[r.run].name, sensor);
    if (!r.failure.empty()) {
      failures.push_back(fmt::format("{}: {}", name, r.failure));
      return;
    }
    for (const std::string& w : r.warnings) warnings.push_back(fmt::format("{}: {}", name, w));
    const std::string who = r.imus.empty() ? name : fmt::format("{} ({})", name, fmt::join(r.imus, ", "));
    of_sensors.push_back({who, decimal(r.clock_offset, 5), decimal(1e6 * r.clock_drift, 2), degrees(r.boresight),
                          degrees(r.sigma_boresight), triple(r.lever_arm, 1e3, 1)});
  };
  for (const SensorRun& r : study.results) add(r, study.sensors[r.sensor]);
  for (const SensorRun& r : study.as_one) add(r, kAsOne);
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
  page::Drawing drawing;
  std::vector<page::Section> sections{
      {"result", "Result", study_result(study, ranks)},
      {"ranking", "Ranking", drawing.add(study_ranking(study))},
      {"signals", "Signals", drawing.add(study_signals(study))},
      {"estimates", "Biases and scales", drawing.add(study_estimates(study))},
      {"correlation", "Bias and scale together", drawing.add(study_correlations(study))},
      {"comparison", "Methods compared", drawing.add(study_comparisons(study)) + study_matrices(study)},
      {"tables", "Tables", study_page_tables(study, ranks)}};
  if (study.simulated) sections.push_back({"truth", "Against the truth", truth(study, drawing)});
  sections.push_back({"timing", "Timing errors", drawing.add(study_timing(study))});
  if (study.article) sections.push_back({"article", "What the article's numbers imply", article_section(study)});
  sections.push_back({"runs", "Runs", runs(study)});
  sections.push_back({"methods", "Methods", methods(study)});
  sections.push_back({"reading", "How to read it", std::string(kHowToRead)});
  sections.push_back({"configuration", "Configuration", fmt::format("<pre>{}</pre>\n", escape_markup(config_text))});
  return page::render({.title = study.name,
                       .subtitle = subtitle,
                       .head = drawing.head(),
                       .sections = sections,
                       .style = drawing.style(),
                       .scripts = drawing.scripts()});
}

}  // namespace piste
