#include "diagnosis/imu_outputs.h"

#include <Eigen/LU>
#include <optional>

#include "piste/math/statistics.h"

namespace piste {

ImuOutputs imu_outputs(const Log& log, const std::vector<ImuSensor>& imus, TriadMember triad) {
  const bool gyro = triad == &ImuSensor::gyro;
  const auto parity_of = [gyro](const ParityFix& fix) -> const std::optional<Parity>& {
    return gyro ? fix.gyro : fix.accel;
  };
  // The matrix that combines the IMUs into their mean and parities, and its inverse.
  const auto count = static_cast<Eigen::Index>(imus.size());
  const ImuVector noise = imu_noise(imus, triad);
  Eigen::MatrixXd made(count, count);
  made.row(0) = imu_weights(noise).transpose();
  made.bottomRows(count - 1) = parity_rows(noise).transpose();
  const Eigen::MatrixXd back = made.inverse();
  ImuOutputs found;
  const std::vector<ParityFix>& windows = log.parity.front();
  found.of_imus.assign(imus.size(), Outputs(3, static_cast<Eigen::Index>(windows.size())));
  std::vector<double> durations;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    Eigen::MatrixXd combined(count, 3);
    combined.row(0) = (gyro ? windows[w].rate : windows[w].force).transpose();
    bool whole = true;
    for (std::size_t p = 0; p < log.parity.size() && whole; ++p) {
      whole = w < log.parity[p].size() && parity_of(log.parity[p][w]).has_value();
      if (whole) combined.row(static_cast<Eigen::Index>(p) + 1) = parity_of(log.parity[p][w])->value.transpose();
    }
    if (!whole) continue;
    const Eigen::MatrixXd own = back * combined;
    const auto column = static_cast<Eigen::Index>(found.time.size());
    for (std::size_t i = 0; i < imus.size(); ++i)
      found.of_imus[i].col(column) = own.row(static_cast<Eigen::Index>(i)).transpose();
    found.time.push_back(windows[w].time);
    found.rate.push_back(windows[w].rate);
    durations.push_back(windows[w].duration);
  }
  const auto kept = static_cast<Eigen::Index>(found.time.size());
  for (Outputs& of_imu : found.of_imus) {
    of_imu.conservativeResize(3, kept);
    if (kept > 0) of_imu.colwise() -= of_imu.rowwise().mean().eval();
  }
  if (kept > 0) found.duration = mean(durations);
  return found;
}

}  // namespace piste
