#pragma once
/// Errors of one IMU in one run, axis by axis, from a reference on the same plate.
///
///     measured = (1 + scale) true + bias + noise
///
/// with the reference's signal in the place of the true one. The bias is that of the phase: the turn-on constant and
/// the mean of the in-run drift. Both signals go through the same low-pass first.
///
/// Two directions. In `reverse` the IMU is regressed on the reference: unbiased where the reference is free of noise.
/// In `forward` the reference is regressed on the IMU, and the line is inverted; noise of the IMU, or a residual timing
/// error, flattens the forward line and so raises its scale. Where both signals are noisy, the truth lies between
/// the two (Frisch 1934).
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

#include "piste/analyse/phases.h"
#include "piste/analyse/regression.h"
#include "piste/condition/time_sync.h"
#include "piste/core/aligned.h"
#include "piste/core/sensor.h"
#include "piste/core/state_layout.h"

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

/// The same by three models; the reference's signal that they saw.
struct RunFit {
  int samples = 0;
  double mean = 0, rms = 0;  ///< of the reference's signal
  double residual = 0;       ///< rms of what joint.reverse leaves
  /// Mean of measured − reference: bias + scale · mean, which is the joint line at the mean signal. What the scale
  /// makes of the motion counts as noise here, so its interval is wide.
  Term bias_only;
  BothDirections joint;  ///< bias and scale
  /// Scale alone: the line passes through the mean point of the rest before (of that after, where there is none
  /// before), whose error is propagated. At rest an accelerometer shows bias + scale · gravity, and this line knows it.
  std::optional<BothDirections> scale_only;
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
  double low_pass = 12;                  ///< [Hz] of both signals; 0 = none
  const Alignment* alignment = nullptr;  ///< whose covariance is propagated; null = free of errors
  const ImuSensor* reference = nullptr;  ///< whose bias and scale are; null = free of errors
};

struct Findings {
  Phases phases;
  double low_pass = 0;
  std::array<AxisFindings, 6> axes;
};

/// Throws DataError where a phase that is given has too few usable samples, or the reference stands still in the run.
Findings findings(const AlignedImus& imus, const Phases& phases, const FitOptions& options);

}  // namespace piste
