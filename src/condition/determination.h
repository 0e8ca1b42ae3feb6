#pragma once
/// Decides which parameters of an alignment the motion determines.

#include <Eigen/Core>

#include "piste/condition/alignment.h"
#include "piste/core/sensor.h"

namespace piste {

using AlignmentInformation = Eigen::Matrix<double, AlignmentLayout::kSize, AlignmentLayout::kSize>;

/// The information of an alignment, from the information matrix A of its least squares, its apparent part S
/// (reference_noise.h), and the covariance V of the gradient that S adds.
struct AlignmentInverse {
  AlignmentInformation known;  ///< (A − S)⁻¹, zero along directions with sigmas above their limits
  AlignmentInformation covariance;  ///< (A − S)⁻¹ (A + V) (A − S)⁻¹, and a hundred limits along undetermined directions
};
AlignmentInverse inverted(const AlignmentInformation& information, const AlignmentInformation& apparent,
                          const AlignmentInformation& variance, const ImuSensor& sensor);

/// Sets the covariance of `alignment`, and lists the parameters that are not determined: those whose sigma exceeds a
/// limit above which the value is of no use.
void determine(Alignment& alignment, const AlignmentInformation& covariance, const ImuSensor& sensor);

}  // namespace piste
