#pragma once
/// Studies one IMU in one run of a campaign: all results except the ranking. Part of piste::batch.

#include <optional>
#include <string>
#include <vector>

#include "core/recording.h"
#include "piste/condition/alignment.h"
#include "piste/core/aligned.h"
#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/model/known_errors.h"
#include "piste/study/navigation_score.h"
#include "piste/study/study_config.h"
#include "piste/study/study_findings.h"
#include "study/reference_solution.h"
#include "study/truth_file.h"

namespace piste {

/// The reference that all IMUs of a run share.
struct RunReference {
  std::vector<ImuSample> imu;  ///< of the reference
  GnssRecording gnss;
  std::optional<ReferenceSolution> solution;  ///< nothing if it is not possible; a warning then says why
  std::vector<std::string> warnings;
};

/// Reads the reference of a run and computes its solution. Throws DataError if its IMU cannot be read.
RunReference read_reference(const RunConfig& run);

/// The input of the ranking of the methods.
struct Contest {
  std::optional<Course> course;      ///< nothing if no navigation is possible
  std::optional<KnownErrors> truth;  ///< the true errors, if they are known
};

/// An IMU aligned with the reference, or several IMUs fused into one.
struct ReferencedImu {
  ImuSensor sensor;                  ///< along b; of a fused IMU, of the mean
  std::vector<ImuSensor> imus;       ///< of a fused IMU, each IMU
  Recording recording;               ///< of IMUs only
  ConditioningOptions conditioning;  ///< to GPS time
  Log log;                           ///< on the clock of `alignment`
  Alignment alignment;
  /// Of a fused IMU: the cross-axis effect of the IMUs' scales on their mean, per true signal; the diagonal is zero. A
  /// line for each axis cannot model it, so it is removed before signals are compared.
  Matrix3d across_accel = Matrix3d::Zero(), across_gyro = Matrix3d::Zero();
};

/// The result for one IMU.
struct StudiedImu {
  SensorRun result;  ///< all that was possible; `failure` gives the reason for what is missing
  Phases phases;     ///< of the run: configured, or else detected in the signals
  Contest contest;
  std::optional<ReferencedImu> aligned;  ///< nothing if it could not be aligned
  std::optional<ImuTruth> truth;         ///< if it is known
};

/// Settings that are the same for every IMU.
struct StudyPlan {
  double low_pass = 12;        ///< [Hz] of both signals
  std::vector<double> delays;  ///< residual timing errors to evaluate [s]
  OutagePlan outages;
};

/// Studies one IMU of a run. `known`: the configured phases of the run. Faults of its data are part of the result.
StudiedImu study_imu(const RunConfig& run, const RunReference& reference, const MountedImu& mounted,
                     const Phases& known, const StudyPlan& plan);

/// The same for an aligned IMU: adds the estimates by signals and filters to `out`. Throws Error if that is not
/// possible.
void study_aligned(const RunConfig& run, const RunReference& reference, const ReferencedImu& imu, const Phases& known,
                   const StudyPlan& plan, StudiedImu& out);

/// Compares the estimates of `out` with the true errors, and keeps the true errors.
void hold_against_truth(const ImuTruth& truth, StudiedImu& out);

}  // namespace piste
