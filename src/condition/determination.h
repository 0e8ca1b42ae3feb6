#pragma once
/// What an alignment may be said to know.

#include <Eigen/Core>

#include "piste/condition/alignment.h"
#include "piste/core/sensor.h"

namespace piste {

using AlignmentInformation = Eigen::Matrix<double, AlignmentLayout::kSize, AlignmentLayout::kSize>;

/// Sets the covariance from the information of the least squares, and says what is not determined: what has a sigma
/// beyond the limit above which nobody would call it known. `apparent` is the part of the boresight's information, the
/// same about every axis, that comes of the reference's noise alone; it is taken away, for noise turns nothing.
void determine(Alignment& alignment, AlignmentInformation information, double apparent, const ImuSensor& sensor);

}  // namespace piste
