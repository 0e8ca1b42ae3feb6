#pragma once
/// How likely the innovations of a filtered log are.

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "piste/core/solution.h"
#include "piste/filter/initial_state.h"

namespace piste {

/// Stretches of a run, from its start on: all, or every other one.
struct Stretches {
  double length = 0;    ///< [s]; 0: all
  bool second = false;  ///< of each two

  bool contain(double since_start) const {
    return !(length > 0) || (static_cast<long>(since_start / length) % 2 == 1) == second;
  }
};

inline constexpr double kToTheEnd = 1e300;  ///< s: of a log

/// A log filtered with some options: the log-likelihood of its innovations, and what it knew in the end.
struct Evidence {
  double likelihood = -std::numeric_limits<double>::infinity();  ///< −∞ if the filter diverged
  double rows = 0;                                               ///< of the measurements that count
  std::vector<Innovation> innovations;                           ///< those that count: under way
  std::vector<std::string> sources;                              ///< their names, by Innovation::source
  Estimate last;
  FullError sigmas = FullError::Zero();  ///< of the blocks of `last`
};

/// Whether an innovation is less likely than an outlier that may be anywhere.
bool is_outlier(const Innovation& v, const std::vector<std::string>& sources);

/// −½ Σ (nis + ln det S), where no innovation counts as less likely than an outlier that may be anywhere.
double log_likelihood(const std::vector<Innovation>& innovations, const std::vector<std::string>& sources);

/// By how much likelier `granted` is than `base`, without the tenth of all stretches of ten seconds, at least one, that
/// gain most. A cause shows for longer; a stretch of bad fixes would otherwise decide for whatever suits it.
double lasting_gain(const Evidence& granted, const Evidence& base);

/// Mean of the NIS of the first receiver's positions, for each of their rows; of none more than ten counts. 1 without
/// positions.
double nis_of_positions(const std::vector<Innovation>& innovations, const std::vector<std::string>& sources);

/// Filters the log from `start` until `end` [s], without cross-axis errors and g-sensitivity, which innovations hardly
/// show, and without the errors-in-variables correction. The likelihood is that of the innovations under way (Schweppe
/// 1965) in the stretches that count: outliers do not decide.
Evidence filter_again(const Log& log, const FilterOptions& options, const Start& start, double end = kToTheEnd,
                      const Stretches& counted = {});

}  // namespace piste
