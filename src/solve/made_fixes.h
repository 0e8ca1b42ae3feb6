#pragma once
// The fixes that need no log (MeasurementType::interval).

#include <cmath>
#include <optional>

#include "piste/model/measurement_list.h"

namespace piste {

/// Calls `f.operator()<Type>(fix)` for each type of which a fix is due at the end of a sample: where a multiple of its
/// interval has gone by. Nothing is due in a gap.
template <class F>
void make_fixes(const ImuSample& sample, const FilterOptions& options, F&& f) {
  if (sample.gap) return;
  const double begin = sample.time - sample.interval;
  MeasurementList::for_each([&]<class Type>() {
    const std::optional<double> every = Type::interval(options);
    if (!every || std::floor(sample.time / *every) == std::floor(begin / *every)) return;
    typename Type::Fix fix{};
    fix.time = sample.time;
    f.template operator()<Type>(fix);
  });
}

}  // namespace piste
