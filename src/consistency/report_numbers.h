#pragma once
/// The numbers of a consistency report as text.

#include <cstddef>
#include <string>

#include "piste/consistency/consistency.h"
#include "piste/math/statistics.h"

namespace piste {

/// A value, with a * if it is outside its band.
std::string starred(double value, const Band& band);

/// "0.934 to 1.068".
std::string band_text(const Band& band);

/// "99.9 %" of 0.999.
std::string percent(double probability);

/// Mean NEES of a group under way, with a * if it is outside its band. "-" if there is none.
std::string nees_text(const ConsistencyReport& report, const EstimatorConsistency& estimator, std::size_t group);

/// RMSE of a block under way divided by its bound. "-" if there is none.
std::string ratio_text(const ConsistencyReport& report, const EstimatorConsistency& estimator, Block block);

/// The largest error of the heading in degrees and in sigmas. "-" if there is no run.
std::string heading_text(const HeadingFound& heading);

}  // namespace piste
