#include "report/study_result.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "piste/study/missing.h"
#include "piste/study/study_tables.h"
#include "plot/markup.h"
#include "report/page.h"
#include "report/study_words.h"

namespace piste {
namespace {

using study_words::by_score;
using study_words::counted;
using study_words::interval;
using study_words::percent;
using study_words::title_of;

constexpr double kStrong = 0.9;  // correlation above which two numbers can hardly be separated

std::string quoted(Method method) { return "“" + escape_markup(title_of(method)) + "”"; }

/// "“a”, “b” and “c”".
std::string enumeration(const std::vector<RankingRow>& rows) {
  std::string out;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i > 0) out += i + 1 < rows.size() ? ", " : " and ";
    out += quoted(rows[i].method);
  }
  return out;
}

/// The first place: one method, or several that tie.
std::string first_place(const std::vector<RankingRow>& first) {
  if (first.size() == 1) {
    return fmt::format(
        "<strong>The best navigation comes from {}</strong>: its errors are {:.2f} times those of a replay that knows "
        "nothing.",
        quoted(first.front().method), first.front().score);
  }
  const std::string least = fmt::format("{:.2f}", first.front().score),
                    most = fmt::format("{:.2f}", first.back().score);
  return fmt::format(
      "<strong>{} methods tie for the best navigation</strong>: {}. Their errors are {} times those of a "
      "replay that knows nothing; the 95 % intervals of their ratios hold 1, or the ratios are 1.00.",
      first.size(), enumeration(first), least == most ? least : fmt::format("{} to {}", least, most));
}

/// The best of the competitors that do not share the first place. Empty if all do.
std::string next_place(const Ranking& ranking, const std::vector<RankingRow>& competitors,
                       const std::vector<RankingRow>& first) {
  const auto next = std::ranges::find_if(competitors, [&](const RankingRow& row) {
    return std::ranges::none_of(first, [&](const RankingRow& leader) { return leader.method == row.method; });
  });
  if (next == competitors.end()) return {};
  std::string out = fmt::format(" Next is {}, with {:.2f} times the errors of {}", quoted(next->method),
                                next->versus_winner, has_winner(ranking) ? "the winner" : quoted(first.front().method));
  if (std::isfinite(next->low)) out += fmt::format(" (95 % interval {})", interval(*next));
  return out + ".";
}

/// How many of the competitors behind the first place are significantly worse. Empty if there are none.
std::string behind(const std::vector<RankingRow>& competitors, const std::vector<RankingRow>& first) {
  if (first.size() == competitors.size()) return {};
  std::size_t doubtful = 0;
  for (const RankingRow& row : competitors) {
    const bool leads = std::ranges::find(first, row.method, &RankingRow::method) != first.end();
    if (!leads && row.p_holm >= kSignificance) ++doubtful;
  }
  if (doubtful == 0) return " Every other method is significantly worse.";
  return fmt::format(" Of the {} others {} are not significantly worse, after Holm's correction.",
                     competitors.size() - first.size(), doubtful);
}

/// The confidence of the first place.
std::string confidence(const Study& study, const Ranking& ranking, const std::vector<RankingRow>& competitors,
                       const std::vector<RankingRow>& first) {
  if (!std::isfinite(ranking.confidence)) return "<p>One run cannot say how sure that is.</p>\n";
  const bool wins = has_winner(ranking);
  return fmt::format("<p>{} {} in {} of 10 000 resamplings of the {}.{}</p>\n",
                     wins ? std::string("It") : quoted(*ranking.winner), wins ? "wins" : "has the lowest score",
                     percent(ranking.confidence), counted(study.runs.size(), "run"), behind(competitors, first));
}

std::string verdict(const Study& study, const Ranking& ranking) {
  if (!ranking.winner) return "<p><strong>The methods are not ranked.</strong></p>\n";
  const std::vector<RankingRow> first = leaders(ranking);
  std::vector<RankingRow> competitors = by_score(ranking);
  std::erase_if(competitors, [](const RankingRow& row) { return !info(row.method).competes; });
  std::string out = "<p>" + first_place(first) + next_place(ranking, competitors, first) + "</p>\n" +
                    confidence(study, ranking, competitors, first);
  std::vector<std::string> others;
  for (const RankingRow& row : ranking.rows) {
    if (!info(row.method).competes) others.push_back(fmt::format("{} {:.2f}", quoted(row.method), row.versus_winner));
  }
  if (!others.empty()) {
    out +=
        fmt::format("<p>For comparison, over {}: {}.</p>\n",
                    has_winner(ranking) ? std::string("the winner") : quoted(*ranking.winner), fmt::join(others, ", "));
  }
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
  if (const auto rest = table_of(study, Method::kRest, StudyQuantity::kBias); !rest.empty()) {
    out.push_back(fmt::format("At rest {} biases differ from zero.", significant(rest, value)));
  }
  if (const auto both = before_after(study); !both.empty()) {
    out.push_back(
        fmt::format("From before to after the run {} biases change.",
                    significant(both, [](const BeforeAfterRow& row) -> const Across& { return row.difference; })));
  }
  if (const auto joint = table_of(study, Method::kJoint, StudyQuantity::kScale); !joint.empty()) {
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
    out.push_back(fmt::format("Bias and scale are hardly separable (correlation above {}): {}.", kStrong,
                              fmt::join(strong, ", ")));
  }
  return out;
}

/// The gain of the fused IMU over a single one.
std::string as_one(const Study& study) {
  const std::vector<ImuCompared> rows = imus_compared(study);
  if (rows.empty() || !std::isfinite(rows.back().attitude_over_single)) return {};
  const ImuCompared& row = rows.back();
  std::size_t most = 0;
  for (const SensorRun& run : study.as_one) most = std::max(most, run.imus.size());
  std::string out = fmt::format("<p>Taken as one, the IMUs have {:.2f} times the attitude error of a single one",
                                row.attitude_over_single);
  if (std::isfinite(row.drift_over_single)) {
    out += fmt::format(" and {:.2f} times its drift without GNSS", row.drift_over_single);
  }
  return out + fmt::format(", on average; of independent errors of {} IMUs {:.2f} would be left.</p>\n", most,
                           1 / std::sqrt(static_cast<double>(most)));
}

}  // namespace

std::string study_result(const Study& study, const Ranking& ranking) {
  std::string out = verdict(study, ranking);
  const std::vector<std::string> found = findings_of(study);
  if (!found.empty()) {
    out += page::list("What the signals say, at 5 % after Holm's correction:", found);
  }
  return out + as_one(study) + page::list("What is missing, and why:", missing(study));
}

}  // namespace piste
