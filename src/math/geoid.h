#pragma once
/// The geoid EGM96: the height of the sea over the ellipsoid.

#include "piste/math/earth.h"

namespace piste {

/// Whether a geoid is there: GeographicLib's files, or the grid that was packed when piste was built.
bool has_geoid();

/// N of height above the ellipsoid = height above the sea + N [m]: the undulation of EGM96 (Lemoine et al. 1998,
/// NASA/TP-1998-206861). GeographicLib's grid of 5′ or 15′ where it is installed (geographiclib-get-geoids), else a
/// grid of half a degree made from that of proj-data; between its points the cubic of Catmull and Rom. The second
/// differs from the first by some decimetres in mountains. Throws std::runtime_error without either.
///
///     geoid_undulation({0.8, 0.13, 0});  // → about 51 m, in the Jura
double geoid_undulation(const Geodetic& place);

}  // namespace piste
