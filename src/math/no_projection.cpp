// Projection of a piste that was built without PROJ.

#include "math/projection.h"

namespace piste {

struct Projection::Proj {};

bool has_projections() { return false; }

Projection::Projection(int) {
  throw NoProjection("codes of EPSG need PROJ, which this build does not have (Debian: libproj-dev)");
}

Projection::~Projection() = default;

Eigen::Vector2d Projection::easting_northing(const Geodetic&) const { return {0, 0}; }

}  // namespace piste
