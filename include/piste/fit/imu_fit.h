#pragma once
/// Errors of one IMU in one run, axis by axis, from a reference on the same plate.
///
///     measured = (1 + scale) true + bias + noise
///
/// with the reference's signal in the place of the true one. The bias is that of the phase: the turn-on constant and
/// the mean of the in-run drift. Both signals have gone through the same low-pass.
///
/// Two directions. In `reverse` the IMU is regressed on the reference: unbiased where the reference is free of noise.
/// In `forward` the reference is regressed on the IMU, and the line is inverted; noise of the IMU, or a residual timing
/// error, flattens the forward line and so raises its scale. Where both signals are noisy, the truth lies between
/// the two (Frisch 1934), and `both_noisy` says where, if it knows how noisy each is.
///
/// Beyond a line there are a polynomial of the signal, axis by axis, and a matrix that joins the axes of a triad.
///
/// Errors of the reference and of the alignment are propagated too, and kept apart as systematic: they are the same
/// however long the run is, and the same for all IMUs of a run.
///
/// Papers that add a correction write true = (1 + scale') measured + bias'. `correction` goes there, and back.

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
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();             ///< formal: if noise were white
  Eigen::Matrix2d hac_covariance = Eigen::Matrix2d::Zero();         ///< of noise correlated in time
  Eigen::Matrix2d systematic_covariance = Eigen::Matrix2d::Zero();  ///< of errors of the reference and the alignment
  double dof = 1;                                                   ///< effective

  Term bias() const { return term(0); }
  Term scale() const { return term(1); }
  /// Formal, of bias and scale: −mean / rms of the signal where both are free.
  double correlation() const;
  /// Of either's variance, because the other is estimated too: 1 / (1 − correlation²). Above 10 they cannot be told
  /// apart.
  double inflation() const;

 private:
  Term term(int i) const;
};

/// The same line solved for the other signal: true = (1 + scale') measured + bias', so that
/// bias' = −bias / (1 + scale) and scale' = −scale / (1 + scale). Its own inverse.
BiasScale correction(const BiasScale& line);

/// One line by two regressions, both in the usual convention.
struct BothDirections {
  BiasScale reverse;  ///< IMU on reference
  BiasScale forward;  ///< reference on IMU, inverted
};

/// Coefficients of an axis on signals of the reference, in powers or of several axes.
struct Coefficients {
  Regression regression;
  Eigen::MatrixXd systematic_covariance;  ///< of errors of the reference and the alignment

  Term term(int i) const;
  /// The bias and scale that are J times the coefficients.
  BiasScale line(const Eigen::Matrix<double, 2, Eigen::Dynamic>& J) const;
};

/// measured − true = Σ c_j true^j, j = 0 … order, by regression on the reference. Its noise flattens this as it does
/// the reverse line. Of the orders 1 to 3 it is that of the least
///
///     BIC = m ln(Σ e² / n) + (order + 1) ln m
///
/// (Schwarz 1978, Annals of Statistics 6), where m is not the number of samples n but of those that tell something new
/// as the residuals e last: the least of what the coefficients of the square (at order 2) and of the cube (at order 3)
/// are worth, Regression::effective_samples, and at least one more than an order of 3 has coefficients.
struct PolynomialFit {
  static constexpr int kHighest = 3;
  int order = 1;
  std::array<double, kHighest> bic{};  ///< of orders 1, 2, 3
  double effective_samples = 0;        ///< m
  Coefficients coefficients;           ///< c_0 … c_order in powers of the true signal, SI and radians
  BiasScale tangent;  ///< at the mean signal, to be held against `joint`: scale = Σ j c_j mean^(j−1)
};

