#pragma once
/// Multiple-model heading search: filters that differ in their initial heading run side by side until the measurements
/// exclude all but one (multiple-model adaptive estimation, MMAE; Magill 1965).
///
/// The weight of a hypothesis is the likelihood of its innovations. If the stated noise is too small, every difference
/// looks decisive. So if the mean NIS of the best hypothesis exceeds one, the NIS of all is divided by it.

#include <cstddef>
#include <span>
#include <vector>

#include "piste/filter/filter.h"

namespace piste {

/// A heading and its 1-sigma [rad]. At 1.8 rad nothing is known, as the deviation of an equal distribution is π/√3.
struct HeadingBelief {
  double value = 0, sigma = 0;
};

/// The filters, one for each hypothesis that is left.
class HeadingSearch {
 public:
  /// Filters from each of these starts, which have the same time. @pre there is a start.
  /// Throws ConfigError if the options are not valid.
  HeadingSearch(const FilterOptions& options, const World& world, std::span<const Start> starts);

  /// As Filter::add(). Hypotheses that the measurements exclude are dropped. Throws DataError if all diverge.
  bool add(const ImuSample& sample);
  void add(int sensor, const AnyFix& fix);

  /// As Filter::look_ahead().
  double look_ahead() const { return best().look_ahead(); }

  /// Whether one heading is left: those of all hypotheses agree, and the best is sure enough of its own.
  bool resolved() const;
  /// The heading, in the local level, of all hypotheses together, with what lies between them.
  HeadingBelief heading() const;
  /// The filter of the likeliest hypothesis, and which of the starts it came from.
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
