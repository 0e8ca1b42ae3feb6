#pragma once
/// What the noise of the reference does to an alignment. The rates and forces of the reference are regressors of the
/// boresight, the lever arm, the scales and the clock, and its noise in them looks like motion: the information is too
/// large by it, and a lever arm comes out too short (errors in variables; Fuller, Measurement Error Models, 1987, 2.2).
///
/// How large it is follows from the two IMUs: by what they differ once they are aligned is the noise of both, of which
/// the reference has the share that the two sensor files state.

#include "alignment_problem.h"

namespace piste {

/// Part of the variance of the difference of two IMUs that is of the reference, 0 to 1.
struct NoiseShares {
  double gyro = 0, accel = 0;
  bool none() const { return gyro == 0 && accel == 0; }
};

/// By the white noise of the two sensor files. 0 where the body IMU states none.
NoiseShares noise_shares(const ImuSensor& body, const ImuSensor& reference);

/// The samples of the body IMU on the clock, in the axes and at the place of the reference, without its biases. Its
/// scales stay in them: noise of the reference makes those of `x` wrong by far more than they are.
std::vector<ImuSample> as_reference(const std::vector<ImuSample>& body, const AlignmentState& x);

using Parameters20 = Eigen::Matrix<double, AlignmentLayout::kSize, 1>;

/// Information of the parameters that only the reference's noise makes, summed over epochs.
struct ApparentInformation {
  AlignmentInformation information = AlignmentInformation::Zero();
  AlignmentInformation squares = AlignmentInformation::Zero();  ///< Σ g gᵀ of the gradients of the epochs
  std::size_t count = 0;

  /// What the information S adds to the gradient of the least squares where x is true. That of the boresight and of the
  /// clock is zero: noise is neither turned against itself nor late.
  static Parameters20 gradient(const AlignmentInformation& S, const AlignmentState& x);
  void add(const AlignmentInformation& one, const AlignmentState& x);
  /// Covariance of the gradient: how well the noise of as many epochs tells it.
  AlignmentInformation variance(const AlignmentState& x) const;
};

/// `witness` has the body IMU, as as_reference() gives it, for a reference, through the same filters as `pair`.
ApparentInformation apparent_information(const FilteredPair& pair, const FilteredPair& witness,
                                         const std::vector<AlignmentEpoch>& epochs, const AlignmentState& x,
                                         const NoiseShares& shares);

/// Moves the parameters to where they are without the apparent information. `inverse` is that of the information
/// without it, as inverted() gives it. The drifts stay as they are.
void take_back(AlignmentState& x, const ApparentInformation& apparent, const AlignmentInformation& inverse);

/// What the scale errors of the reference add to the covariance. Two IMUs tell how their scales differ, and not how
/// large each is: the lever arm is off by as many per cent as the reference's scales. And scale errors along axes that
/// are not those of the body IMU look like a shear there, some of which passes for a boresight.
AlignmentInformation of_reference_scales(const AlignmentState& x, const ImuSensor& reference);

}  // namespace piste
