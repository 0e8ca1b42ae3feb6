#include "diagnosis/evidence.h"

#include <algorithm>

#include "piste/consistency/verdict.h"
#include "piste/core/error.h"
#include "piste/solve/run.h"

namespace piste {

Evidence filter_again(const Log& log, const FilterOptions& options, const Start& start, double end) {
  constexpr double kMostGates = 3;
  Evidence found;
  try {
    const Solution solution = run_filter(log, options, start, 0, {}, end).solution;
    if (solution.empty()) return found;
    const UnderWay under_way(log, solution.sources, start.time);
    double sum = 0;
    for (const Innovation& v : solution.innovations) {
      if (!under_way.contains(v)) continue;
      sum -= 0.5 * (std::min(v.nis, kMostGates * v.gate) + v.log_determinant);
      found.rows += v.dof;
    }
    found.likelihood = sum;
    found.last = solution.estimate(solution.size() - 1);
    found.sigmas = solution.sigmas(solution.size() - 1).blocks;
  } catch (const Error&) {  // a filter that diverges says that this is not the cause
  }
  return found;
}

}  // namespace piste
