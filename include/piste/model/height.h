#pragma once
/// Height over the ellipsoid from a barometer, with an offset that the weather changes: y = h(p) + offset. h is linear
/// about the place of `gravity`: to 1 mm within 100 m.

#include "piste/core/options.h"
#include "piste/model/measurement.h"

namespace piste {

/// Linearises a height: one row.
Linearization linearize_height(const HeightFix& fix, const Estimate& x, const Gravity& gravity);

/// The barometer of a run. By a draught or a door its fixes jump: they are rejected. They are used again once the
/// offset may have drifted as far. They never reset the filter, as its height is not in doubt.
struct Barometer : MeasurementType<HeightFix> {
  static constexpr std::string_view kName = "barometer";
  static constexpr std::array kChannels{MeasurementChannel{.name = "", .readmitted = false, .axes = {"height"}}};
  static int sensors(const FilterOptions& options) { return options.barometer ? 1 : 0; }
  static bool in_use(const FilterOptions& options) { return options.barometer.has_value(); }
  static std::span<const std::vector<HeightFix>> logged(const Log& log) { return {&log.height, 1}; }
  static std::optional<Linearization> linearize(const HeightFix& fix, int, int, const MeasurementContext& context,
                                                const Estimate& x) {
    return linearize_height(fix, x, context.gravity);
  }
};

}  // namespace piste
