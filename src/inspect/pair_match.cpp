// Compares two logs of one kind: are they the same recording, or two receivers on one body?

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "core/time_search.h"
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

bool far_apart(const PairMatch& m) {
  constexpr double kFarApart = 5;  // m, on one body
  return m.distance - 3 * m.scatter > kFarApart;
}

// No two antennas of one body differ by that height; the geoid is up to 107 m from the ellipsoid.
bool other_heights(const PairMatch& m) {
  constexpr double kMostAbove = 5, kMostHorizontal = 0.5;  // m; horizontal distance as a fraction of the vertical
  return far_apart(m) && std::abs(m.above) > kMostAbove && m.horizontal < kMostHorizontal * std::abs(m.above);
}

}  // namespace

PairMatch match(const ImuRecording& one, const ImuRecording& other) {
  PairMatch m{.distance = kNaN, .scatter = kNaN, .horizontal = kNaN, .above = kNaN};
  if (one.time.empty() || other.time.empty()) return m;
  m.overlap = overlap({one.time.front(), one.time.back()}, {other.time.front(), other.time.back()});
  m.same = same_rows(rows_of(one), rows_of(other));
  return m;
}

PairMatch match(const GnssRecording& one, const GnssRecording& other) {
  constexpr double kLongestStep = 2.5;  // s
  PairMatch m{.distance = kNaN, .scatter = kNaN, .horizontal = kNaN, .above = kNaN};
  if (one.fixes.empty() || other.fixes.empty()) return m;
  m.overlap =
      overlap({one.fixes.front().time, one.fixes.back().time}, {other.fixes.front().time, other.fixes.back().time});
  m.same = same_rows(rows_of(one), rows_of(other));
  const World world(one.fixes.front().position);
  std::vector<double> distances, horizontal, above;
  std::size_t j = 1;
  for (const GeodeticFix& f : one.fixes) {
    while (j + 1 < other.fixes.size() && other.fixes[j].time < f.time) ++j;
    if (j >= other.fixes.size()) break;
    const GeodeticFix &a = other.fixes[j - 1], &b = other.fixes[j];
    if (f.time < a.time || f.time > b.time || b.time - a.time > kLongestStep) continue;
    const Vector3d pa = world.from_geodetic(a.position), pb = world.from_geodetic(b.position);
    const double part = (f.time - a.time) / (b.time - a.time);
    const Vector3d apart = pa + part * (pb - pa) - world.from_geodetic(f.position);
    distances.push_back(apart.norm());
    horizontal.push_back(apart.head<2>().norm());
    above.push_back(a.position.height + part * (b.position.height - a.position.height) - f.position.height);
  }
  if (distances.empty()) return m;
  m.distance = median(distances);
  m.horizontal = median(std::move(horizontal));
  m.above = median(std::move(above));
  for (double& d : distances) d = std::abs(d - m.distance);
  m.scatter = kSigmaOverMedian * median(std::move(distances));
  return m;
}

std::string PairMatch::why_left_out(const std::string& first_file) const {
  if (same) return "the same recording as " + first_file;
  if (other_heights(*this)) return fmt::format("its heights are {:.1f} m from those of {}", above, first_file);
  return {};
}

std::vector<Suspicion> suspicions(const PairMatch& m, const std::string& one, const std::string& other) {
  if (m.same) {
    return {{LogFault::kSameLog, other, "holds the same recording as " + one,
             "leave one of them out: the same errors twice are not two measurements"}};
  }
  if (!(m.overlap > 0)) {
    return {{LogFault::kNoOverlap, other, "has no time in common with " + one, "are they of the same run?"}};
  }
  if (other_heights(m)) {
    return {{LogFault::kLeverArm, other,
             fmt::format("its heights are {:.1f} m {} those of {}, at the same place: one log's are above the "
                         "ellipsoid, it seems, and the other's above sea level",
                         std::abs(m.above), m.above > 0 ? "above" : "below", one),
             "replay wants heights above the ellipsoid: add the geoid's height to the others"}};
  }
  if (far_apart(m)) {
    return {{LogFault::kLeverArm, other,
             fmt::format("its antenna is {:.3g} ± {:.2g} m away from that of {}", m.distance, m.scatter, one),
             "are both receivers on the same body, and their clocks the same?"}};
  }
  return {};
}

}  // namespace piste
