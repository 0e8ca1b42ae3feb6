#include "diagnosis/setting_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "piste/core/sensor_class.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

// The mean over the axes of the sigma that half of the fixes do not reach.
double stated_sigma(const std::vector<GnssFix>& fixes) {
  std::vector<double> sigmas;
  sigmas.reserve(fixes.size());
  for (const GnssFix& fix : fixes) sigmas.push_back(std::sqrt(fix.sigma_position.squaredNorm() / 3));
  return median(std::move(sigmas));
}

}  // namespace

std::vector<std::string> setting_lines(const Log& log, const FilterOptions& options,
                                       const std::vector<Interval>& outages) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < log.gnss.size(); ++i) {
    const std::optional<PositionDrift>& drift = options.gnss[i].drift;
    if (!drift || drift->of_stated || log.gnss[i].empty()) continue;
    const double whole = stated_sigma(log.gnss[i]), coloured = std::sqrt(drift->sigma.squaredNorm() / 3);
    if (coloured <= whole) continue;
    lines.push_back(
        fmt::format("gnss[{}]: its `drift` of {:.2g} m is a part of the error that its sigmas state, and these are "
                    "{:.2g} m in the median; a larger `sigma` or `sigma_scale`, or a smaller drift, would agree",
                    i, coloured, whole));
  }
  if (const ImuSensor& imu = options.sensor;
      options.imus.size() < 2 && !(imu.gyro.cross_axis && imu.accel.cross_axis)) {
    const SensorClass& usual = class_of(imu);
    lines.push_back(fmt::format(
        "imu: its sensor file states no `cross_axis`, which claims axes that are square; usual for a {} IMU is "
        "`cross_axis: {:.0f} ppm` of `gyro` and `accel`, without which attitudes may be several sigmas off",
        usual.name, 1e6 * usual.cross_axis));
  }
  if (log.imu.empty()) return lines;
  const Interval imu{log.imu.front().time, log.imu.back().time};
  for (const Interval& outage : outages) {
    if (outage.end >= imu.start && outage.start <= imu.end) continue;
    lines.push_back(fmt::format("`outages`: [{}, {}] withholds nothing, as the log covers {:.3f} to {:.3f} s",
                                outage.start, outage.end - outage.start, imu.start, imu.end));
  }
  return lines;
}

}  // namespace piste
