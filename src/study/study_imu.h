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

/// What all IMUs of a run have in common.
struct RunReference {
  std::vector<ImuSample> imu;  ///< of the reference
  GnssRecording gnss;
  std::optional<ReferenceSolution> solution;  ///< nothing if it is not possible; a warning then says why
  std::vector<std::string> warnings;
};

/// Reads the reference of a run and computes its solution. Throws DataError if its IMU cannot be read.
RunReference read_reference(const RunConfig& run);

/// What the ranking of the methods needs.
struct Contest {
  std::optional<Course> course;      ///< nothing if no navigation is possible
  std::optional<KnownErrors> truth;  ///< the true errors, if they are known
};

/// An IMU aligned with the reference, or several of them as one.
struct ImuBeside {
  ImuSensor sensor;                  ///< along b; of several, of their mean
  std::vector<ImuSensor> units;      ///< of several, each
  Recording recording;               ///< of IMUs alone
  ConditioningOptions conditioning;  ///< to GPS time
  Log log;                           ///< on the clock of `alignment`
  Alignment alignment;
  /// Of several, what the scales of each do across the axes of their mean, per true signal; the diagonal is zero. A
  /// line for each axis cannot tell it, and signals are compared without it.
  Matrix3d across_accel = Matrix3d::Zero(), across_gyro = Matrix3d::Zero();
};

/// The result for one IMU.
struct StudiedImu {
  SensorRun result;  ///< all that was possible; `failure` says what stopped it
  Phases phases;     ///< of the run: those that were given, else those found from the signals
  Contest contest;
  std::optional<ImuBeside> beside;  ///< nothing if it could not be aligned
  std::optional<ImuTruth> truth;    ///< if it is known
};

/// Settings that are the same for every IMU.
struct StudyPlan {
  double low_pass = 12;        ///< [Hz] of both signals
  std::vector<double> delays;  ///< residual timing errors to try [s]
  OutagePlan outages;
};

/// Studies one IMU of a run. `known`: the phases of the run that are given. Faults of its data are part of the result.
StudiedImu study_imu(const RunConfig& run, const RunReference& reference, const MountedImu& mounted,
                     const Phases& known, const StudyPlan& plan);

/// The same of what is aligned already: adds to `out` what signals and filters tell of `imu`. Throws Error where that
/// is not possible.
void study_aligned(const RunConfig& run, const RunReference& reference, const ImuBeside& imu, const Phases& known,
                   const StudyPlan& plan, StudiedImu& out);

/// Holds the estimates of `out` against the true errors, and keeps those.
void hold_against_truth(const ImuTruth& truth, StudiedImu& out);

}  // namespace piste
