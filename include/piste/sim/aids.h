#pragma once
/// Simulated sensors in addition to IMU and GNSS: a wheel, a barometer and two antennas on the plate. Each is described
/// by the filter's options for it, and its errors are drawn from these.

#include <cstdint>
#include <optional>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/sim/truth.h"

namespace piste {

/// A wheel at the origin of the trunk, which moves along its path: `errors.sigma` is the white noise, `scale_sigma` the
/// 1-sigma from which the scale is drawn.
struct OdometerSetup {
  double rate = 10;  ///< Hz
  OdometerOptions errors;
};

/// `errors.sigma` is the white noise of the height; the offset is drawn from its process.
struct BarometerSetup {
  double rate = 10;
  BarometerOptions errors;
};

/// `errors.baseline` is in the axes of the plate; `errors.sigma` is the white noise of the heading.
struct DualHeadingSetup {
  double rate = 10;
  DualHeadingOptions errors;
  double pitch_noise = 0;  ///< rad; 0: no pitch is measured
};

/// The aids of a run. A vehicle is the trunk: its axes are the vehicle's, and its origin is the contact point.
struct AidSetups {
  std::optional<VehicleOptions::Kind> vehicle;
  std::optional<OdometerSetup> odometer;  ///< needs a vehicle
  std::optional<BarometerSetup> barometer;
  std::optional<DualHeadingSetup> heading;
};

/// Their recordings, and the errors that were added: one per fix where they change.
struct SimulatedAids {
  FixRecording<SpeedFix> speed;
  FixRecording<HeightFix> height;
  FixRecording<HeadingFix> heading;
  double odometer_scale = 0;
  std::vector<double> wheel_slip, barometer_offset;
};

/// The mounting q_vb and the contact point p_bc_b of an IMU, where the trunk is a vehicle. `q_tr`: the plate against
/// the trunk; `q_rb` and `p_rb_r`: the IMU on the plate.
struct TrueMounting {
  Quaterniond q_vb = Quaterniond::Identity();
  Vector3d contact = Vector3d::Zero();
};
TrueMounting true_mounting(const Quaterniond& q_tr, const Quaterniond& q_rb, const Vector3d& p_rb_r);

/// Simulates them over the whole run. `trunk` and `plate` are the truth of t and r. With `perfect` no error is added;
/// the fixes state the same sigmas.
SimulatedAids simulate_aids(const Truth& trunk, const Truth& plate, const AidSetups& setups, std::uint64_t seed,
                            bool perfect = false);

}  // namespace piste
