#pragma once
/// Which rows of a run are taken at a rate.

#include <cmath>
#include <cstddef>
#include <vector>

#include "piste/core/solution.h"

namespace piste {

/// Chooses rows at a rate [Hz], 0 being that of the IMU: a row is taken if neither of its neighbours is nearer to the
/// same multiple of 1 / rate. Rows so chosen are chosen again at the same rate.
class RowRate {
 public:
  explicit RowRate(double rate) : rate_(rate) {}
  bool all() const { return rate_ == 0; }
  /// The next row's time. Returns whether the row before it is taken.
  bool next(double time) {
    const double at = time * rate_, place = std::round(at), off = std::abs(at - place);
    const bool rival = place == place_, taken = waits_ && !beaten_ && !(rival && off < off_);
    beaten_ = waits_ && rival && off_ <= off;
    waits_ = true;
    place_ = place;
    off_ = off;
    return taken;
  }
  /// Whether the last row is taken.
  bool last() const { return waits_ && !beaten_; }

 private:
  double rate_, place_ = 0, off_ = 0;
  bool waits_ = false, beaten_ = false;
};

/// The rows of a solution at a rate.
inline std::vector<std::size_t> rows_at(const Solution& solution, double rate) {
  std::vector<std::size_t> rows;
  RowRate at(rate);
  for (std::size_t i = 0; i < solution.size(); ++i) {
    if (at.all()) {
      rows.push_back(i);
    } else if (at.next(solution.time(i))) {
      rows.push_back(i - 1);
    }
  }
  if (!at.all() && at.last()) rows.push_back(solution.size() - 1);
  return rows;
}

}  // namespace piste
