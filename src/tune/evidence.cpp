#include "tune/evidence.h"

#include <algorithm>
#include <cmath>

#include "piste/consistency/verdict.h"
#include "piste/core/error.h"
#include "piste/model/height.h"
#include "piste/model/vehicle.h"
#include "piste/solve/run.h"
#include "solve/feeder.h"

namespace piste {
namespace {

// What −2 ln p of an outlier is: one fix in a hundred, anywhere within some 100 m, 10 m/s, or a radian. It does not
// depend on what is granted, so that nothing is gained by smaller sigmas of what is rejected anyway.
double cost_of_outlier(const std::string& source, int dof) {
  constexpr double kPart = 0.01, kFar = 100, kFast = 10, kTurned = 1;
  const bool of_place = source.ends_with("position") || source == Barometer::kName,
             of_speed = source.ends_with("velocity") || source == Odometer::kName;
  const double spread = of_place ? kFar : of_speed ? kFast : kTurned;
  return 2 * dof * std::log(spread) - 2 * std::log(kPart);
}

}  // namespace

double log_likelihood(const std::vector<Innovation>& innovations, const std::vector<std::string>& sources) {
  double sum = 0;
  for (const Innovation& v : innovations) {
    sum += std::min(v.nis + v.log_determinant, cost_of_outlier(sources[static_cast<std::size_t>(v.source)], v.dof));
  }
  return -0.5 * sum;
}

double nis_of_positions(const std::vector<Innovation>& innovations, const std::vector<std::string>& sources) {
  constexpr double kOutlier = 10;
  double sum = 0, rows = 0;
  for (const Innovation& i : innovations) {
    if (sources[static_cast<std::size_t>(i.source)] != "gnss[0].position" || i.outcome == Outcome::kRepeated) continue;
    sum += std::min(i.nis, kOutlier * i.dof);
    rows += i.dof;
  }
  return rows > 0 ? sum / rows : 1;
}

Evidence filter_again(const Log& log, const FilterOptions& options, const Start& start, double end,
                      const Stretches& counted) {
  Evidence found;
  try {
    Filter filter(options, log.world, start);
    LogPlace place = place_at(log, start.time, end);
    Feeder feeder(log, place, filter);
    while (!feeder.done()) feeder.step();
    filter.finish();
    found.sources = filter.sources();
    const UnderWay under_way(log, found.sources, start.time, LookedAt::kMeasured);
    for (const Innovation& v : filter.innovations()) {
      if (!under_way.contains(v) || !counted.contain(v.time - start.time)) continue;
      found.rows += v.dof;
      found.innovations.push_back(v);
    }
    found.likelihood = log_likelihood(found.innovations, found.sources);
    found.last = filter.estimate();
    found.sigmas = sigmas_of(log.world, filter.estimate(), filter.layout(), filter.covariance()).blocks;
  } catch (const Error&) {  // a filter that diverges says that this is not the cause
  }
  return found;
}

}  // namespace piste
