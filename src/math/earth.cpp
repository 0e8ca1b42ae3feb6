#include "piste/math/earth.h"

#include <GeographicLib/NormalGravity.hpp>
#include <cmath>
#include <vector>

#include "piste/math/units.h"

namespace piste {
namespace {

// GeographicLib's local axes are east, north, up.
Vector3d swap_enu_ned(const Vector3d& a) { return {a.y(), a.x(), -a.z()}; }

// R_en. Columns: north, east, down in ECEF.
Matrix3d level_axes(const Geodetic& place) {
  const double sp = std::sin(place.latitude), cp = std::cos(place.latitude), sl = std::sin(place.longitude),
               cl = std::cos(place.longitude);
  Matrix3d R_en;
  R_en << -sp * cl, -sl, -cp * cl, -sp * sl, cl, -cp * sl, cp, 0, -sp;
  return R_en;
}

}  // namespace

World::World(const Geodetic& origin)
    : origin_(origin),
      local_(origin.latitude / kDegree, origin.longitude / kDegree, origin.height),
      R_we_(level_axes(origin).transpose()),
      earth_rate_(kEarthRate * std::cos(origin.latitude), 0, -kEarthRate * std::sin(origin.latitude)) {}

Vector3d World::from_geodetic(const Geodetic& place) const {
  Vector3d enu;
  local_.Forward(place.latitude / kDegree, place.longitude / kDegree, place.height, enu.x(), enu.y(), enu.z());
  return swap_enu_ned(enu);
}

Geodetic World::to_geodetic(const Vector3d& p_w) const {
  const Vector3d enu = swap_enu_ned(p_w);
  Geodetic place;
  local_.Reverse(enu.x(), enu.y(), enu.z(), place.latitude, place.longitude, place.height);
  place.latitude *= kDegree;
  place.longitude *= kDegree;
  return place;
}

Matrix3d World::rotation_wn(const Geodetic& place) const { return R_we_ * level_axes(place); }

Vector3d World::gravity_value(const Vector3d& p_w) const {
  const Geodetic here = to_geodetic(p_w);
  double north = 0, up = 0;
  GeographicLib::NormalGravity::WGS84().Gravity(here.latitude / kDegree, here.height, north, up);
  return rotation_wn(here) * Vector3d(north, 0, -up);
}

void World::follow(Gravity& gravity, const Vector3d& p_w) const {
  constexpr double kReach = 100;  // m
  if ((p_w - gravity.point).squaredNorm() > kReach * kReach) gravity = this->gravity(p_w);
}

Gravity World::gravity(const Vector3d& p_w) const {
  constexpr double kStep = 50;  // gravity is linear to 1e-10 m/s² over it
  const Geodetic place = to_geodetic(p_w);
  Gravity g{p_w, gravity_value(p_w), Matrix3d(), rotation_wn(place), place.height};
  for (int i = 0; i < 3; ++i) {
    const Vector3d d = kStep * Vector3d::Unit(i);
    g.gradient.col(i) = (gravity_value(p_w + d) - gravity_value(p_w - d)) / (2 * kStep);
  }
  return g;
}

}  // namespace piste
