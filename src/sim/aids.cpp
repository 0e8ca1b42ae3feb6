#include "piste/sim/aids.h"

#include <cmath>

#include "piste/sim/random.h"
#include "sim/epochs.h"

namespace piste {
namespace {

// The first axis of a coloured error at each epoch.
std::vector<double> coloured_errors(std::size_t count, double rate, const GaussMarkov& process, RandomStream stream) {
  DriftPath path(process, stream);
  std::vector<double> values(count);
  for (double& value : values) {
    value = path.value().x();
    path.advance(1 / rate);
  }
  return values;
}

void simulate_odometer(const Truth& trunk, const OdometerSetup& setup, std::uint64_t seed, double size,
                       SimulatedAids& out) {
  const std::vector<double> times = epochs(trunk, setup.rate);
  RandomStream noise(seed, "odometer/noise"), scale(seed, "odometer/scale");
  out.speed.file = "odometer.csv";
  out.odometer_scale = size * setup.errors.scale_sigma * scale.normal();
  out.wheel_slip = coloured_errors(times.size(), setup.rate, setup.errors.slip, {seed, "odometer/slip"});
  for (std::size_t k = 0; k < times.size(); ++k) {
    out.wheel_slip[k] *= size;
    const TruthState state = trunk.at(times[k]);
    const double forward = (state.q_wb.conjugate() * state.v_wb).x();
    const double speed = (1 + out.odometer_scale) * (forward + out.wheel_slip[k]);
    const double measured = setup.errors.is_signed ? speed : std::abs(speed);
    out.speed.fixes.push_back({times[k], measured + size * setup.errors.sigma * noise.normal(), setup.errors.sigma});
  }
}

void simulate_barometer(const Truth& plate, const BarometerSetup& setup, std::uint64_t seed, double size,
                        SimulatedAids& out) {
  const std::vector<double> times = epochs(plate, setup.rate);
  RandomStream noise(seed, "barometer/noise");
  out.height.file = "barometer.csv";
  out.barometer_offset = coloured_errors(times.size(), setup.rate, setup.errors.offset, {seed, "barometer/offset"});
  for (std::size_t k = 0; k < times.size(); ++k) {
    out.barometer_offset[k] *= size;
    const double height = plate.world().to_geodetic(plate.at(times[k]).p_wb).height;
    out.height.fixes.push_back(
        {times[k], height + out.barometer_offset[k] + size * setup.errors.sigma * noise.normal(), setup.errors.sigma});
  }
}

void simulate_heading(const Truth& plate, const DualHeadingSetup& setup, std::uint64_t seed, double size,
                      SimulatedAids& out) {
  RandomStream noise(seed, "heading/noise"), pitch_noise(seed, "heading/pitch noise");
  out.heading.file = "heading.csv";
  const Vector3d baseline = setup.errors.baseline.normalized();
  for (const double time : epochs(plate, setup.rate)) {
    const TruthState state = plate.at(time);
    const Vector3d u = plate.world().rotation_wn(state.p_wb).transpose() * (state.q_wb * baseline);
    HeadingFix fix{time, std::atan2(u.y(), u.x()) + size * setup.errors.sigma * noise.normal(), setup.errors.sigma};
    if (setup.pitch_noise > 0) {
      fix.pitch = std::asin(-u.z()) + size * setup.pitch_noise * pitch_noise.normal();
      fix.sigma_pitch = setup.pitch_noise;
    }
    out.heading.fixes.push_back(fix);
  }
}

}  // namespace

TrueMounting true_mounting(const Quaterniond& q_tr, const Quaterniond& q_rb, const Vector3d& p_rb_r) {
  return {(q_tr * q_rb).normalized(), q_rb.conjugate() * -p_rb_r};
}

SimulatedAids simulate_aids(const Truth& trunk, const Truth& plate, const AidSetups& setups, std::uint64_t seed,
                            bool perfect) {
  const double size = perfect ? 0 : 1;
  SimulatedAids out;
  if (setups.odometer) simulate_odometer(trunk, *setups.odometer, seed, size, out);
  if (setups.barometer) simulate_barometer(plate, *setups.barometer, seed, size, out);
  if (setups.heading) simulate_heading(plate, *setups.heading, seed, size, out);
  return out;
}

}  // namespace piste
