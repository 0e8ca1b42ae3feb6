#pragma once
/// The Earth seen from the run: the world frame `w`, its rotation and its gravity.
///
/// `w` has north-east-down axes at the origin of the run and is fixed to the Earth. In it the Earth's rotation is
/// constant and gravity is a smooth function of position, so that mechanization needs no transport rate. The ellipsoid
/// is WGS84. Positions, gravity and the ellipsoid's numbers come from GeographicLib; the way back to latitude and
/// longitude, which every epoch needs, is written out here and agrees with GeographicLib to rounding.

#include <GeographicLib/LocalCartesian.hpp>
#include <utility>

#include "piste/math/so3.h"

namespace piste {

inline constexpr double kEarthRate = 7.292115e-5;    ///< WGS84
inline constexpr double kStandardGravity = 9.80665;  ///< the `g` of data sheets

/// Latitude and longitude [rad], ellipsoidal height.
struct Geodetic {
  double latitude = 0, longitude = 0, height = 0;
};

/// Gravity near a point: g(p) ≈ value + gradient (p − point). All in w. And the local level at the point, which holds
/// to 2e-5 rad for a body 100 m away.
struct Gravity {
  Vector3d point, value;
  Matrix3d gradient;
  Matrix3d R_wn = Matrix3d::Identity();  ///< World::rotation_wn
  double height = 0;                     ///< of the point over the ellipsoid
  Vector3d at(const Vector3d& p_wb) const { return value + gradient * (p_wb - point); }
};

/// The frame `w` at one origin.
class World {
 public:
  World() : World(Geodetic{}) {}
  /// Origin with |latitude| ≤ π/2. Throws GeographicLib::GeographicErr otherwise.
  explicit World(const Geodetic& origin);

  const Geodetic& origin() const { return origin_; }
  /// Earth rotation vector, in w.
  const Vector3d& earth_rate() const { return earth_rate_; }
  /// Position in w of a geodetic position, and the inverse.
  Vector3d from_geodetic(const Geodetic& place) const;
  Geodetic to_geodetic(const Vector3d& p_w) const;
  /// R_wn: turns components along the local level n, the north-east-down axes at p_w, into components in w. Every input
  /// or output as north, east, down, roll, pitch or heading goes through this rotation alone. No heap.
  Matrix3d rotation_wn(const Vector3d& p_w) const;
  /// Both for one position: they share the costly part.
  std::pair<Geodetic, Matrix3d> local_level(const Vector3d& p_w) const;
  /// Normal gravity (gravitation and centrifugal acceleration) at p_w, in w, with its gradient and the local level.
  Gravity gravity(const Vector3d& p_w) const;
  /// Replaces `gravity` by that at p_w if its point is more than 100 m away: within, it is linear to 4e-9 m/s². No
  /// heap.
  void follow(Gravity& gravity, const Vector3d& p_w) const;

 private:
  Vector3d gravity_value(const Vector3d& p_w) const;
  Geodetic origin_;
  GeographicLib::LocalCartesian local_;
  Matrix3d R_we_;  // from ECEF
  Vector3d p_e_;   // the origin there
  Vector3d earth_rate_;
};

}  // namespace piste
