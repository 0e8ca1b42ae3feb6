#pragma once
/// Finds the coarse offset of two clocks from the norms of two angular rates, without a first guess.

#include <vector>

#include "piste/condition/time_sync.h"

namespace piste {

/// Norms of an angular rate, as means over cells of equal length.
struct RateNorms {
  double start = 0, step = 0;  ///< cell i is (start + i · step, … + step]
  std::vector<double> value;
};

/// The norms of the mean rates over cells of length `step`.
RateNorms rate_norms(const std::vector<ImuSample>& imu, double step);

/// The result of a search over all overlaps of at least `shortest` seconds.
struct CoarseOffset {
  CorrelationPeak peak;   ///< offsets are the clock of b minus that of r
  double evidence = 0;    ///< log-likelihood of the best offset over that of no relation
  double over_rival = 0;  ///< log-likelihood of the best offset over that of the best one elsewhere
};

/// Computes the normalised cross-correlation at every offset, over all that overlaps, and takes the offset with the
/// greatest likelihood, refined by a parabola. @pre both have the same step
CoarseOffset correlate(const RateNorms& body, const RateNorms& reference, double shortest);

/// Difference in log-likelihood between a correlation of `high` and one of `low` over that many seconds. It takes into
/// account that neighbouring samples of a moving body are not independent.
double evidence_over(double high, double low, double seconds);

/// Difference in log-likelihood that is taken as certain: one in some millions.
constexpr double kEvident = 15;

/// The offset of the clocks from all samples. Throws DataError, of the log `name`, if the motion does not determine it,
/// if it fits several offsets, or if the clock of b runs at a wrong rate.
CoarseOffset find_offset(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference, double shortest,
                         const std::string& name);

}  // namespace piste
