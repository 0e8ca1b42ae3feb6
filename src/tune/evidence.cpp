#include "tune/evidence.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <unordered_map>

#include "filter/feeder.h"
#include "filter/kalman_filter.h"
#include "piste/consistency/verdict.h"
#include "piste/core/error.h"
#include "piste/filter/run.h"
#include "piste/model/height.h"
#include "piste/model/vehicle.h"

namespace piste {
namespace {

// What −2 ln p of an outlier is: one fix in a hundred, anywhere within some 100 m, 10 m/s, or a radian. It does not
// depend on what is granted, so that nothing is gained by smaller sigmas of what is rejected anyway.
double cost_of_outlier(const Innovation& v, const std::vector<std::string>& sources) {
  constexpr double kPart = 0.01, kFar = 100, kFast = 10, kTurned = 1;
  const std::string& source = sources[static_cast<std::size_t>(v.source)];
  const bool of_place = source.ends_with("position") || source == Barometer::kName,
             of_speed = source.ends_with("velocity") || source == Odometer::kName;
  const double spread = of_place ? kFar : of_speed ? kFast : kTurned;
  return 2 * v.dof * std::log(spread) - 2 * std::log(kPart);
}

// Without the errors of the IMU that innovations hardly show: with 5000 ppm between the axes the mean NIS stays within
// 0.003 of 1 (docs/consistency.md, ski_cross_axis). They are up to 18 of the states. Without them and the correction of
// the scales a run of the recorded drive takes 28 ms instead of 50, and has 23 288 of ln L instead of 23 333.
FilterOptions without_unseen(FilterOptions options) {
  options.sensor.gyro.cross_axis = options.sensor.accel.cross_axis = options.sensor.gyro_g_sensitivity = 0;
  std::erase_if(options.estimate, [](Block b) {
    return b == Block::kGyroCrossAxis || b == Block::kAccelCrossAxis || b == Block::kGyroGSensitivity;
  });
  return options;
}

// −2 ln p of an innovation.
double cost(const Innovation& v, const std::vector<std::string>& sources) {
  return std::min(v.nis + v.log_determinant, cost_of_outlier(v, sources));
}

}  // namespace

bool is_outlier(const Innovation& v, const std::vector<std::string>& sources) {
  return v.nis + v.log_determinant > cost_of_outlier(v, sources);
}

double log_likelihood(const std::vector<Innovation>& innovations, const std::vector<std::string>& sources) {
  double sum = 0;
  for (const Innovation& v : innovations) sum += cost(v, sources);
  return -0.5 * sum;
}

double lasting_gain(const Evidence& granted, const Evidence& base) {
  constexpr double kStretch = 10;         // s
  constexpr std::ptrdiff_t kOneOf = 10;   // stretches
  std::unordered_map<long, double> gain;  // in each of them
  const auto add = [&gain](const Evidence& run, double sign) {
    for (const Innovation& v : run.innovations) {
      gain[static_cast<long>(v.time / kStretch)] -= sign * 0.5 * cost(v, run.sources);
    }
  };
  add(granted, 1);
  add(base, -1);
  std::vector<double> gains;
  gains.reserve(gain.size());
  for (const auto& [stretch, of_stretch] : gain) gains.push_back(std::max(0.0, of_stretch));
  std::sort(gains.begin(), gains.end(), std::greater<>());
  const std::ptrdiff_t most = (std::ssize(gains) + kOneOf - 1) / kOneOf;
  return granted.likelihood - base.likelihood - std::accumulate(gains.begin(), gains.begin() + most, 0.0);
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
    KalmanFilter filter(without_unseen(options), log.world, start);
    filter.leave_scales_uncorrected();
    Feeder feeder(log, place_at(log, start.time, {.end = end}), filter);
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
