#pragma once
/// What an alignment looks like.

#include <string>
#include <vector>

#include "piste/condition/alignment.h"
#include "piste/core/aligned.h"
#include "piste/core/log.h"
#include "piste/core/sensor.h"
#include "piste/plot/figure.h"

namespace piste {

/// All that there is to show. The pointers are none of them null, and what they point to is not owned.
struct AlignmentPicture {
  std::string title, version, config_text;
  const Alignment* alignment = nullptr;
  const AlignedImus* aligned = nullptr;          ///< by bring_together, unfiltered
  const std::vector<ImuSample>* body = nullptr;  ///< as align took them, each on its own clock
  const std::vector<ImuSample>* reference = nullptr;
  double low_pass = 0;  ///< [Hz] that both signals went through; 0 = none
  ImuSensor sensor;     ///< of the body IMU
};

/// Norms of the rates on their own clocks, before and after: whole, and some seconds of the liveliest motion.
std::vector<Figure> clock_figures(const AlignmentPicture& picture);
/// Correlation of the norms over the offset: all, and its peak.
std::vector<Figure> correlation_figures(const AlignmentPicture& picture);
/// Each axis of rate and force over the liveliest seconds: body IMU, reference, and what is left between them.
std::vector<Figure> signal_figures(const AlignmentPicture& picture);
/// Spectra of the body IMU's rate and force, of what is left, and the level that the sensor file knows.
std::vector<Figure> spectrum_figures(const AlignmentPicture& picture);
/// Offset of the clocks in stretches of the log: in all, and beside what the alignment says. Empty where it has none.
std::vector<Figure> drift_figures(const AlignmentPicture& picture);

/// All of them, in that order.
std::vector<Figure> alignment_figures(const AlignmentPicture& picture);

}  // namespace piste
