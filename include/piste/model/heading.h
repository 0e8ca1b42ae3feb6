#pragma once
/// A heading as a measurement: one that is known from elsewhere, such as the heading of a start.

#include "piste/model/measurement.h"

namespace piste {

/// The heading of an attitude, and its 1-sigma [rad]. The roll and pitch of the attitude are not used.
struct HeadingFix {
  double time = 0;
  Quaterniond q_wb;
  double sigma = 0;
};

/// One row: the rotation about w's down axis from the estimated attitude to the given one.
Linearization linearize_heading(const HeadingFix& fix, const Estimate& x);

/// A heading that a start gives for a later time, such as the departure (solve/start.h).
struct StartHeading : MeasurementType<HeadingFix> {
  static constexpr std::string_view kName = "start";
  static constexpr std::array kChannels{MeasurementChannel{.name = "heading"}};
  static std::optional<Linearization> linearize(const HeadingFix& fix, int, int, const MeasurementContext&,
                                                const Estimate& x) {
    return linearize_heading(fix, x);
  }
};

}  // namespace piste
