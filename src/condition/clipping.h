#pragma once
/// The bound at which a sample counts as clipped by the range of its sensor.

namespace piste {

/// The fraction of a sensor's range from which on a value is clipped: rounding may leave it below the range.
inline constexpr double kAtRange = 0.999;

}  // namespace piste
