#pragma once
/// A trajectory about which a run is linearised, instead of about the filter's own estimate.
///
/// A filter linearises each step where it believes to be, with the rate and the force that the sensors measured. After
/// an outage that place is far from the truth. And the measured rate holds the noise that the attitude has gathered:
/// as factor of a scale it correlates with the residuals, and the scale follows the noise (errors in variables; Fuller
/// 1987). A smoothed trajectory has neither fault. Filtering and smoothing about it is one Gauss-Newton step for the
/// whole run (the iterated Kalman smoother; Bell 1994).

#include <vector>

#include "piste/core/estimate.h"
#include "piste/model/measurement.h"

namespace piste {

/// A smoothed run: the estimate at its start, and at the end of each epoch.
struct Reference {
  struct Row {
    double time = 0;
    Estimate x;
  };
  std::vector<Row> rows;  ///< in the order of time
  Estimate start;
};

/// Angular rate and specific force, as means over `dt`, that lead from one estimate to the next, in the body axes half
/// way: ω = Log(R₁ᵀ R₂) / dt + Rᵀ ω_ie and f = Rᵀ ((v₂ − v₁) / dt + 2 ω_ie × v − g), what an IMU without errors
/// measures (Groves 2013, section 5.4). `earth_rate` and the gravity are in w.
BodyMotion motion_between(const Estimate& from, const Estimate& to, double dt, const Vector3d& earth_rate,
                          const Gravity& gravity);

}  // namespace piste
