// The words for faults of an IMU's log.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "adding_to.h"
#include "imu_bounds.h"
#include "piste/inspect/imu_health.h"
#include "piste/math/earth.h"
#include "piste/math/units.h"

namespace piste {
namespace {

std::string remedy_of(LogFault fault) {
  switch (fault) {
    case LogFault::kAccelG:
      return "these are g or thousandths of it: name the columns accel_x_g, or convert them";
    case LogFault::kAccelMetres:
      return "these are m/s^2: name the columns accel_x_m_s2";
    case LogFault::kIncrementsForRates:
      return "these are increments over the interval between rows: name the columns dtheta_x_rad and dvel_x_m_s";
    default:
      return "these are rates: name the columns gyro_x_rad_s and accel_x_m_s2";
  }
}

void suspect_forces(const ImuHealth& h, double slowest, const std::string& file, std::vector<Suspicion>& found) {
  const auto add = adding_to(found, file);
  if (h.force_unit && (h.sampling.rate() >= slowest || h.force_unit->fault <= LogFault::kAccelMetres)) {
    add(h.force_unit->fault,
        fmt::format("the specific force is {:.4g} m/s^2 where gravity makes it 9.8: too large {:.4g} times", h.force,
                    h.force_unit->factor),
        remedy_of(h.force_unit->fault));
  } else if (!h.has_gravity) {
    add(LogFault::kNoGravity,
        fmt::format("the accelerations are {:.3g} m/s^2 at rest and up to {:.3g} in motion: gravity is not in them",
                    h.force, std::max(-h.accel.smallest.minCoeff(), h.accel.largest.maxCoeff())),
        "give the accelerometers' own output, the specific force; `linear acceleration` has lost the tilt");
  } else if (std::abs(std::log(h.force / kStandardGravity)) > std::log(kGravityTolerance)) {
    add(LogFault::kAccelG, fmt::format("the specific force is {:.4g} m/s^2 where gravity makes it 9.8", h.force),
        "convert the accelerometers to m/s^2, or name their unit in the header");
  }
}

// The faults of one triad of `h`.
void suspect_triad(const TriadHealth& t, const ImuHealth& h, const std::string& file, std::vector<Suspicion>& found) {
  constexpr double kManyClipped = 0.001, kStandsStill = 0.75;  // shares
  const auto add = adding_to(found, file);
  const bool gyro = &t == &h.gyro;
  if (t.spikes > 0 && !(gyro && h.fast_rates)) {
    add(LogFault::kSpikes,
        fmt::format("{} {} beyond what a body can do, the first at t = {:.3f} s", t.spikes,
                    gyro ? "angular rates" : "specific forces", t.first_spike),
        "give the sensor's `range` in its file: samples beyond it are then known not to be measured");
  }
  if (t.isolated > 0 && t.spikes == 0) {
    add(LogFault::kSpikes,
        fmt::format("{} isolated {} that the motion around them does not explain, the first at t = {:.3f} s",
                    t.isolated, gyro ? "angular rates" : "specific forces", t.first_isolated),
        "replay replaces them by the line between the adjacent rows, and counts them as `spikes`");
  }
  // An axis with a single value is constant, not rounded.
  Eigen::Index axis = 0;
  const double share = (t.quantum.array() > 0).select(t.repeated, 0).maxCoeff(&axis);
  if (share > kStandsStill && h.frozen.empty()) {
    const double step = t.quantum(axis) / (h.increments ? h.sampling.interval : 1) / (gyro ? kDegree : 1);
    add(LogFault::kQuantised,
        fmt::format("the {} stand still, at steps of {:.3g} {}: {:.0f} % of the values of an axis are those of the row "
                    "before",
                    gyro ? "gyroscopes" : "accelerometers", step, gyro ? "deg/s" : "m/s^2", 100 * share),
        "log more decimals: up to half a step is missing, for as long as a value stands, and no sigma knows of it");
  }
  std::size_t clipped = 0;
  for (const std::size_t n : t.clipped) clipped += n;
  if (static_cast<double>(clipped) > kManyClipped * static_cast<double>(h.sampling.rows)) {
    add(LogFault::kClipped,
        fmt::format("{} samples of the {} stand at a limit they never pass, {:.4g} {}", clipped,
                    gyro ? "gyroscopes" : "accelerometers", t.limit.maxCoeff() / (gyro ? kDegree : 1),
                    gyro ? "deg/s" : "m/s^2"),
        "give that limit as `range` in the sensor file; what lies beyond it was not measured");
  }
}

}  // namespace

std::optional<Suspicion> low_rate(const Sampling& s, const std::string& file) {
  constexpr double kUsefulRate = 40;  // Hz
  if (s.rate() >= kUsefulRate) return std::nullopt;
  return Suspicion{LogFault::kLowRate, file, fmt::format("{:.3g} Hz; a body's motion asks for 50 Hz or more", s.rate()),
                   "log faster where the sensor can"};
}

std::vector<Suspicion> suspicions(const ImuHealth& h, const RowFaults& faults, const std::string& file) {
  constexpr double kFastestImu = 20000, kSlowestImu = 1.5;  // Hz: 2 Hz is slow
  std::vector<Suspicion> found = suspicions(h.sampling, faults, file, kFastestImu, kSlowestImu);
  if (h.sampling.rows < 3) return found;
  const auto add = adding_to(found, file);
  suspect_forces(h, kSlowestImu, file, found);
  if (h.fast_rates) {
    add(LogFault::kGyroDegrees,
        fmt::format("one rate in a hundred is beyond {} rad/s, up to {:.4g}", kFastRates,
                    h.gyro.smallest.cwiseAbs().cwiseMax(h.gyro.largest).maxCoeff()),
        "these are degrees: name the columns gyro_x_deg_s or dtheta_x_deg, or convert them");
  }
  suspect_triad(h.gyro, h, file, found);
  suspect_triad(h.accel, h, file, found);
  if (!h.frozen.empty()) {
    add(LogFault::kFrozenSensor,
        fmt::format("the very same row again and again, {} times; the first from t = {:.3f} to {:.3f} s",
                    h.frozen.size(), h.frozen.front().start, h.frozen.front().end),
        "did the logger lose the sensor? Leave these rows out: a gap is honest");
  }
  if (const auto low = low_rate(h.sampling, file); low && h.sampling.rate() >= kSlowestImu) found.push_back(*low);
  if (h.rest.empty()) {
    add(LogFault::kNoRest, "the body never rests for two seconds",
        "a minute of rest before and after a run shows the biases; give `initial: {heading}` if the start is not "
        "found");
  }
  return found;
}

}  // namespace piste
