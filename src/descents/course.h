#pragma once
/// Paths of runs in one frame, the line of a course, and crossings of vertical planes.

#include <optional>
#include <string>
#include <vector>

#include "evaluate/path.h"
#include "piste/descents/descents.h"

namespace piste {

/// A path in east, north, up.
struct CoursePath {
  std::vector<double> time;
  std::vector<Vector3d> position, velocity;
};
CoursePath path_of(const Descent& run, const EnuFrame& frame);

/// A line by its arc length.
class CourseLine {
 public:
  /// The points in their order; those nearer than `kStep` to the one before are left out. @pre at least two are left
  explicit CourseLine(const std::vector<Vector3d>& points);
  double length() const { return distance_.back(); }
  /// Where the line is nearest to a place in plan [m].
  double nearest(const Vector3d& place) const;
  Vector3d at(double distance) const;
  /// A horizontal unit vector: the mean direction over `kReach` on each side.
  Vector3d direction(double distance) const;

 private:
  std::vector<Vector3d> points_;
  std::vector<double> distance_;
};

/// A vertical plane through a place, passed along `direction`, a horizontal unit vector.
struct CoursePlane {
  Vector3d place, direction;
  /// Which crossing counts, if there are several: the nearest one to the place, or of those within 15 m of the place
  /// and 45° of the direction the first or the last, as of the line where a lap begins and ends.
  enum class Pass { kNearest, kFirst, kLast } pass = Pass::kNearest;
};

/// A forward crossing.
struct PlaneCrossing {
  std::size_t row = 0;  ///< nearer end of the interval
  double time = 0, offset = 0;
  Vector3d position, velocity, acceleration;
};
/// Of all forward crossings the one that counts; nothing if there is none. Those within 15 m of the place and 45° of
/// the direction come first, so that of an eight the right branch is taken.
std::optional<PlaneCrossing> crossing(const CoursePath& path, const CoursePlane& plane);

/// The rows before each crossing of the plane, within 15 m of its place and 45° of its direction, in ascending order.
std::vector<std::size_t> passes(const CoursePath& path, const CoursePlane& plane);
/// The plane across the path that it passes most often so, and of several the earliest.
CoursePlane most_passed(const CoursePath& path);

/// Distances along the line of the apexes of its turns: where the direction changes fastest between two changes of its
/// sense, in turns of more than 15°.
std::vector<double> apexes(const CourseLine& line);

}  // namespace piste
