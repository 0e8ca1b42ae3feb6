#pragma once
/// Studies all IMUs of a run as one (docs/several_imus.md), beside the study of each of them. Part of piste::batch.

#include <optional>
#include <vector>

#include "study/study_imu.h"

namespace piste {

/// Studies those IMUs of the run that were aligned with the reference as one IMU, the body of which is the first of
/// them. Clocks, axes and places are those of the alignments. `studied`: each of `run.mems`. Nothing if the run has but
/// one IMU. If fewer than two can be taken, or they cannot be taken as one, `failure` says why.
std::optional<StudiedImu> study_as_one(const RunConfig& run, const RunReference& reference,
                                       const std::vector<StudiedImu>& studied, const Phases& phases,
                                       const StudyPlan& plan);

}  // namespace piste
