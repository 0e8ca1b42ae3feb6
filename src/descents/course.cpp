#include "descents/course.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kStep = 0.25;  // m: standstill makes no line
constexpr double kReach = 1;    // m
constexpr double kTrack = 15;   // m: half the width in which laps of one course lie
constexpr double kAlong = 0.7;  // cos 45°: a path that crosses more askew is another branch, as of an eight

Vector3d horizontal(const Vector3d& v) { return {v.x(), v.y(), 0}; }
Vector3d right_of(const Vector3d& direction) { return {direction.y(), -direction.x(), 0}; }

// Hermite's cubic between two rows.
Vector3d between(const CoursePath& path, std::size_t i, double u) {
  const double dt = path.time[i + 1] - path.time[i], v = 1 - u;
  const Vector3d way = path.position[i + 1] - path.position[i];
  return path.position[i] + u * way +
         u * v * (v * (dt * path.velocity[i] - way) - u * (dt * path.velocity[i + 1] - way));
}

// Mean acceleration over some hundredths of a second: of single samples the noise would decide.
Vector3d acceleration(const CoursePath& path, std::size_t i) {
  constexpr double kHalf = 0.05;  // s
  std::size_t from = i, to = i;
  while (from > 0 && path.time[i] - path.time[from] < kHalf) --from;
  while (to + 1 < path.time.size() && path.time[to] - path.time[i] < kHalf) ++to;
  if (from == to) return Vector3d::Zero();
  return (path.velocity[to] - path.velocity[from]) / (path.time[to] - path.time[from]);
}

PlaneCrossing crossing_within(const CoursePath& path, const CoursePlane& plane, std::size_t i) {
  double low = 0, high = 1;
  constexpr int kHalvings = 50;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (plane.direction.dot(between(path, i, middle) - plane.place) < 0 ? low : high) = middle;
  }
  const double u = 0.5 * (low + high);
  PlaneCrossing found;
  found.row = u < 0.5 ? i : i + 1;
  found.time = path.time[i] + u * (path.time[i + 1] - path.time[i]);
  found.position = between(path, i, u);
  found.velocity = (1 - u) * path.velocity[i] + u * path.velocity[i + 1];
  found.offset = right_of(plane.direction).dot(found.position - plane.place);
  found.acceleration = acceleration(path, found.row);
  return found;
}

}  // namespace

CoursePath path_of(const Descent& run, const EnuFrame& frame) {
  const FramedPath framed(run.track, frame);
  CoursePath path;
  for (std::size_t i = 0; i < framed.size(); ++i) {
    const FramedRow row = framed.row(i);
    path.time.push_back(row.time);
    path.position.push_back(row.position);
    path.velocity.push_back(row.velocity);
  }
  return path;
}

CourseLine::CourseLine(const std::vector<Vector3d>& points) {
  for (const Vector3d& p : points) {
    const double way = points_.empty() ? 0 : (p - points_.back()).norm();
    if (!points_.empty() && way < kStep) continue;
    distance_.push_back(points_.empty() ? 0 : distance_.back() + way);
    points_.push_back(p);
  }
}

double CourseLine::nearest(const Vector3d& place) const {
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
    const Vector3d way = horizontal(points_[i + 1] - points_[i]), to = horizontal(place - points_[i]);
    const double square = way.squaredNorm(), u = square > 0 ? std::clamp(to.dot(way) / square, 0.0, 1.0) : 0;
    const double apart = (to - u * way).squaredNorm();
    if (apart >= least) continue;
    least = apart;
    best = distance_[i] + u * (distance_[i + 1] - distance_[i]);
  }
  return best;
}

Vector3d CourseLine::at(double distance) const {
  const auto after =
      static_cast<std::size_t>(std::lower_bound(distance_.begin(), distance_.end(), distance) - distance_.begin());
  const std::size_t i = std::clamp<std::size_t>(after, 1, points_.size() - 1) - 1;
  const double u = (distance - distance_[i]) / (distance_[i + 1] - distance_[i]);
  return points_[i] + u * (points_[i + 1] - points_[i]);
}

