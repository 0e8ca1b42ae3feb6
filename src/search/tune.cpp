#include "piste/search/tune.h"

#include <utility>

#include "piste/condition/pipeline.h"
#include "piste/inspect/imu_health.h"
#include "piste/start/attitude_noise.h"
#include "piste/start/start.h"
#include "start/vehicle_mounting.h"

namespace piste {

Tuning tune(const Recording& recording, const ReplayOptions& options, const TuneOptions& how,
            const ProgressCallback& progress) {
  const Log log = condition(recording, options.conditioning);
  FilterOptions filter = with_white_part(with_attitude_sigmas(options.filter, recording.attitude), log);
  filter.clock_from = log.imu.front().time;
  filter.adapt.reset();  // the likelihood of the stated noise is wanted
  Start start = options.start ? *options.start : find_start(log, filter, options.heading).start;
  filter = with_mounting(std::move(filter), log, start);
  Tuning tuning = likeliest_noise(log, filter, start, how, progress);
  if (recording.imu.time.size() >= 3) {
    const ImuHealth health = imu_health(recording.imu);
    tuning.at_rest = {health.gyro.noise.maxCoeff(), health.accel.noise.maxCoeff()};
  }
  return tuning;
}

}  // namespace piste
