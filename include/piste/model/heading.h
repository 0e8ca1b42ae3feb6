#pragma once
/// A heading that is known from elsewhere, such as that of a start.

#include "piste/model/measurement.h"

namespace piste {

/// Heading of the body: its attitude and the 1-sigma [rad] of the rotation about the vertical. The tilt is not used.
struct HeadingFix {
  double time = 0;
  Quaterniond q_wb;
  double sigma = 0;
};

/// One row: the rotation about w's down axis from the estimated attitude to the given one.
Linearization linearize_heading(const HeadingFix& fix, const Estimate& x);

/// The heading that a start learned only later (solve/start.h).
struct StartHeading : MeasurementType<HeadingFix> {
  static constexpr std::string_view kName = "start";
  static constexpr std::array kChannels{MeasurementChannel{.name = "heading"}};
  static std::optional<Linearization> linearize(const HeadingFix& fix, int, int, const MeasurementContext&,
                                                const Estimate& x) {
    return linearize_heading(fix, x);
  }
};

}  // namespace piste
