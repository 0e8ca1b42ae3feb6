#pragma once
/// Fits the errors of one IMU in one run, axis by axis, to a reference on the same plate:
///
///     measured = (1 + scale) true + bias + noise
///
/// The reference's signal takes the place of the true one. The bias is that of a phase: the turn-on bias plus the mean
/// of the in-run drift. Both signals have gone through the same low-pass.
///
/// A line is fitted in two directions. In `reverse` the IMU is regressed on the reference; this is unbiased if the
/// reference has no noise. In `forward` the reference is regressed on the IMU, and the line is inverted. Noise of the
/// IMU, or a residual timing error, makes the slope of the forward regression too small, and its scale therefore too
/// large. If both signals are noisy, the truth lies between the two (Frisch 1934). `both_noisy` estimates it from the
/// ratio of the two noises.
///
/// Beyond a line there are a polynomial for each axis, and a matrix for the three axes of a triad together.
///
/// Errors of the reference and of the alignment are propagated too. They are kept apart as systematic, because they do
/// not become smaller in a longer run, and are the same for all IMUs of a run.
///
/// Some papers give a correction to add: true = (1 + scale') measured + bias'. `correction` converts to that form and
/// back.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "piste/condition/alignment.h"
#include "piste/core/aligned.h"
#include "piste/core/sensor.h"
#include "piste/core/state_table.h"
#include "piste/fit/phases.h"
#include "piste/fit/regression.h"

namespace piste {

/// The line measured = (1 + scale) true + bias.
struct BiasScale {
  Eigen::Vector2d value = Eigen::Vector2d::Zero();                  ///< bias, scale
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();             ///< formal: as if noise were white
  Eigen::Matrix2d hac_covariance = Eigen::Matrix2d::Zero();         ///< for coloured noise
  Eigen::Matrix2d systematic_covariance = Eigen::Matrix2d::Zero();  ///< of errors of the reference and the alignment
  double dof = 1;                                                   ///< effective
  /// What other estimates of the run share with it, see Term.
  Eigen::Matrix<double, 2, Eigen::Dynamic> averages = {}, effects = {};

  Term bias() const { return term(0); }
  Term scale() const { return term(1); }
  /// Formal correlation of bias and scale: −mean / rms of the signal if both are estimated.
  double correlation() const;
  /// Factor by which the variance of either grows because the other is estimated too: 1 / (1 − correlation²). Above 10
  /// the two cannot be separated.
  double inflation() const;

 private:
  Term term(int i) const;
};

/// The same line as a correction: true = (1 + scale') measured + bias', with bias' = −bias / (1 + scale) and scale' =
/// −scale / (1 + scale). Applied twice it gives the line itself.
BiasScale correction(const BiasScale& line);

/// A line by two regressions. Both are in the convention measured = (1 + scale) true + bias.
struct BothDirections {
  BiasScale reverse;  ///< IMU on reference
  BiasScale forward;  ///< reference on IMU, inverted
};

/// Coefficients of an axis by regression on powers of the reference's signal, or on several of its axes.
struct Coefficients {
  Regression regression;
  Eigen::MatrixXd systematic_covariance;  ///< of errors of the reference and the alignment
  Eigen::MatrixXd effects = {};           ///< E with E Eᵀ = systematic_covariance: of errors of variance 1

  Term term(int i) const;
  /// The bias and scale that are J times the coefficients.
  BiasScale line(const Eigen::Matrix<double, 2, Eigen::Dynamic>& J) const;
};

/// A polynomial measured − true = Σ c_j true^j, j = 0 … order, by regression on the reference. Noise of the reference
/// makes its slope too small, as for the reverse line. Of the orders 1 to 3 it has the one with the least
///
///     BIC = m ln(Σ e² / n) + (order + 1) ln m
///
/// (Schwarz 1978, Annals of Statistics 6). The residuals e are correlated in time. Therefore m is not the number of
/// samples n but that of effective samples, Regression::effective_samples. It is the smaller of the numbers for the
/// square (at order 2) and for the cube (at order 3), and at least one more than the coefficients of order 3.
struct PolynomialFit {
  static constexpr int kHighest = 3;
  int order = 1;
  std::array<double, kHighest> bic{};  ///< of orders 1, 2, 3
  double effective_samples = 0;        ///< m
  Coefficients coefficients;           ///< c_0 … c_order in powers of the true signal, SI and radians
  BiasScale tangent;                   ///< at the mean signal, to compare with `joint`: scale = Σ j c_j mean^(j−1)
};

/// A triad fitted to all axes of the reference,
///
///     measured = (I + G) true + bias (+ S f),   S only of gyroscopes: the g-sensitivity on the specific force f
///
/// row by row, by regression on the reference, whose noise makes the coefficients too small. The diagonal of G is the
/// scale. Its other elements are the non-orthogonality of the triad's axes, and a rotation against the reference beyond
/// the estimated boresight. The boresight was estimated from the same signals: a rotation of the whole triad is part of
/// the boresight and not of G. Only the rotation between gyroscopes and accelerometers is in G. The uncertainty of the
/// boresight is part of the systematic errors. If the specific force hardly changes, S and the bias can hardly be
/// separated: see inflation.
struct MatrixFit {
  static constexpr int kBias = 0, kGain = 1, kGSensitivity = 4;  ///< of the coefficients of an axis
  std::array<Coefficients, 3> axes;                              ///< of x, y, z

