#include "experiment/reference_solution.h"

#include <cmath>

#include "piste/condition/pipeline.h"
#include "piste/condition/rest_detection.h"
#include "piste/io/solution_io.h"
#include "piste/solve/rts.h"
#include "piste/solve/start.h"

namespace piste {

ReferenceSolution solve_reference(const RunConfig& run, const ImuRecording& imu, const GnssRecording& gnss) {
  constexpr double kAttitudeRate = 10;
  FilterOptions options;
  options.sensor = run.reference.source.sensor;
  options.gnss = {run.gnss->options};
  options.estimate = imu_error_blocks(options.sensor);
  if (options.gnss.front().drift) options.estimate.push_back(Block::kGnssPositionDrift);
  ConditioningOptions conditioning = run.reference.conditioning;
  conditioning.rest = options.rest;
  Log log = condition({imu, {gnss}, {}}, conditioning);
  mark_rest(log, options.rest);

  const FilterRun filtered = run_filter(log, options, find_start(log, options, {}).start, kCheckpointEvery);
  std::vector<AttitudeLag> lags;
  const Solution smoothed = smooth_rts(log, filtered, {}, nullptr, &lags);
  Vector3d attitude = Vector3d::Zero();
  double position = 0;
  for (std::size_t i = 0; i < smoothed.size(); ++i) {
    const Sigmas sigmas = smoothed.sigmas(i);
    attitude += sigmas.euler.cwiseAbs2();
    position += sigmas.position.squaredNorm();
  }
  const auto epochs = static_cast<double>(smoothed.size());
  return {attitude_recording(smoothed, kAttitudeRate), correlation_time(lags),
          ReferenceTrack(smoothed, log.imu, {smoothed.time(0), smoothed.time(smoothed.size() - 1)}),
          (attitude / epochs).cwiseSqrt(), std::sqrt(position / epochs)};
}

}  // namespace piste
