#include "piste/model/dual_heading.h"

#include "piste/model/magnetometer.h"

namespace piste {

Linearization linearize_heading(const HeadingFix& fix, const Vector3d& baseline, const Estimate& x,
                                const Matrix3d& R_wn) {
  // A magnetic field along the baseline, with a declination that is the heading, tells the same.
  return linearize_magnetic_heading(baseline, fix.heading, fix.sigma, x, R_wn);
}

}  // namespace piste
