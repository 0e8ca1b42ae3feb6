#pragma once
/// The errors-in-variables correction of an alignment for the noise of the reference. The rates and forces of the
/// reference are regressors of the boresight, the lever arm, the scales and the clock. Their noise looks like motion:
/// the information is too large, and a lever arm is estimated too short (Fuller, Measurement Error Models, 1987, 2.2).
///
/// Its size follows from the two IMUs: their difference after alignment is the noise of both. The two sensor files
/// state the share of the reference.

#include "alignment_problem.h"

namespace piste {

/// Part of the variance of the difference of two IMUs that is of the reference, 0 to 1.
struct NoiseShares {
  double gyro = 0, accel = 0;
  bool none() const { return gyro == 0 && accel == 0; }
};

/// By the white noise of the two sensor files. 0 where the body IMU states none.
NoiseShares noise_shares(const ImuSensor& body, const ImuSensor& reference);

/// The samples of the body IMU on the clock, in the axes and at the place of the reference, without its biases. They
/// are not corrected for its scales: noise of the reference makes the scales of `x` wrong by far more than their size.
std::vector<ImuSample> as_reference(const std::vector<ImuSample>& body, const AlignmentState& x);

using Parameters20 = Eigen::Matrix<double, AlignmentLayout::kSize, 1>;

/// Apparent information on the parameters by the noise of the reference alone, summed over epochs.
struct ApparentInformation {
  AlignmentInformation information = AlignmentInformation::Zero();
  AlignmentInformation squares = AlignmentInformation::Zero();  ///< Σ g gᵀ of the gradients of the epochs
  std::size_t count = 0;

  /// The gradient of the least squares by the apparent information S at the true x. For the boresight and the clock it
  /// is zero: noise is neither turned against itself nor late.
  static Parameters20 gradient(const AlignmentInformation& S, const AlignmentState& x);
  void add(const AlignmentInformation& one, const AlignmentState& x);
  /// Covariance of the gradient, as estimated from the noise of that many epochs.
  AlignmentInformation variance(const AlignmentState& x) const;
};

/// `witness` has the body IMU, as as_reference() gives it, for a reference, through the same filters as `pair`.
ApparentInformation apparent_information(const FilteredPair& pair, const FilteredPair& witness,
                                         const std::vector<AlignmentEpoch>& epochs, const AlignmentState& x,
                                         const NoiseShares& shares);

/// Moves the parameters to their estimate without the apparent information. `inverse` is the inverse of the information
/// without it, as inverted() gives it. The drifts stay as they are.
void take_back(AlignmentState& x, const ApparentInformation& apparent, const AlignmentInformation& inverse);

/// The part of the covariance by the scale errors of the reference. Two IMUs observe only the difference of their
/// scales: the lever arm has the same relative error as the reference's scales. In the axes of the body IMU, scale
/// errors along other axes are a shear, a part of which is taken for a boresight.
AlignmentInformation of_reference_scales(const AlignmentState& x, const ImuSensor& reference);

}  // namespace piste
