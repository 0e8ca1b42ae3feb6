#include "diagnosis/evidence.h"

#include <algorithm>
#include <cmath>

#include "piste/consistency/verdict.h"
#include "piste/core/error.h"
#include "piste/solve/run.h"

namespace piste {
namespace {

// What −2 ln p of an outlier is: one fix in a hundred, anywhere within some 100 m, 10 m/s, or a radian. It does not
// depend on what is granted, so that nothing is gained by smaller sigmas of what is rejected anyway.
double cost_of_outlier(const std::vector<std::string>& sources, const Innovation& v) {
  constexpr double kPart = 0.01, kFar = 100, kFast = 10, kTurned = 1;
  const std::string& source = sources[static_cast<std::size_t>(v.source)];
  const double spread = source.ends_with("position") ? kFar : source.ends_with("velocity") ? kFast : kTurned;
  return 2 * v.dof * std::log(spread) - 2 * std::log(kPart);
}

}  // namespace

Evidence filter_again(const Log& log, const FilterOptions& options, const Start& start, double end) {
  Evidence found;
  try {
    const Solution solution = run_filter(log, options, start, 0, {}, end).solution;
    if (solution.empty()) return found;
    const UnderWay under_way(log, solution.sources, start.time);
    double sum = 0;
    for (const Innovation& v : solution.innovations) {
      if (!under_way.contains(v)) continue;
      sum -= 0.5 * std::min(v.nis + v.log_determinant, cost_of_outlier(solution.sources, v));
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
