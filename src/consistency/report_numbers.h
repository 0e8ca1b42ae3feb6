#pragma once
/// The numbers of a consistency report as text.

#include <cstddef>
#include <string>

#include "piste/consistency/consistency.h"
#include "piste/math/statistics.h"

namespace piste {

/// A mean, with a * if its test fails.
std::string starred(double value, const MeanTest& test);

/// "0.934 to 1.068".
std::string band_text(const Band& band);

/// "99.9 %" of 0.999.
std::string percent(double probability);

/// Mean NEES of a group under way, with a * if its test fails. "-" if there is none.
std::string nees_text(const EstimatorConsistency& estimator, std::size_t group);

/// RMSE of a block under way divided by its bound. "-" if there is none.
std::string ratio_text(const ConsistencyReport& report, const EstimatorConsistency& estimator, Block block);

/// The largest error of the heading in degrees and in sigmas. "-" if there is no run.
std::string heading_text(const HeadingFound& heading);

}  // namespace piste