Vector3d CourseLine::direction(double distance) const {
  const double middle =
      std::clamp(distance, std::min(kReach, 0.5 * length()), std::max(length() - kReach, 0.5 * length()));
  return horizontal(at(middle + kReach) - at(middle - kReach)).normalized();
}

namespace {

// Whether the path passes the plane's place between the rows i and i + 1, if it crosses the plane there.
bool passes_at(const CoursePath& path, const CoursePlane& plane, std::size_t i) {
  const Vector3d step = horizontal(path.position[i + 1] - path.position[i]);
  return plane.direction.dot(step) > kAlong * step.norm() && horizontal(path.position[i] - plane.place).norm() < kTrack;
}

}  // namespace

std::optional<PlaneCrossing> crossing(const CoursePath& path, const CoursePlane& plane) {
  std::optional<PlaneCrossing> best;
  bool best_passes = false;
  double before = plane.direction.dot(path.position.front() - plane.place);
  for (std::size_t i = 0; i + 1 < path.position.size(); ++i) {
    const double after = plane.direction.dot(path.position[i + 1] - plane.place);
    const bool crosses =
        before < 0 && after >= 0 && path.time[i + 1] - path.time[i] <= kLongestInterpolation + kSameTime;
    before = after;
    if (!crosses) continue;
    const bool along = passes_at(path, plane, i);
    if (best_passes && (!along || plane.pass == CoursePlane::Pass::kFirst)) continue;
    const double about = std::abs(right_of(plane.direction).dot(path.position[i] - plane.place));
    constexpr double kNear = 5;  // m: within it the exact place decides
    const bool better = along && (!best_passes || plane.pass == CoursePlane::Pass::kLast);
    if (best && !better && about > std::abs(best->offset) + kNear) continue;
    const PlaneCrossing found = crossing_within(path, plane, i);
    if (best && !better && std::abs(found.offset) >= std::abs(best->offset)) continue;
    best = found;
    best_passes = along;
  }
  return best;
}

std::vector<std::size_t> passes(const CoursePath& path, const CoursePlane& plane) {
  std::vector<std::size_t> rows;
  double before = plane.direction.dot(path.position.front() - plane.place);
  for (std::size_t i = 0; i + 1 < path.position.size(); ++i) {
    const double after = plane.direction.dot(path.position[i + 1] - plane.place);
    if (before < 0 && after >= 0 && passes_at(path, plane, i)) rows.push_back(i);
    before = after;
  }
  return rows;
}

CoursePlane most_passed(const CoursePath& path) {
  const CourseLine line(path.position);
  constexpr double kApart = 5;  // m, between places that are tried
  CoursePlane best{line.at(0), line.direction(0)};
  std::size_t most = 0;
  for (double s = kReach; s < line.length(); s += kApart) {
    const CoursePlane plane{line.at(s), line.direction(s)};
    const std::size_t count = passes(path, plane).size();
    if (count <= most) continue;
    most = count;
    best = plane;
  }
  return best;
}

std::vector<double> apexes(const CourseLine& line) {
  constexpr double kLeast = 15 * kDegree, kBase = 3;  // m on each side
  std::vector<double> out;
  double turned = 0, most = 0, where = 0;
  const auto end_turn = [&] {
    if (std::abs(turned) > kLeast) out.push_back(where);
    turned = most = 0;
  };
  for (double s = kBase; s + kBase < line.length(); s += 1) {
    const Vector3d a = line.direction(s - kBase), b = line.direction(s + kBase);
    const double rate = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)) / (2 * kBase);  // rad/m, to the left
    if (rate * turned < 0) end_turn();
    turned += rate;
    if (std::abs(rate) <= most) continue;
    most = std::abs(rate);
    where = s;
  }
  end_turn();
  return out;
}

}  // namespace piste
