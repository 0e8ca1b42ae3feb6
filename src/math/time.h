#pragma once
/// Lengths of time [s].

namespace piste {

inline constexpr double kHour = 3600, kDay = 24 * kHour, kWeek = 7 * kDay;

}  // namespace piste
