#pragma once
/// Heading of a baseline on the body, as two antennas measure it: its azimuth in the local level, and how far it points
/// above it.

#include <optional>

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Linearises the azimuth of a baseline (in b, any length), wrapped to ±π, and its pitch, if the fix has one: one or
/// two rows. `R_wn`: the local level at the body. Nothing for a baseline within 10 deg of upright: its azimuth is not
/// defined well.
std::optional<Linearization> linearize_heading(const HeadingFix& fix, const Vector3d& baseline, const Estimate& x,
                                               const Matrix3d& R_wn);

/// The two antennas of a run. While an ambiguity is wrong, their azimuth may be wrong by any angle. So a fix outside
/// the gate is rejected, and never resets the filter. The filter keeps the heading that the motion determines. Where
/// the heading is not observable, its own sigma widens the gate.
struct DualHeading : MeasurementType<HeadingFix> {
  static constexpr std::string_view kName = "heading";
  static constexpr std::array kChannels{
      MeasurementChannel{.name = "", .readmitted = false, .axes = {"heading", "pitch"}}};
  static int sensors(const FilterOptions& options) { return options.heading ? 1 : 0; }
  static bool in_use(const FilterOptions& options) { return options.heading.has_value(); }
  static std::span<const std::vector<HeadingFix>> logged(const Log& log) { return {&log.heading, 1}; }
  static std::optional<Linearization> linearize(const HeadingFix& fix, int, int, const MeasurementContext& context,
                                                const Estimate& x) {
    return linearize_heading(fix, context.options.heading->baseline, x, context.gravity.R_wn);
  }
};

}  // namespace piste
