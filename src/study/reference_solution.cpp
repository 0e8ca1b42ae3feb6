#include "study/reference_solution.h"

#include <cmath>

#include "piste/io/solution_io.h"
#include "piste/replay/replay.h"

namespace piste {

ReferenceSolution solve_reference(const RunConfig& run, const ImuRecording& imu, const GnssRecording& gnss) {
  constexpr double kAttitudeRate = 10;
  FilterOptions filter;
  filter.sensor = turned(run.reference.source.sensor, run.reference.source.conditioning.R_bs);
  filter.gnss = {run.gnss->options};
  filter.estimate = imu_error_blocks(filter.sensor);
  for (const Block block : position_drifts(filter)) filter.estimate.push_back(block);
  ConditioningOptions conditioning = run.reference.conditioning;
  conditioning.behaviour = filter.behaviour;
  const Replay solved = replay(Recording{imu, {gnss}, {}}, {.conditioning = conditioning, .filter = filter});

  const Solution& solution = solved.solution();
  Vector3d attitude = Vector3d::Zero();
  double position = 0;
  for (std::size_t i = 0; i < solution.size(); ++i) {
    const Sigmas sigmas = solution.sigmas(i);
    attitude += sigmas.euler.cwiseAbs2();
    position += sigmas.position.squaredNorm();
  }
  const auto epochs = static_cast<double>(solution.size());
  return {attitude_recording(solution, kAttitudeRate), solution.attitude_correlation_time,
          ReferenceTrack(solution, solved.log.imu, {solution.time(0), solution.time(solution.size() - 1)}),
          (attitude / epochs).cwiseSqrt(), std::sqrt(position / epochs)};
}

}  // namespace piste
