#pragma once
/// The numbers of a consistency report as texts, pages and tables show them.

#include <cstddef>
#include <string>

#include "piste/consistency/consistency.h"
#include "piste/math/statistics.h"

namespace piste {

/// With a * where it lies outside.
std::string starred(double value, const Band& band);

/// "0.934 to 1.068".
std::string band_text(const Band& band);

/// "99.9 %" of 0.999.
std::string percent(double probability);

/// Mean NEES of a group under way, starred outside its band; "-" where there is none.
std::string nees_text(const ConsistencyReport& report, const EstimatorConsistency& estimator, std::size_t group);

/// RMSE of a block under way over its bound; "-" where there is none.
std::string ratio_text(const ConsistencyReport& report, const EstimatorConsistency& estimator, Block block);

/// The largest error of the heading in degrees and in sigmas; "-" where no run was looked at.
std::string heading_text(const HeadingFound& heading);

}  // namespace piste
