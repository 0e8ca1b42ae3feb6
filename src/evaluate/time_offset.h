#pragma once
/// Estimates the time offset between two trajectories.

#include <functional>
#include <vector>

#include "evaluate/path.h"

namespace piste {

/// Rows of the same times of both trajectories, in one frame.
struct Epochs {
  std::vector<FramedRow> a, b;
  std::size_t in_gaps = 0, outside = 0;  ///< rows left out
};

inline std::vector<Vector3d> positions(const std::vector<FramedRow>& rows) {
  std::vector<Vector3d> out;
  out.reserve(rows.size());
  for (const FramedRow& row : rows) out.push_back(row.position);
  return out;
}

struct TimeOffset {
  double value = 0, sigma = 0;
};

/// The shift [s] of the first trajectory's times at which the aligned places are nearest: the mean square of a − b is
/// least. `epochs` gives the aligned rows at a shift. A grid within `search` about `start`, then a search by golden
/// section. The sigma is that of least squares with the residuals' own spread. Throws DataError if nothing moves, or
/// the least lies at the end of the search.
TimeOffset find_time_offset(const std::function<Epochs(double)>& epochs, double start, double search);

}  // namespace piste
