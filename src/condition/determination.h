#pragma once
/// Decides which parameters of an alignment the motion determines.

#include <Eigen/Core>

#include "piste/condition/alignment.h"
#include "piste/core/sensor.h"

namespace piste {

using AlignmentInformation = Eigen::Matrix<double, AlignmentLayout::kSize, AlignmentLayout::kSize>;

/// Sets the covariance of `alignment` from the information matrix of the least squares, and lists the parameters that
/// are not determined: those whose sigma exceeds a limit above which the value is of no use. `apparent` is the part of
/// the boresight's information, the same about every axis, that only the reference's noise makes. It is subtracted,
/// because noise is not a rotation.
void determine(Alignment& alignment, AlignmentInformation information, double apparent, const ImuSensor& sensor);

}  // namespace piste
