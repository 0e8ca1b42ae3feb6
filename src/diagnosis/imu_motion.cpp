#include "diagnosis/imu_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "diagnosis/imu_outputs.h"
#include "diagnosis/imu_places.h"
#include "math/wahba.h"
#include "math/words.h"
#include "piste/math/so3.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr std::size_t kFewestWindows = 100;   // a tenth of a second each
constexpr double kBeyondDoubt = 5;            // standard errors
constexpr double kTurnedOff = 1.5 * kDegree;  // scales that differ by 3 % look like half of that at most
constexpr double kApart = 0.1, kNoise = 9;    // parts of the power of the motion, and of the noise, that may differ
constexpr std::ptrdiff_t kMostLate = 10;      // windows that rates are shifted by
// A clock that is off: by how much at least [s], and the part of the power of the motion that it explains.
constexpr double kLeastLate = 0.02, kExplained = 0.003;
constexpr double kMisplaced = 0.2;  // m: a lever arm that is off by less is measured as well as that

/// The rotation from the rates of the first IMU to those of another one, `shift` windows later.
struct Turned {
  WahbaSolution by;
  double left = 0, power = 0;  // mean square of an axis: of the residual of the rotation, and of the rates
  double rows = 0;
};

Turned turned(const ImuOutputs& rates, std::size_t imu, std::ptrdiff_t shift) {
  const Outputs &first = rates.of_imus.front(), &own = rates.of_imus[imu];
  const auto count = static_cast<std::ptrdiff_t>(rates.time.size());
  std::vector<std::array<Eigen::Index, 2>> pairs;
  for (std::ptrdiff_t w = kMostLate; w + kMostLate < count; ++w) {  // the same windows for all shifts
    const double apart = rates.time[static_cast<std::size_t>(w)] - rates.time[static_cast<std::size_t>(w - shift)];
    if (std::abs(apart - static_cast<double>(shift) * rates.duration) < 0.5 * rates.duration)
      pairs.push_back({w, w - shift});
  }
  Matrix3d B = Matrix3d::Zero();
  for (const auto& [late, w] : pairs) B += own.col(late) * first.col(w).transpose();
  Turned found{.by = solve_wahba(B), .rows = 3 * static_cast<double>(pairs.size())};
  for (const auto& [late, w] : pairs) {
    found.left += (own.col(late) - found.by.R * first.col(w)).squaredNorm() / found.rows;
    found.power += first.col(w).squaredNorm() / found.rows;
  }
  return found;
}

// The delay of the rates of an IMU relative to those of the first [s], if that is beyond doubt. It is the shift with
// the least residual, by a parabola through the neighbours.
std::optional<double> lateness(const ImuOutputs& rates, std::size_t imu) {
  std::array<double, 2 * kMostLate + 1> left{};
  for (std::ptrdiff_t shift = -kMostLate; shift <= kMostLate; ++shift)
    left[static_cast<std::size_t>(shift + kMostLate)] = turned(rates, imu, shift).left;
  const auto best = static_cast<std::size_t>(std::min_element(left.begin(), left.end()) - left.begin());
  if (best == 0 || best + 1 == left.size()) return std::nullopt;
  const Turned now = turned(rates, imu, 0);
  const double slope = (left[best + 1] - left[best - 1]) / 2, bend = left[best + 1] - 2 * left[best] + left[best - 1];
  if (!(bend > 0)) return std::nullopt;
  const double least = std::max(0.0, left[best] - slope * slope / (2 * bend)), explained = now.left - least;
  const double late = (static_cast<double>(best) - kMostLate - slope / bend) * rates.duration;
  const bool sure = explained * now.rows > square(kBeyondDoubt) * least && explained > kExplained * now.power;
  return sure && std::abs(late) > kLeastLate ? std::optional(late) : std::nullopt;
}

// The sentence about rates of an IMU that contradict those of the first. Nothing if they agree.
std::optional<std::string> contradiction(const ImuOutputs& rates, std::size_t imu, double noise,
                                         const std::string& name) {
  if (const auto late = lateness(rates, imu)) {
    return fmt::format(
        "turns some {} s {} than IMU {}; its `clock: {{offset}}` is too {} by about as much; `align` finds it",
        plain(std::abs(*late), 2), *late > 0 ? "later" : "earlier", name, *late > 0 ? "small" : "large");
  }
  const Turned found = turned(rates, imu, 0);
  if (found.left > kApart * found.power && found.left > kNoise * noise) {
    return fmt::format(
        "does not turn as IMU {} does: their rates differ by {} times the motion; check its `clock`, "
        "its units and its axes",
        name, plain(std::sqrt(found.left / found.power), 2));
  }
  // A rotation that the motion does not determine counts as zero, such as one about the only axis of a turn.
  Vector3d off = found.by.axes.transpose() * so3_log(Quaterniond(found.by.R));
  for (int k = 0; k < 3; ++k) {
    const double information = found.by.information()(k);
    if (!(information > 0) || std::abs(off(k)) < kBeyondDoubt * std::sqrt(found.left / information)) off(k) = 0;
  }
  if (off.norm() < kTurnedOff) return std::nullopt;
  return fmt::format(
      "turns about axes that are {} deg off those of IMU {}; check its `axes`, `boresight` and `clock`, or let "
      "`align` find them",
      plain(off.norm() / kDegree, 2), name);
}

// The sentence about specific forces of an IMU that are those of another place. Nothing if they are not.
std::optional<std::string> misplacement(const ImuOutputs& forces, std::size_t imu, const std::string& name) {
  const auto offset = imu_offset(forces, imu);
  if (!offset || offset->value.norm() < kMisplaced) return std::nullopt;
  if ((offset->value.array().abs() < kBeyondDoubt * offset->sigma.array()).all()) return std::nullopt;
  return fmt::format("sits some {} m from where its `lever_arm` puts it relative to IMU {}; measure it, or say `auto`",
                     plain(offset->value.norm(), 1), name);
}

}  // namespace

std::vector<std::string> imu_motion_lines(const Log& log, const std::vector<ImuSensor>& imus) {
  std::vector<std::string> lines;
  if (imus.size() < 2 || log.parity.size() + 1 != imus.size() || log.counts.imus.size() != imus.size()) return lines;
  const ImuOutputs rates = imu_outputs(log, imus, &ImuSensor::gyro);
  if (rates.time.size() < kFewestWindows) return lines;
  const ImuOutputs forces = imu_outputs(log, imus, &ImuSensor::accel);
  const std::string& name = log.counts.imus.front().name;
  for (std::size_t i = 1; i < imus.size(); ++i) {
    const double noise = (square(imus.front().gyro.noise) + square(imus[i].gyro.noise)) / rates.duration;
    auto what = contradiction(rates, i, noise, name);
    if (!what) what = misplacement(forces, i, name);
    if (what) lines.push_back(fmt::format("IMU {} {}", log.counts.imus[i].name, *what));
  }
  return lines;
}

}  // namespace piste
