#include "diagnosis/unit_axes.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <optional>

#include "math/words.h"
#include "piste/core/imu_array.h"
#include "piste/math/so3.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/math/wahba.h"

namespace piste {
namespace {

constexpr std::size_t kFewestWindows = 100;   // a tenth of a second each
constexpr double kBeyondDoubt = 5;            // standard errors
constexpr double kTurnedOff = 1.5 * kDegree;  // scales that differ by 3 % look like half of that at most
constexpr double kApart = 0.1, kNoise = 9;    // parts of the power of the motion, and of the noise, that may differ

using Outputs = Eigen::Matrix<double, 3, Eigen::Dynamic>;  // a column for each window

// The rates that each unit measured, in the windows that all of them tell: mean and parities are what they were made
// into.
std::vector<Outputs> rates_of(const Log& log, const std::vector<ImuSensor>& units) {
  const auto count = static_cast<Eigen::Index>(units.size());
  const UnitVector noise = unit_noise(units, &ImuSensor::gyro);
  Eigen::MatrixXd made(count, count);
  made.row(0) = unit_weights(noise).transpose();
  made.bottomRows(count - 1) = parity_rows(noise).transpose();
  const Eigen::MatrixXd back = made.inverse();
  std::vector<Outputs> rates(units.size(), Outputs(3, static_cast<Eigen::Index>(log.parity.front().size())));
  Eigen::Index windows = 0;
  for (std::size_t w = 0; w < log.parity.front().size(); ++w) {
    Eigen::MatrixXd told(count, 3);
    told.row(0) = log.parity.front()[w].rate.transpose();
    bool whole = true;
    for (std::size_t p = 0; p < log.parity.size() && whole; ++p) {
      whole = w < log.parity[p].size() && log.parity[p][w].gyro.has_value();
      if (whole) told.row(static_cast<Eigen::Index>(p) + 1) = log.parity[p][w].gyro->value.transpose();
    }
    if (!whole) continue;
    const Eigen::MatrixXd own = back * told;
    for (std::size_t i = 0; i < units.size(); ++i)
      rates[i].col(windows) = own.row(static_cast<Eigen::Index>(i)).transpose();
    ++windows;
  }
  for (Outputs& of_unit : rates) {
    of_unit.conservativeResize(3, windows);
    if (windows > 0) of_unit.colwise() -= of_unit.rowwise().mean().eval();  // offsets say nothing of axes
  }
  return rates;
}

// What is wrong with the rates of a unit against those of the first, if anything is.
std::optional<std::string> contradiction(const Outputs& first, const Outputs& unit, double noise,
                                         const std::string& name) {
  const auto rows = 3 * static_cast<double>(first.cols());
  const WahbaSolution turned = solve_wahba(unit * first.transpose());
  const double left = (unit - turned.R * first).squaredNorm() / rows, power = first.squaredNorm() / rows;
  if (left > kApart * power && left > kNoise * noise) {
    return fmt::format(
        "does not turn as IMU {} does: their rates differ by {} times the motion; check its `clock`, "
        "its units and its axes",
        name, plain(std::sqrt(left / power), 2));
  }
  // A rotation that the motion does not tell, as about the only axis of a turn, counts for none.
  Vector3d off = turned.axes.transpose() * so3_log(Quaterniond(turned.R));
  for (int k = 0; k < 3; ++k) {
    const double information = turned.information()(k);
    if (!(information > 0) || std::abs(off(k)) < kBeyondDoubt * std::sqrt(left / information)) off(k) = 0;
  }
  if (off.norm() < kTurnedOff) return std::nullopt;
  return fmt::format(
      "turns about axes that are {} deg off those of IMU {}; check its `axes`, `boresight` and `clock`, or let "
      "`align` find them",
      plain(off.norm() / kDegree, 2), name);
}

}  // namespace

std::vector<std::string> unit_axes_lines(const Log& log, const std::vector<ImuSensor>& units) {
  std::vector<std::string> lines;
  if (units.size() < 2 || log.parity.size() + 1 != units.size() || log.counts.units.size() != units.size())
    return lines;
  const std::vector<Outputs> rates = rates_of(log, units);
  if (rates.front().cols() < static_cast<Eigen::Index>(kFewestWindows)) return lines;
  double duration = 0;
  for (const ParityFix& fix : log.parity.front()) duration += fix.duration;
  duration /= static_cast<double>(log.parity.front().size());
  for (std::size_t i = 1; i < units.size(); ++i) {
    const double noise = (square(units.front().gyro.noise) + square(units[i].gyro.noise)) / duration;
    const auto what = contradiction(rates.front(), rates[i], noise, log.counts.units.front().name);
    if (what) lines.push_back(fmt::format("IMU {} {}", log.counts.units[i].name, *what));
  }
  return lines;
}

}  // namespace piste
