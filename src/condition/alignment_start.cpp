#include "alignment_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "alignment_epochs.h"
#include "condition/boresight.h"
#include "piste/core/error.h"
#include "piste/math/units.h"

namespace piste {
namespace {

void place_knots(AlignmentState& x, double first, double length) {
  constexpr double kSpacing = 5;  // s
  const auto pieces = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(length / kSpacing)));
  x.first_knot = first;
  x.knot_spacing = length / static_cast<double>(pieces);
  x.gyro_drift.assign(pieces + 1, Vector3d::Zero());
  x.accel_drift.assign(pieces + 1, Vector3d::Zero());
}

// Boresight and a rough noise from the rates alone.
BoresightFromRates rates_compared(const SignalPair& signals, const FilteredPair& pair, const AlignmentState& x,
                                  const std::string& name) {
  std::vector<Vector3d> rate_r, rate_b;
  for (const AlignmentEpoch& e : epochs_in_common(signals, pair, x)) {
    if (e.usable.gyro != 7) continue;
    const double t = x.reference_time(pair.body.time[e.sample], pair.body.time.front());
    rate_r.push_back(pair.reference.at(t).signal.gyro);
    rate_b.push_back(pair.body.gyro[e.sample]);
  }
  constexpr std::size_t kFewest = 20;
  if (rate_r.size() < kFewest) {
    throw DataError(name, "the two IMUs have hardly any time in common once gaps and clipped samples are left out");
  }
  BoresightFromRates found = boresight_from_rates(rate_r, rate_b);
  constexpr double kMirrored = 0.6;
  if (found.residual_mirrored < kMirrored * found.residual) {
    throw DataError(name, fmt::format("the axes of one of the two IMUs are left-handed: mirrored, their rates "
                                      "differ by {:.3g} deg/s rms, as they are by {:.3g}; one axis points "
                                      "the other way, or two are swapped",
                                      kDegreesPerRadian * found.residual_mirrored, kDegreesPerRadian * found.residual));
  }
  return found;
}

}  // namespace

AlignmentFit start_alignment(const SignalPair& signals, const FilteredPair& pair, double coarse_offset,
                             const std::string& name) {
  AlignmentFit start;
  AlignmentState& x = start.x;
  const std::vector<double>& time = pair.body.time;
  x.clock = {coarse_offset, 0};
  place_knots(x, time.front(), time.back() - time.front());
  const BoresightFromRates found = rates_compared(signals, pair, x, name);
  x.q_rb = found.q_rb;
  x.gyro_bias = found.gyro_bias;
  start.noise.gyro.fill(std::max(found.residual, 1e-6));
  return start;
}

}  // namespace piste
