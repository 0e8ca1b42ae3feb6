#include "piste/math/earth.h"

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/NormalGravity.hpp>
#include <cmath>

#include "piste/math/units.h"

namespace piste {
namespace {

// GeographicLib's local axes are east, north, up.
Vector3d swap_enu_ned(const Vector3d& a) { return {a.y(), a.x(), -a.z()}; }

// Directions of latitude and longitude, and the height, of a position.
struct Place {
  double sin_latitude, cos_latitude, sin_longitude, cos_longitude, height;
};

Place directions(const Geodetic& place) {
  return {std::sin(place.latitude), std::cos(place.latitude), std::sin(place.longitude), std::cos(place.longitude),
          place.height};
}

// Latitude by its tangent from that of the parametric latitude (Bowring 1985). The start is accurate to 1e-14 rad near
// the ellipsoid. One iteration makes it exact to rounding from some kilometres below the ellipsoid up to satellites. No
// angle is taken. Within a metre of the axis the longitude is 0.
Place place_of(const Vector3d& p_e) {
  const GeographicLib::Geocentric& ellipsoid = GeographicLib::Geocentric::WGS84();
  const double a = ellipsoid.EquatorialRadius(), f = ellipsoid.Flattening(), b = a * (1 - f), e2 = f * (2 - f);
  const double second = e2 / (1 - e2);  // e'²
  const double r = std::sqrt(p_e.x() * p_e.x() + p_e.y() * p_e.y()), z = p_e.z();
  // Numerator and denominator of tan φ from those of the tangent of the parametric latitude.
  const auto latitude = [&](double up, double out) {
    const double scale = 1 / std::sqrt(up * up + out * out), s = up * scale, c = out * scale;
    return std::pair(z + second * b * s * s * s, r - e2 * a * c * c * c);
  };
  const auto first = latitude((1 - f) * z * (1 + second * b / std::sqrt(r * r + z * z)), r);
  const auto [up, out] = latitude((1 - f) * first.first, first.second);
  const double scale = 1 / std::sqrt(up * up + out * out), s = up * scale, c = out * scale;
  const bool at_axis = r < 1;
  return {s, c, at_axis ? 0 : p_e.y() / r, at_axis ? 1 : p_e.x() / r, r * c + z * s - a * std::sqrt(1 - e2 * s * s)};
}

// R_en. Columns: north, east, down in ECEF.
Matrix3d level_axes(const Place& p) {
  Matrix3d R_en;
  R_en << -p.sin_latitude * p.cos_longitude, -p.sin_longitude, -p.cos_latitude * p.cos_longitude,  //
      -p.sin_latitude * p.sin_longitude, p.cos_longitude, -p.cos_latitude * p.sin_longitude,       //
      p.cos_latitude, 0, -p.sin_latitude;
  return R_en;
}

Geodetic geodetic(const Place& p) {
  return {std::atan2(p.sin_latitude, p.cos_latitude), std::atan2(p.sin_longitude, p.cos_longitude), p.height};
}

Vector3d origin_in_ecef(const Geodetic& origin) {
  Vector3d p;
  GeographicLib::Geocentric::WGS84().Forward(origin.latitude / kDegree, origin.longitude / kDegree, origin.height,
                                             p.x(), p.y(), p.z());
  return p;
}

}  // namespace

World::World(const Geodetic& origin)
    : origin_(origin),
      local_(origin.latitude / kDegree, origin.longitude / kDegree, origin.height),
      R_we_(level_axes(directions(origin)).transpose()),
      p_e_(origin_in_ecef(origin)),
      earth_rate_(kEarthRate * std::cos(origin.latitude), 0, -kEarthRate * std::sin(origin.latitude)) {}

Vector3d World::from_geodetic(const Geodetic& place) const {
  Vector3d enu;
  local_.Forward(place.latitude / kDegree, place.longitude / kDegree, place.height, enu.x(), enu.y(), enu.z());
  return swap_enu_ned(enu);
}

Geodetic World::to_geodetic(const Vector3d& p_w) const { return geodetic(place_of(p_e_ + R_we_.transpose() * p_w)); }

Matrix3d World::rotation_wn(const Vector3d& p_w) const {
  return R_we_ * level_axes(place_of(p_e_ + R_we_.transpose() * p_w));
}

std::pair<Geodetic, Matrix3d> World::local_level(const Vector3d& p_w) const {
  const Place place = place_of(p_e_ + R_we_.transpose() * p_w);
  return {geodetic(place), R_we_ * level_axes(place)};
}

Vector3d World::gravity_value(const Vector3d& p_w) const {
  const auto [here, R_wn] = local_level(p_w);
  double north = 0, up = 0;
  GeographicLib::NormalGravity::WGS84().Gravity(here.latitude / kDegree, here.height, north, up);
  return R_wn * Vector3d(north, 0, -up);
}

void World::follow(Gravity& gravity, const Vector3d& p_w) const {
  constexpr double kReach = 100;  // m
  if ((p_w - gravity.point).squaredNorm() > kReach * kReach) gravity = this->gravity(p_w);
}

Gravity World::gravity(const Vector3d& p_w) const {
  constexpr double kStep = 50;  // gravity is linear to 1e-10 m/s² over it
  const auto [place, R_wn] = local_level(p_w);
  Gravity g{p_w, gravity_value(p_w), Matrix3d(), R_wn, place.height};
  for (int i = 0; i < 3; ++i) {
    const Vector3d d = kStep * Vector3d::Unit(i);
    g.gradient.col(i) = (gravity_value(p_w + d) - gravity_value(p_w - d)) / (2 * kStep);
  }
  return g;
}

}  // namespace piste
