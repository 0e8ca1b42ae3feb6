#include "condition/several_imus.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "condition/imu_differences.h"
#include "condition/imu_series.h"
#include "piste/condition/pipeline.h"
#include "piste/core/error.h"

namespace piste {
namespace {

// Window over which IMUs are compared [s]. It is long enough to average the noise of single samples and of the angular
// acceleration. It is short enough that a body hardly turns in it, and that a fault does little harm before its
// detection.
constexpr double kWindow = 0.1;
constexpr double kSameAbsence = 1;  // s: absences for one reason that are closer are merged

// Windows of kWindow over the epochs. They do not reach over a gap.
std::vector<ImuWindow> windows_over(const std::vector<ImuSample>& epochs) {
  std::vector<ImuWindow> out;
  ImuWindow window;
  for (std::size_t k = 0; k < epochs.size(); ++k) {
    window.duration += epochs[k].interval;
    window.end = k + 1;
    if (window.duration < kWindow - 0.5 * epochs[k].interval && k + 1 < epochs.size()) continue;
    out.push_back(window);
    window = {k + 1, k + 1, 0};
  }
  return out;
}

// [ω']× + [ω]×²: of a place on the body to its acceleration against the origin, at every epoch.
std::vector<Matrix3d> lever_effects(const std::vector<TriadMean>& rate, const std::vector<ImuSample>& epochs) {
  std::vector<Matrix3d> out(rate.size(), Matrix3d::Zero());
  for (std::size_t k = 0; k < rate.size(); ++k) {
    const std::size_t a = k > 0 ? k - 1 : k, b = k + 1 < rate.size() ? k + 1 : k;
    const auto middle = [&](std::size_t i) { return epochs[i].time - 0.5 * epochs[i].interval; };
    const Matrix3d turn = skew(rate[k].value);
    out[k] = turn * turn;
    if (b > a) out[k] += skew((rate[b].value - rate[a].value) / (middle(b) - middle(a)));
  }
  return out;
}

void move_to_first(ImuTriad& accel, const std::vector<Matrix3d>& effects, const Vector3d& place) {
  for (std::size_t k = 0; k < accel.value.size(); ++k) accel.value[k] -= effects[k] * place;
}

// The place of an IMU, by least squares over the windows in which both IMUs measure everything. The difference of its
// specific force from that of the first is the effect of the place, an offset, and a matrix of scales and mounting.
// Components that the motion does not determine stay near `place`, within kPrior.
Vector3d found_place(const ImuTriad& first, const ImuTriad& unit, const std::vector<Matrix3d>& effects,
                     const std::vector<double>& intervals, const std::vector<ImuWindow>& windows,
                     const FusedImuConditioning& options) {
  constexpr double kPrior = 0.5;        // m: one body
  constexpr double kMisaligned = 0.02;  // rad, and a ratio of scales
  constexpr int kUnknowns = 15;
  using Row = Eigen::Matrix<double, 3, kUnknowns>;
  const double bias = std::max(options.sensor.accel.bias, 0.1);
  Eigen::Matrix<double, kUnknowns, kUnknowns> N = Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  Eigen::Matrix<double, kUnknowns, 1> n = Eigen::Matrix<double, kUnknowns, 1>::Zero();
  N.diagonal() << Vector3d::Constant(1 / (kPrior * kPrior)), Vector3d::Constant(1 / (bias * bias)),
      Eigen::Matrix<double, 9, 1>::Constant(1 / (kMisaligned * kMisaligned));
  std::vector<std::pair<Row, Vector3d>> rows;
  std::vector<Vector3d> differences, forces;
  for (const ImuWindow& window : windows) {
    Matrix3d effect = Matrix3d::Zero();
    std::uint8_t bad = 0;
    for (std::size_t k = window.begin; k < window.end; ++k) {
      effect += intervals[k] / window.duration * effects[k];
      bad = bad | first.bad[k] | unit.bad[k];
    }
    if (bad != 0) continue;
    const Vector3d force = mean_over(first, window, intervals);
    const Vector3d difference = mean_over(unit, window, intervals) - force - effect * options.place;
    Row row;
    row << effect, Matrix3d::Identity(), force.x() * Matrix3d::Identity(), force.y() * Matrix3d::Identity(),
        force.z() * Matrix3d::Identity();
    rows.emplace_back(row, difference);
    differences.push_back(difference);
    forces.push_back(force);
  }
  const double density = options.sensor.accel.noise;
  const double noise = std::max(noise_of(differences, forces).squaredNorm() / 3, 2 * density * density / kWindow);
  for (const auto& [row, difference] : rows) {
    N += row.transpose() * row / noise;
    n += row.transpose() * difference / noise;
  }
  return options.place + Eigen::Matrix<double, kUnknowns, 1>(N.llt().solve(n)).head<3>();
}

// The parities of a triad, window by window; nothing where some IMU did not measure an axis.
std::vector<std::vector<std::optional<Parity>>> parities_of(const std::vector<const ImuTriad*>& imus,
                                                            const ImuVector& noise, const CombinedTriad& combined,
                                                            const std::vector<double>& intervals,
                                                            const std::vector<ImuWindow>& windows) {
  const ImuMatrix L = parity_rows(noise);
  std::vector<std::vector<std::optional<Parity>>> out(imus.size() - 1);
  for (std::size_t p = 0; p < out.size(); ++p) {
    std::vector<Vector3d> series, signal;
    for (std::size_t w = 0; w < windows.size(); ++w) {
      auto& parity = out[p].emplace_back();
      if (!combined.whole[w]) continue;
      parity.emplace();
      for (std::size_t i = 0; i < imus.size(); ++i) {
        parity->value +=
            L(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(p)) * mean_over(*imus[i], windows[w], intervals);
      }
      series.push_back(parity->value);
      signal.push_back(mean_over(*imus.front(), windows[w], intervals));
    }
    const Vector3d sigma = noise_of(series, signal);
    for (auto& parity : out[p]) {
      if (parity) parity->sigma = sigma;
    }
  }
  return out;
}

// Adds the absences of a triad of an IMU, epoch by epoch.
void report_absences(const CombinedTriad& combined, std::size_t unit, bool gyro, const std::vector<ImuSample>& epochs,
                     ImuReport& report) {
  std::array<std::optional<std::size_t>, 5> last;  // of each fault: the last absence
  for (std::size_t k = 0; k < epochs.size(); ++k) {
    if (combined.out[unit][k] == 0) continue;
    const ImuFault fault = combined.why[unit][k];
    std::optional<std::size_t>& open = last[static_cast<std::size_t>(fault)];
    const double begin = epochs[k].time - epochs[k].interval;
    if (open && begin - report.absences[*open].time.end < kSameAbsence) {
      report.absences[*open].time.end = epochs[k].time;
      continue;
    }
    open = report.absences.size();
    report.absences.push_back({fault, gyro, !gyro, {begin, epochs[k].time}});
  }
}

double largest_density(const TriadMean& mean) { return std::sqrt(mean.added.maxCoeff()); }

// The samples of the mean.
void take_means(const CombinedTriad& gyro, const CombinedTriad& accel, Log& log) {
  for (std::size_t k = 0; k < log.imu.size(); ++k) {
    ImuSample& s = log.imu[k];
    const TriadMean &rate = gyro.mean[k], &force = accel.mean[k];
    const auto silent = [&](const CombinedTriad& triad) {
      return std::ranges::all_of(triad.out, [&](const auto& out) { return out[k] == 7; }) &&
             std::ranges::any_of(triad.why, [&](const auto& why) { return why[k] != ImuFault::kClipped; });
    };
    if (s.gap && (silent(gyro) || silent(accel))) continue;  // stays as filled for the first IMU alone
    s.gap.reset();
    s.interpolated.reset();
    s.clipped_gyro = rate.missing;
    s.clipped_accel = force.missing;
    s.dtheta = s.interval * rate.value;
    s.dvel = s.interval * force.value;
    const GapNoise added{static_cast<float>(largest_density(rate)), static_cast<float>(largest_density(force))};
    if (added.gyro > 0 || added.accel > 0) s.interpolated = added;
  }
}

}  // namespace

Log condition_imus(const Recording& recording, const ConditioningOptions& options) {
  Log log = condition_imu(recording.imu, options);
  const std::vector<FusedImuConditioning>& known = options.imus;
  const std::size_t count = known.size();
  std::vector<ImuSeries> imus{at_epochs(log.imu, log.imu)};
  std::vector<ImuSensor> sensors{known.front().sensor};
  for (std::size_t i = 1; i < count; ++i) {
    ConditioningOptions own = options;
    own.imu = known[i].imu;
    own.gyro_range = known[i].sensor.gyro.range;
    own.accel_range = known[i].sensor.accel.range;
    imus.push_back(at_epochs(condition_imu(recording.further[i - 1], own).imu, log.imu));
    sensors.push_back(known[i].sensor);
  }
  const auto triads = [&](ImuTriad ImuSeries::*triad) {
    std::vector<const ImuTriad*> out;
    out.reserve(imus.size());
    for (const ImuSeries& unit : imus) out.push_back(&(unit.*triad));
    return out;
  };
  std::vector<double> intervals;
  intervals.reserve(log.imu.size());
  for (const ImuSample& s : log.imu) intervals.push_back(s.interval);
  const std::vector<ImuWindow> windows = windows_over(log.imu);

  const CombinedTriad gyro = combine(triads(&ImuSeries::gyro), sensors, &ImuSensor::gyro, intervals, windows);
  const std::vector<Matrix3d> effects = lever_effects(gyro.mean, log.imu);
  for (std::size_t i = 1; i < count; ++i) {
    const Vector3d place = known[i].find_place
                               ? found_place(imus.front().accel, imus[i].accel, effects, intervals, windows, known[i])
                               : known[i].place;
    move_to_first(imus[i].accel, effects, place);
    log.counts.imus.push_back({.name = known[i].name, .place = place});
  }
  const CombinedTriad accel = combine(triads(&ImuSeries::accel), sensors, &ImuSensor::accel, intervals, windows);

  log.counts.imus.insert(log.counts.imus.begin(), {.name = known.front().name});
  for (std::size_t i = 0; i < count; ++i) {
    ImuReport& report = log.counts.imus[i];
    for (std::size_t k = 0; k < log.imu.size(); ++k) report.left_out += gyro.out[i][k] != 0 || accel.out[i][k] != 0;
    report_absences(gyro, i, true, log.imu, report);
    report_absences(accel, i, false, log.imu, report);
    std::ranges::stable_sort(report.absences, {}, [](const ImuAbsence& a) { return a.time.start; });
  }
  const auto rate =
      parities_of(triads(&ImuSeries::gyro), imu_noise(sensors, &ImuSensor::gyro), gyro, intervals, windows);
  const auto force =
      parities_of(triads(&ImuSeries::accel), imu_noise(sensors, &ImuSensor::accel), accel, intervals, windows);
  log.parity.resize(count - 1);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const ImuWindow& window = windows[w];
    ParityFix fix{.time = log.imu[window.end - 1].time - intervals[window.end - 1], .duration = window.duration};
    for (std::size_t k = window.begin; k < window.end; ++k) {
      fix.rate += intervals[k] / window.duration * gyro.mean[k].value;
      fix.force += intervals[k] / window.duration * accel.mean[k].value;
    }
    for (std::size_t p = 0; p + 1 < count; ++p) {
      fix.gyro = rate[p][w];
      fix.accel = force[p][w];
      if (fix.gyro || fix.accel) log.parity[p].push_back(fix);
    }
  }
  take_means(gyro, accel, log);
  return log;
}

}  // namespace piste
