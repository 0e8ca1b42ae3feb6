#pragma once
/// Figures of an alignment.

#include <string>
#include <vector>

#include "piste/condition/alignment.h"
#include "piste/core/aligned.h"
#include "piste/core/log.h"
#include "piste/core/sensor.h"
#include "piste/fit/imu_fit.h"
#include "piste/plot/figure.h"

namespace piste {

/// The input of the figures and of the page. No pointer may be null; the objects are not owned.
struct AlignmentPicture {
  std::string title, version, config_text;
  const Alignment* alignment = nullptr;
  const AlignedImus* aligned = nullptr;          ///< from bring_together(), not filtered
  const std::vector<ImuSample>* body = nullptr;  ///< the input of align, each on its own clock
  const std::vector<ImuSample>* reference = nullptr;
  double low_pass = 0;                 ///< cut-off of both signals [Hz]; 0 = none
  ImuSensor sensor;                    ///< of the body IMU
  const Findings* findings = nullptr;  ///< its errors, of `compare`; null: they were not estimated
};

/// Norms of the rates before the alignment, each on its own clock, and after it: the whole log, and some seconds of the
/// fastest motion.
std::vector<Figure> clock_figures(const AlignmentPicture& picture);
/// Correlation of the norms over the offset: all offsets, and the offsets near the peak.
std::vector<Figure> correlation_figures(const AlignmentPicture& picture);
/// Each axis of rate and force over the seconds of the fastest motion: body IMU, reference, and their difference.
std::vector<Figure> signal_figures(const AlignmentPicture& picture);
/// Spectra of the body IMU's rate and force and of the residuals, and the noise level of the sensor file.
std::vector<Figure> spectrum_figures(const AlignmentPicture& picture);
/// Offset of the clocks in stretches of the log: the whole offset, and its difference from the alignment. Empty if
/// there are no stretches.
std::vector<Figure> drift_figures(const AlignmentPicture& picture);

/// All figures, in that order.
std::vector<Figure> alignment_figures(const AlignmentPicture& picture);

}  // namespace piste