/// A triad on all axes of the reference,
///
///     measured = (I + G) true + bias (+ S f),   S only of gyroscopes: the g-sensitivity on the specific force f
///
/// row by row, by regression on the reference, whose noise flattens each row. G's diagonal is the scale; off it is what
/// the triad's axes are out of square, and turned against the reference by more than the boresight that was found. The
/// boresight was found from these same signals, so a turn of the triad as a whole is in the boresight and not in G, but
/// for what gyroscopes and accelerometers are turned against each other; the boresight's uncertainty is in the
/// systematic errors. Where the specific force hardly changes, S and the bias can hardly be told apart: see inflation.
struct MatrixFit {
  static constexpr int kBias = 0, kGain = 1, kGSensitivity = 4;  ///< of the coefficients of an axis
  std::array<Coefficients, 3> axes;                              ///< of x, y, z

  bool has_g_sensitivity() const { return axes[0].regression.value.size() > kGSensitivity; }
  Term bias(int axis) const { return at(axis, kBias); }
  Term gain(int axis, int of) const { return at(axis, kGain + of); }
  Term g_sensitivity(int axis, int of) const { return at(axis, kGSensitivity + of); }  ///< [rad/s per m/s²]
  /// Bias and diagonal, to be held against `joint`.
  BiasScale line(int axis) const;

 private:
  Term at(int axis, int i) const { return axes[static_cast<std::size_t>(axis)].term(i); }
};

/// One axis by several models; the reference's signal that they saw.
struct RunFit {
  int samples = 0;
  double mean = 0, rms = 0;  ///< of the reference's signal
  double residual = 0;       ///< rms of what joint.reverse leaves
  /// Mean of measured − reference: bias + scale · mean, which is the joint line at the mean signal. What the scale
  /// makes of the motion counts as noise here, so its interval is wide.
  Term bias_only;
  BothDirections joint;  ///< bias and scale
  /// Bias and scale where both signals are noisy, by Deming's regression. The ratio of the noises is that of the rest
  /// before (else after): of either signal, its variance less the covariance of both, as the sway is common to both
  /// (Grubbs 1948, J. American Statistical Association 43). Where there is no rest, that of the sensors' densities;
  /// where these are not known either, the reference is free of noise. It takes the noise of the run for that of the
  /// rest: it does not know vibration that only one IMU feels, nor what a timing error and a boresight that is not
  /// right make of the motion, and its errors take the ratio for known.
  BiasScale both_noisy;
  double noise_ratio = 1;  ///< variance of the IMU's noise over that of the reference's, from 1e-6 to 1e6
  /// Scale alone: the line passes through the mean point of the rest before (of that after, where there is none
  /// before), whose error is propagated, and with it the sensor's in-run drift from there to the run. At rest an
  /// accelerometer shows bias + scale · gravity, and this line knows it.
  std::optional<BothDirections> scale_only;
  std::optional<PolynomialFit> polynomial;  ///< nothing where the signal has too few different values
};

/// One axis.
struct AxisFindings {
  std::string_view name;                                                   ///< fx fy fz wx wy wz
  Block bias_block = Block::kAccelBias, scale_block = Block::kAccelScale;  ///< whose units files and pictures show
  std::optional<Term> before, after;  ///< at rest: mean of measured − reference, which is bias + scale · mean signal
  std::optional<Term> change;         ///< after − before
  double rest_signal = 0;             ///< mean of the reference at rest before, or after where there is none before
  std::optional<RunFit> run;
};

struct FitOptions {
  const Alignment* alignment = nullptr;  ///< whose covariance is propagated; null = free of errors
  const ImuSensor* reference = nullptr;  ///< whose bias and scale are; null = free of errors
  /// The body IMU: its in-run drift, and its noise density where there is no rest; null = no drift.
  const ImuSensor* sensor = nullptr;
  bool g_sensitivity = true;  ///< the gyroscopes' matrix has one
};

struct Findings {
  Phases phases;
  double low_pass = 0;  ///< [Hz] that both signals went through; 0 = none
  std::array<AxisFindings, 6> axes;
  std::optional<MatrixFit> accel_matrix, gyro_matrix;  ///< nothing where the run does not move all their signals
};

/// Of both IMUs' signals as they went through the same low-pass (low_passed).
/// Throws DataError where a phase that is given has too few usable samples, or the reference stands still in the run.
Findings findings(const AlignedImus& imus, const Phases& phases, const FitOptions& options);

}  // namespace piste
