#include "evaluate/time_offset.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

// Mean square of the distances; infinite where there is no common time.
double mean_square(const Epochs& epochs) {
  double sum = 0;
  for (std::size_t i = 0; i < epochs.a.size(); ++i) sum += (epochs.a[i].position - epochs.b[i].position).squaredNorm();
  return sum / static_cast<double>(epochs.a.size());
}

// 1-sigma of the shift: residual over the rms speed of the reference, root of the number of independent distances.
double sigma_of(const Epochs& epochs) {
  double information = 0;
  std::vector<double> along;
  for (std::size_t i = 1; i < epochs.b.size(); ++i) {
    const double dt = epochs.b[i].time - epochs.b[i - 1].time;
    const Vector3d v = (epochs.b[i].position - epochs.b[i - 1].position) / dt;
    information += v.squaredNorm();
    along.push_back(v.dot(epochs.a[i].position - epochs.b[i].position));
  }
  if (!(information > 0)) throw DataError("", "the reference does not move: no time offset can be found");
  // Errors of successive rows are alike: the standard error is that of a correlated series.
  return along.size() < 3 ? 0 : standard_error_of_series(along) * static_cast<double>(along.size()) / information;
}

}  // namespace

TimeOffset find_time_offset(const std::function<Epochs(double)>& epochs, double start, double search) {
  constexpr int kGrid = 40;  // steps on each side
  const double step = search / kGrid;
  const auto cost = [&](double shift) {
    try {
      return mean_square(epochs(shift));
    } catch (const DataError&) {  // no common time there
      return std::numeric_limits<double>::infinity();
    }
  };
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int k = -kGrid; k <= kGrid; ++k) {
    const double at = cost(start + k * step);
    if (at < least) {
      least = at;
      best = k;
    }
  }
  if (std::abs(best) == kGrid) {
    throw DataError("", fmt::format("no time offset within {:g} s of {:g} s fits best; state one near: --time-offset",
                                    search, start));
  }
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double low = start + (best - 1) * step, high = start + (best + 1) * step;
  double inner = high - golden * (high - low), outer = low + golden * (high - low);
  double at_inner = cost(inner), at_outer = cost(outer);
  constexpr double kFine = 1e-6;  // s
  while (high - low > kFine) {
    if (at_inner < at_outer) {
      high = outer;
      outer = inner;
      at_outer = at_inner;
      inner = high - golden * (high - low);
      at_inner = cost(inner);
    } else {
      low = inner;
      inner = outer;
      at_inner = at_outer;
      outer = low + golden * (high - low);
      at_outer = cost(outer);
    }
  }
  const double value = (low + high) / 2;
  return {value, sigma_of(epochs(value))};
}

}  // namespace piste
