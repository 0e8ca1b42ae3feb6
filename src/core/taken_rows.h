#pragma once
/// Takes rows out of the columns of a recording.

#include <cstddef>
#include <utility>
#include <vector>

#include "piste/core/log.h"

namespace piste {

/// Keeps these rows, in this order.
template <class T>
void take_rows(std::vector<T>& values, const std::vector<std::size_t>& rows) {
  if (values.empty()) return;
  std::vector<T> taken;
  taken.reserve(rows.size());
  for (const std::size_t i : rows) taken.push_back(values[i]);
  values = std::move(taken);
}

inline void take_rows(ImuRecording& imu, const std::vector<std::size_t>& rows) {
  take_rows(imu.time, rows);
  take_rows(imu.gyro, rows);
  take_rows(imu.accel, rows);
  take_rows(imu.magnetic, rows);
  take_rows(imu.temperature, rows);
}

}  // namespace piste
