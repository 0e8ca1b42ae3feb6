#pragma once
/// Ranks the methods of a study by the navigation that they lead to, with significance: Table 7.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "piste/study/study_findings.h"

namespace piste {

/// Logarithm of a method's score. The score is the geometric mean of its navigation errors, each divided by the error
/// of Method::kNothing. Nothing if there is none to compare.
std::optional<double> log_score(const SensorRun& run, Method method);

/// The results that can be scored: those that have a score of Method::kNothing.
std::vector<const SensorRun*> scored(const Study& study);

/// One row of Table 7: how well a replay navigates with the errors that a method estimated.
struct RankingRow {
  Method method{};
  std::size_t count = 0;                                                             ///< number of results
  double position_rmse = 0, velocity_rmse = 0, attitude_rmse = 0, outage_drift = 0;  ///< rms over them; SI, rad
  /// Geometric mean of the four errors divided by those of Method::kNothing, as a mean over the runs. Below 1 is better
  /// than no correction.
  double score = 1;
  /// Score divided by the winner's score, its 95 % interval, and the p-value of no difference. These are paired by run,
  /// because the sensors of a run share its motion and its reference. Holm's correction is over all pairs of rows,
  /// because the winner is chosen by the same scores. With a correction over the pairs with the winner alone, one study
  /// in five with 22 equal methods and nine runs would find a difference. NaN if there is only one run.
  double versus_winner = 1, low = 1, high = 1, p_holm = 1;
};
/// The ranking.
struct Ranking {
  std::vector<RankingRow> rows;  ///< in the order of kMethods; only methods that every scored result has
  std::optional<Method> winner;  ///< the competing method with the lowest score
  double confidence = 0;         ///< share of 10 000 resamplings of the runs in which it wins; NaN if one run
};
Ranking ranking(const Study& study);

/// The competitor after the winner, or null.
const RankingRow* second(const Ranking& ranking);

/// The competitors that share the first place, the best first. They are the one with the lowest score, and those whose
/// interval of the ratio to it contains 1, or whose ratio is 1.00. Empty if there is no competitor.
std::vector<RankingRow> leaders(const Ranking& ranking);

/// Whether the method with the lowest score is called the winner: none ties with it, and every other competitor is
/// significantly worse (p_holm).
bool has_winner(const Ranking& ranking);

/// The remarks of Table 7, one for each row: the distance from the winner, its significance, and whether bias and scale
/// cannot be separated.
std::vector<std::string> remarks(const Study& study, const Ranking& ranking);

}  // namespace piste
