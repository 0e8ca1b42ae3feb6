#pragma once
/// Map projections by their EPSG codes, with PROJ if piste was built with it.

#include <Eigen/Core>
#include <memory>
#include <stdexcept>

#include "piste/math/earth.h"

namespace piste {

/// Whether piste was built with PROJ.
bool has_projections();

/// No projection that can be used has this code; the text says why.
struct NoProjection : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A projected coordinate system in metres, from latitudes and longitudes of WGS84. Where both systems have other
/// datums, the places are transformed as PROJ does it with what is installed: its grids are not fetched.
///
///     Projection swiss(2056);  // CH1903+ / LV95
///     swiss.easting_northing({0.8188, 0.1299, 500});  // → about 2 600 000, 1 200 000
class Projection {
 public:
  /// Throws NoProjection if piste was built without PROJ, PROJ does not know the code, or it is not of two axes in
  /// metres.
  explicit Projection(int epsg);
  ~Projection();
  Projection(const Projection&) = delete;
  Projection& operator=(const Projection&) = delete;
  /// m; infinite where the place is outside of what the projection can show.
  Eigen::Vector2d easting_northing(const Geodetic& place) const;

 private:
  struct Proj;
  std::unique_ptr<Proj> proj_;
};

}  // namespace piste
