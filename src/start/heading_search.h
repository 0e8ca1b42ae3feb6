#pragma once
/// Multiple-model heading search: filters that differ in their initial heading run in parallel until the measurements
/// exclude all but one (multiple-model adaptive estimation, MMAE; Magill 1965).
///
/// The weight of a hypothesis is the likelihood of its innovations. If the stated noise is too small, every difference
/// looks decisive. So if the mean NIS per row of the best hypothesis exceeds one, the NIS of all is divided by it.

#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

#include "piste/filter/filter.h"

namespace piste {

/// 1-sigma of a heading of which nothing is known: that of a uniform distribution [rad].
inline constexpr double kUnknownHeading = std::numbers::pi / std::numbers::sqrt3;

/// A heading and its 1-sigma [rad], at most kUnknownHeading.
struct HeadingEstimate {
  double value = 0, sigma = 0;
};

/// The filters of the remaining hypotheses.
class HeadingSearch {
 public:
  /// Starts one filter from each of these starts, which have the same time. @pre There is a start.
  /// Throws ConfigError if the options are not valid.
  HeadingSearch(const FilterOptions& options, const World& world, std::span<const Start> starts);

  /// As Filter::add(). Hypotheses that the measurements exclude are dropped. Throws DataError if all diverge.
  bool add(const ImuSample& sample);
  void add(int sensor, const AnyFix& fix);

  /// As Filter::look_ahead().
  double look_ahead() const { return best().look_ahead(); }

  /// Whether one heading is left: all hypotheses agree, and the best is certain enough of its own.
  bool resolved() const;
  /// The heading in the local level, as the mean of all hypotheses. Its sigma includes their differences.
  HeadingEstimate heading() const;
  /// The filter of the most likely hypothesis, and the index of its start.
  const Filter& best() const { return all_[best_].filter; }
  std::size_t best_start() const { return all_[best_].start; }
  std::size_t size() const { return all_.size(); }

 private:
  struct Hypothesis {
    Filter filter;
    std::size_t start;
    // Sums over its innovations:
    double nis = 0, log_determinant = 0, rows = 0;
    double weight = 1;
  };

  void weigh();
  double apart(const Hypothesis& h, const Quaterniond& q_wn) const;
  Quaterniond local_level() const;

  World world_;
  StartOptions options_;
  std::vector<Hypothesis> all_;
  std::size_t best_ = 0;
};

}  // namespace piste
