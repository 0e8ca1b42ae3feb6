#pragma once
/// One IMU in one run of a campaign: all that is found of it but the ranking. In piste::batch.

#include <optional>
#include <string>
#include <vector>

#include "experiment/reference_solution.h"
#include "piste/core/aligned.h"
#include "piste/core/log.h"
#include "piste/experiment/navigation_score.h"
#include "piste/experiment/study_config.h"
#include "piste/experiment/study_findings.h"
#include "piste/model/known_errors.h"

namespace piste {

/// What all IMUs of a run have in common.
struct RunReference {
  std::vector<ImuSample> imu;  ///< of the reference
  GnssRecording gnss;
  std::optional<ReferenceSolution> solution;  ///< nothing where there is none, and a warning that says why
  std::vector<std::string> warnings;
};

/// Reads the reference of a run and solves it. Throws where its IMU cannot be read.
RunReference read_reference(const RunConfig& run);

/// What the methods are ranked by.
struct Contest {
  std::optional<Course> course;      ///< nothing where there is no navigation
  std::optional<KnownErrors> truth;  ///< what was put in
};

struct StudiedImu {
  SensorRun result;  ///< as far as it goes; `failure` says what stopped it
  Phases phases;     ///< of the run: those that were known, else as this IMU and the reference show them
  Contest contest;
};

/// What is done to every IMU.
struct StudyPlan {
  double low_pass = 12;        ///< [Hz] of both signals
  std::vector<double> delays;  ///< residual timing errors that are tried [s]
  OutagePlan outages;
};

/// One IMU of a run, beside its reference, with the phases of the run where they are known.
/// What is wrong with its data stands in the result.
StudiedImu study_imu(const RunConfig& run, const RunReference& reference, const MountedImu& mounted,
                     const Phases& known, const StudyPlan& plan);

}  // namespace piste
