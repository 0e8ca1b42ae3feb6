// Compares two logs of one kind: are they the same log, or two receivers on one body?

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "piste/core/time_search.h"
#include "piste/inspect/log_match.h"
#include "piste/math/earth.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

// Whether most rows of one log are in the other. The times may differ, and either log may be cut.
template <std::size_t N>
bool same_rows(const std::vector<std::array<double, N>>& one, const std::vector<std::array<double, N>>& other) {
  constexpr std::size_t kFewest = 20;
  const std::set<std::array<double, N>> rows(one.begin(), one.end());
  const std::set<std::array<double, N>> others(other.begin(), other.end());
  const auto common = static_cast<std::size_t>(
      std::count_if(others.begin(), others.end(), [&](const auto& row) { return rows.contains(row); }));
  const std::size_t fewer = std::min(rows.size(), others.size());
  return fewer >= kFewest && 2 * common > fewer;
}

std::vector<std::array<double, 6>> rows_of(const ImuRecording& imu) {
  std::vector<std::array<double, 6>> rows;
  rows.reserve(imu.time.size());
  for (std::size_t i = 0; i < imu.time.size(); ++i) {
    const Vector3d &w = imu.gyro[i], &f = imu.accel[i];
    rows.push_back({w.x(), w.y(), w.z(), f.x(), f.y(), f.z()});
  }
  return rows;
}

std::vector<std::array<double, 3>> rows_of(const GnssRecording& gnss) {
  std::vector<std::array<double, 3>> rows;
  rows.reserve(gnss.fixes.size());
  for (const GeodeticFix& f : gnss.fixes)
    rows.push_back({f.position.latitude, f.position.longitude, f.position.height});
  return rows;
}

}  // namespace

PairMatch match(const ImuRecording& one, const ImuRecording& other) {
  PairMatch m{.distance = kNaN, .scatter = kNaN};
  if (one.time.empty() || other.time.empty()) return m;
  m.overlap = overlap({one.time.front(), one.time.back()}, {other.time.front(), other.time.back()});
  m.same = same_rows(rows_of(one), rows_of(other));
  return m;
}

PairMatch match(const GnssRecording& one, const GnssRecording& other) {
  constexpr double kLongestStep = 2.5;  // s
  PairMatch m{.distance = kNaN, .scatter = kNaN};
  if (one.fixes.empty() || other.fixes.empty()) return m;
  m.overlap =
      overlap({one.fixes.front().time, one.fixes.back().time}, {other.fixes.front().time, other.fixes.back().time});
  m.same = same_rows(rows_of(one), rows_of(other));
  const World world(one.fixes.front().position);
  std::vector<double> distances;
  std::size_t j = 1;
  for (const GeodeticFix& f : one.fixes) {
    while (j + 1 < other.fixes.size() && other.fixes[j].time < f.time) ++j;
    if (j >= other.fixes.size()) break;
    const GeodeticFix &a = other.fixes[j - 1], &b = other.fixes[j];
    if (f.time < a.time || f.time > b.time || b.time - a.time > kLongestStep) continue;
    const Vector3d pa = world.from_geodetic(a.position), pb = world.from_geodetic(b.position);
    const double part = (f.time - a.time) / (b.time - a.time);
    distances.push_back((world.from_geodetic(f.position) - pa - part * (pb - pa)).norm());
  }
  if (distances.empty()) return m;
  m.distance = median(distances);
  for (double& d : distances) d = std::abs(d - m.distance);
  m.scatter = kSigmaOverMedian * median(std::move(distances));
  return m;
}

std::vector<Suspicion> suspicions(const PairMatch& m, const std::string& one, const std::string& other) {
  constexpr double kFarApart = 5;  // m, on one body
  if (m.same) {
    return {{LogFault::kSameLog, other, "holds the same recording as " + one,
             "leave one of them out: the same errors twice are not two measurements"}};
  }
  if (!(m.overlap > 0)) {
    return {{LogFault::kNoOverlap, other, "has no time in common with " + one, "are they of the same run?"}};
  }
  if (m.distance - 3 * m.scatter > kFarApart) {
    return {{LogFault::kLeverArm, other,
             fmt::format("its antenna is {:.3g} ± {:.2g} m away from that of {}", m.distance, m.scatter, one),
             "are both receivers on the same body, and their clocks the same?"}};
  }
  return {};
}

}  // namespace piste
