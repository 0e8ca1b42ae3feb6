#include "study/timing_effect.h"

#include <fmt/format.h>

#include "piste/core/error.h"

namespace piste {

TimingEffect timing_effect(const AlignedImus& imus, const Interval& run, double delay) {
  constexpr int kFewest = 30;
  using Signals = Eigen::Array<double, kSignals, 1>;
  const auto row = [](const Vector3d& accel, const Vector3d& gyro) {
    Signals out;
    out << accel, gyro;
    return out;
  };
  const auto each = [&](auto&& visit) {
    int samples = 0;
    for (std::size_t i = 0; i < imus.time.size(); ++i) {
      if (!imus.usable[i] || !run.contains(imus.time[i])) continue;
      visit(row(imus.accel[i], imus.gyro[i]), row(imus.reference_accel[i], imus.reference_gyro[i]));
      ++samples;
    }
    return samples;
  };
  Signals measured_mean = Signals::Zero(), reference_mean = Signals::Zero();
  const int samples = each([&](const Signals& measured, const Signals& reference) {
    measured_mean += measured;
    reference_mean += reference;
  });
  if (samples < kFewest)
    throw DataError("", fmt::format("{} samples of the run are usable, at least {} are needed", samples, kFewest));
  measured_mean /= samples;
  reference_mean /= samples;
  Signals mm = Signals::Zero(), mr = Signals::Zero(), rr = Signals::Zero();
  each([&](const Signals& measured, const Signals& reference) {
    const Signals m = measured - measured_mean, r = reference - reference_mean;
    mm += m * m;
    mr += m * r;
    rr += r * r;
  });
  if (!((mr.abs() > 0).all())) throw DataError("", "an axis has no motion in the run");
  TimingEffect out{.delay = delay};
  const Signals forward = mm / mr - 1, reverse = mr / rr - 1;
  for (int axis = 0; axis < kSignals; ++axis) {
    out.forward[static_cast<std::size_t>(axis)] = forward(axis);
    out.reverse[static_cast<std::size_t>(axis)] = reverse(axis);
  }
  return out;
}

}  // namespace piste
