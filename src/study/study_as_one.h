#pragma once
/// Studies all IMUs of a run fused into one (docs/several_imus.md), in addition to each IMU alone. Part of
/// piste::batch.

#include <optional>
#include <vector>

#include "study/study_imu.h"

namespace piste {

/// Fuses those IMUs of the run that were aligned with the reference, and studies the fused IMU. Its body is the body of
/// the first of them. Clocks, axes and places come from the alignments. `studied`: each of `run.mems`. Nothing if the
/// run has only one IMU. If fewer than two can be used, or the fusion fails, `failure` gives the reason.
std::optional<StudiedImu> study_as_one(const RunConfig& run, const RunReference& reference,
                                       const std::vector<StudiedImu>& studied, const Phases& phases,
                                       const StudyPlan& plan);

}  // namespace piste