  bool has_g_sensitivity() const { return axes[0].regression.value.size() > kGSensitivity; }
  Term bias(int axis) const { return at(axis, kBias); }
  Term gain(int axis, int of) const { return at(axis, kGain + of); }
  Term g_sensitivity(int axis, int of) const { return at(axis, kGSensitivity + of); }  ///< [rad/s per m/s²]
  /// Bias and diagonal, to compare with `joint`.
  BiasScale line(int axis) const;

 private:
  Term at(int axis, int i) const { return axes[static_cast<std::size_t>(axis)].term(i); }
};

/// The fits of one axis in the run by several models, and statistics of the reference's signal.
struct RunFit {
  int samples = 0;
  double mean = 0, rms = 0;  ///< of the reference's signal
  double residual = 0;       ///< rms of the residuals of joint.reverse
  /// Mean of measured − reference. This is bias + scale · mean signal, the joint line at the mean signal. The effect of
  /// the scale in the motion counts as noise here, so the interval is wide.
  Term bias_only;
  BothDirections joint;  ///< bias and scale
  /// Bias and scale by Deming's regression, which allows for noise in both signals. The ratio of the noises is measured
  /// at rest (before, else after). The noise variance of a signal is its variance less the covariance of both signals,
  /// because both measure the same sway (Grubbs 1948, J. American Statistical Association 43). Without a rest the ratio
  /// is that of the sensors' noise densities; if these are unknown, the reference is taken to have no noise.
  ///
  /// The noise in the run is assumed to be that at rest. Vibration that only one IMU senses is not taken into account,
  /// nor are the effects of a timing error or of a wrong boresight. The standard errors assume that the ratio is known.
  BiasScale both_noisy;
  double noise_ratio = 1;  ///< variance of the IMU's noise over that of the reference's, from 1e-6 to 1e6
  /// Scale alone: a line through the mean point of the rest before (or after, if there is none before). The error of
  /// that point is propagated, together with the sensor's in-run drift from the rest to the run. That an accelerometer
  /// at rest shows bias + scale · gravity is thereby taken into account.
  std::optional<BothDirections> scale_only;
  std::optional<PolynomialFit> polynomial;  ///< nothing if the signal has too few different values
};

/// All fits of one axis.
struct AxisFindings {
  std::string_view name;                                                   ///< fx fy fz wx wy wz
  Block bias_block = Block::kAccelBias, scale_block = Block::kAccelScale;  ///< give the units in files and pictures
  std::optional<Term> before, after;  ///< at rest: mean of measured − reference, which is bias + scale · mean signal
  std::optional<Term> change;         ///< after − before
  double rest_signal = 0;             ///< mean of the reference at rest before; else after
  std::optional<RunFit> run;
};

/// The known alignment and sensor models.
struct FitOptions {
  const Alignment* alignment = nullptr;  ///< its covariance is propagated; null = no errors
  const ImuSensor* reference = nullptr;  ///< its bias and scale are propagated; null = no errors
  /// The body IMU, for its in-run drift, and without a rest for its noise density. Null = no drift.
  const ImuSensor* sensor = nullptr;
  bool g_sensitivity = true;  ///< whether the gyroscopes' matrix has one
};

/// All fits of one IMU in one run.
struct Findings {
  Phases phases;
  double low_pass = 0;  ///< cut-off of both signals [Hz]; 0 = none
  std::array<AxisFindings, 6> axes;
  std::optional<MatrixFit> accel_matrix, gyro_matrix;  ///< nothing if a signal of theirs does not change in the run
};

/// Fits all models. @pre both IMUs' signals have gone through the same low-pass (low_passed)
/// Throws DataError if a given phase has too few usable samples, or if the reference does not move in the run.
Findings findings(const AlignedImus& imus, const Phases& phases, const FitOptions& options);

}  // namespace piste
