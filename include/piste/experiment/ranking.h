#pragma once
/// Which estimate navigates best, and how surely: Table 7 of a study.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "piste/experiment/study_findings.h"

namespace piste {

/// Logarithm of the geometric mean of a method's errors of navigation over those of Method::kNothing; nothing where
/// there is none to compare.
std::optional<double> log_score(const SensorRun& run, Method method);

/// The IMUs in runs that can be scored: whose replay was run that knows nothing.
std::vector<const SensorRun*> scored(const Study& study);

/// Table 7: how a replay does that is fed a method's errors.
struct RankingRow {
  Method method{};
  std::size_t count = 0;                                                             ///< sensors and runs
  double position_rmse = 0, velocity_rmse = 0, attitude_rmse = 0, outage_drift = 0;  ///< rms over them; SI, rad
  /// Geometric mean of the four over those of `nothing`, mean over the runs: below 1 is better than knowing nothing.
  double score = 1;
  /// Score over the winner's, its 95 % interval, and the p-value of no difference, paired by run, as the sensors of a
  /// run share its motion and its reference. Holm's correction is over every pair of rows, since which one wins is
  /// known from the same scores: over those of the winner alone, one study in five of 22 equal methods and nine runs
  /// would find a difference. NaN of one run.
  double versus_winner = 1, low = 1, high = 1, p_holm = 1;
};
struct Ranking {
  std::vector<RankingRow> rows;  ///< in the order of kMethods; those that every scored sensor and run has
  std::optional<Method> winner;  ///< lowest score of those that compete
  double confidence = 0;         ///< share of 10 000 resamplings of the runs in which it wins; NaN of one run
};
Ranking ranking(const Study& study);

/// The competitor that follows the winner; null where there is none.
const RankingRow* second(const Ranking& ranking);

/// The competitors that share the first place, best first: the winner, and those whose score does not differ from its
/// own significantly (p_holm), or is the same to two decimals of their ratio. Empty without a winner.
std::vector<RankingRow> leaders(const Ranking& ranking);

/// What Table 7 says of each row: how far behind the winner and whether significantly, and where bias and scale cannot
/// be told apart.
std::vector<std::string> remarks(const Study& study, const Ranking& ranking);

}  // namespace piste
