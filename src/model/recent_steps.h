#pragma once
/// The steps of the last 0.9 s at least, as measured: the motion at the time of a measurement that comes late.

#include <array>
#include <cstddef>
#include <optional>

#include "piste/core/estimate.h"
#include "piste/model/strapdown.h"

namespace piste {

/// s: a fix within this of the estimate is of the same moment.
inline constexpr double kMoment = 1e-3;

/// The motion over the last τ seconds, corrected, in the body axes at their end but for what says otherwise.
struct LaggedMotion {
  Vector3d rate;            ///< ω̄: Exp(−ω̄ τ) turns the body's axes τ before into those at the end
  Vector3d velocity_force;  ///< f̄ of the change of velocity: v = v_τ + τ (R f̄ + …)
  Vector3d position_force;  ///< f̄ of the change of position: p_τ = p − τ v + ½ τ² (R f̄ + …)
  Vector3d rate_then;       ///< ω at the time τ before, in the body axes then
};

/// Keeps steps. Short ones are kept as sums over at least kBin.
class RecentSteps {
 public:
  void add(const ImuStep& step);
  /// The motion over the last `tau` > 0 seconds with the errors of `x` taken out. Nothing if the steps do not go back
  /// so far. No heap.
  std::optional<LaggedMotion> over(double tau, const Estimate& x) const;

 private:
  static constexpr std::size_t kMost = 200;
  static constexpr double kBin = 0.0045;  // s: half of a usual step; 200 of them are nearly a second
  struct Sum {
    double dt = 0;
    Vector3d dtheta, dvel;
  };
  const Sum& back(std::size_t k) const { return sums_[(newest_ + kMost - k) % kMost]; }

  std::array<Sum, kMost> sums_;
  std::size_t newest_ = 0, count_ = 0;
};

}  // namespace piste
