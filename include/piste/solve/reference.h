#pragma once
/// A trajectory about which a run is linearised, instead of about the filter's own estimate.
///
/// A filter linearises each step where it believes to be, with the rate and the force that the sensors measured. After
/// an outage that place is far from the truth. And the measured rate holds the noise that the attitude has gathered:
/// as factor of a scale it correlates with the residuals, and the scale follows the noise (errors in variables; Fuller
/// 1987). A smoothed trajectory has neither fault. Filtering and smoothing about it is one Gauss-Newton step for the
/// whole run (the iterated Kalman smoother; Bell 1994).

#include <cstddef>
#include <utility>

#include "piste/core/solution.h"
#include "piste/model/measurement.h"

namespace piste {

/// The rows of a smoothed run, and the estimate at its start.
class Reference {
 public:
  Reference(Solution smoothed, Estimate start) : rows_(std::move(smoothed)), start_(std::move(start)) {}

  const Estimate& start() const { return start_; }
  std::size_t size() const { return rows_.size(); }
  double time(std::size_t row) const { return rows_.time(row); }
  Estimate estimate(std::size_t row) const { return rows_.estimate(row); }
  const Solution& rows() const { return rows_; }

 private:
  Solution rows_;
  Estimate start_;
};

/// Angular rate and specific force, as means over `dt`, that lead from one estimate to the next, in the body axes half
/// way: ω = Log(R₁ᵀ R₂) / dt + Rᵀ ω_ie and f = Rᵀ ((v₂ − v₁) / dt + 2 ω_ie × v − g), what an IMU without errors
/// measures (Groves 2013, section 5.4). `earth_rate` and the gravity are in w.
BodyMotion motion_between(const Estimate& from, const Estimate& to, double dt, const Vector3d& earth_rate,
                          const Gravity& gravity);

}  // namespace piste
