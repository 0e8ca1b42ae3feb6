#pragma once
/// The offset of two clocks without a prior, from the norms of two angular rates.

#include <vector>

#include "piste/condition/time_sync.h"

namespace piste {

/// Norms of an angular rate over cells of equal length.
struct RateNorms {
  double start = 0, step = 0;  ///< cell i is (start + i · step, … + step]
  std::vector<double> value;
};

/// Means of the rate over cells of `step`, as norms.
RateNorms rate_norms(const std::vector<ImuSample>& imu, double step);

/// What a search over all overlaps of at least `shortest` seconds found.
struct CoarseOffset {
  CorrelationPeak peak;   ///< offsets of the clocks: b's minus r's
  double evidence = 0;    ///< gain in log-likelihood over no relation at all, of samples that are independent
  double over_rival = 0;  ///< over the best offset elsewhere
};

/// Normalised cross-correlation of the parts that overlap at each offset, in full; the offset with the greatest
/// likelihood, refined by a parabola. Both of the same step.
CoarseOffset correlate(const RateNorms& body, const RateNorms& reference, double shortest);

/// Log-likelihood by which a correlation of `high` over that many seconds stands out against one of `low`, neighbouring
/// samples of a moving body not being independent.
double evidence_over(double high, double low, double seconds);

/// Log-likelihood that is taken for certain: one in some millions.
constexpr double kCertain = 15;

/// The offset of the clocks from all samples. Throws DataError, of the log `name`, where the motion does not tell it,
/// tells several, or where the clock of b runs at a wrong rate.
CoarseOffset find_offset(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference, double shortest,
                         const std::string& name);

}  // namespace piste
