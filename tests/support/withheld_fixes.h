#pragma once
/// Compares a solution with fixes that were withheld from its run, if there is no other truth.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include "piste/math/units.h"
#include "support/datasets.h"
#include "support/navigation.h"

namespace piste::test {

/// The windows of 15 s in which the recordist of the drive withholds GNSS. The first one is excluded, because it holds
/// the start, before anything is known. None without the recording.
inline std::vector<Interval> coast_windows() {
  std::vector<Interval> windows;
  std::ifstream file(datasets() / "drive" / "coast_windows.txt");
  for (std::string word; file >> word;) {
    const auto comma = word.find(',');
    const double start = std::stod(word.substr(0, comma));
    windows.push_back({start, start + std::stod(word.substr(comma + 1))});
  }
  if (!windows.empty()) windows.erase(windows.begin());
  return windows;
}

/// Antenna position of the solution minus a fix: north, east, down [m]. `lever_arm`: p_ba_b.
inline Vector3d antenna_error(const Table& solution, const GeodeticFix& fix, const Vector3d& lever_arm) {
  const auto value = [&](std::string_view column) { return at(solution, column, fix.time); };
  const World world(fix.position);
  const Vector3d imu =
      world.from_geodetic({kDegree * value("latitude_deg"), kDegree * value("longitude_deg"), value("height_m")});
  const Vector3d angles = kDegree * Vector3d(value("roll_deg"), value("pitch_deg"), value("heading_deg"));
  return imu + from_euler(angles) * lever_arm;
}

inline double horizontal_error(const Table& solution, const GeodeticFix& fix, const Vector3d& lever_arm) {
  return antenna_error(solution, fix, lever_arm).head<2>().norm();
}

/// How many errors, north, east and along the track, are inside 3 sigma of solution and fix.
class SigmaCount {
 public:
  void add(const Table& solution, const GeodeticFix& fix, const Vector3d& lever_arm) {
    const auto value = [&](std::string_view column) { return at(solution, column, fix.time); };
    const Vector3d error = antenna_error(solution, fix, lever_arm);
    const double north = std::hypot(value("sigma_north_m"), fix.sigma_position.x()),
                 east = std::hypot(value("sigma_east_m"), fix.sigma_position.y());
    within_ += (std::abs(error.x()) < 3 * north) + (std::abs(error.y()) < 3 * east);
    const Vector3d v(value("velocity_north_m_s"), value("velocity_east_m_s"), 0);
    const Vector3d track = v.norm() > 0 ? Vector3d(v.normalized()) : Vector3d::UnitX();
    // Without the covariance of both axes: exact along an axis.
    along_within_ += std::abs(track.dot(error)) < 3 * std::hypot(track.x() * north, track.y() * east);
    ++fixes_;
  }
  double within() const { return within_ / (2.0 * fixes_); }
  double along_within() const { return along_within_ / static_cast<double>(fixes_); }

 private:
  int within_ = 0, along_within_ = 0, fixes_ = 0;
};

/// Horizontal errors of the antenna in windows without fixes [m], one list a window, and the share inside 3 sigma.
struct WindowErrors {
  std::vector<double> end, worst;
  SigmaCount count;

  double mean_end() const { return std::accumulate(end.begin(), end.end(), 0.0) / static_cast<double>(end.size()); }
  double worst_inside() const { return *std::max_element(worst.begin(), worst.end()); }
};

inline WindowErrors window_errors(const Table& solution, const std::vector<GeodeticFix>& fixes,
                                  const std::vector<Interval>& windows, const Vector3d& lever_arm) {
  WindowErrors errors;
  for (const Interval& w : windows) {
    double end = 0, worst = 0;
    for (const GeodeticFix& fix : fixes) {
      if (!w.contains(fix.time)) continue;
      end = horizontal_error(solution, fix, lever_arm);
      worst = std::max(worst, end);
      errors.count.add(solution, fix, lever_arm);
    }
    errors.end.push_back(end);
    errors.worst.push_back(worst);
  }
  return errors;
}

}  // namespace piste::test
