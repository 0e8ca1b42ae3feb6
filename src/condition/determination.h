#pragma once
/// Decides which parameters of an alignment the motion determines.

#include <Eigen/Core>

#include "piste/condition/alignment.h"
#include "piste/core/sensor.h"

namespace piste {

using AlignmentInformation = Eigen::Matrix<double, AlignmentLayout::kSize, AlignmentLayout::kSize>;

/// What an alignment knows, from the information matrix A of its least squares, the part S of it that is apparent
/// (reference_noise.h), and the covariance V of the gradient that S adds.
struct AlignmentInverse {
  AlignmentInformation known;       ///< (A − S)⁻¹, zero along what is known no better than its limit
  AlignmentInformation covariance;  ///< (A − S)⁻¹ (A + V) (A − S)⁻¹, and a hundred limits along what is not known
};
AlignmentInverse inverted(const AlignmentInformation& information, const AlignmentInformation& apparent,
                          const AlignmentInformation& variance, const ImuSensor& sensor);

/// Sets the covariance of `alignment`, and lists the parameters that are not determined: those whose sigma exceeds a
/// limit above which the value is of no use.
void determine(Alignment& alignment, const AlignmentInformation& covariance, const ImuSensor& sensor);

}  // namespace piste
