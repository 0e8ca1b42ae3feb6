#include "study/study_as_one.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <utility>

#include "condition/several_imus.h"
#include "piste/consistency/warnings.h"
#include "piste/core/error.h"
#include "piste/core/imu_array.h"
#include "study/study_estimates.h"

namespace piste {
namespace {

// One of the fused IMUs.
struct FusedImu {
  const StudiedImu* studied;
  const MountedImu* mounted;

  const Alignment& alignment() const { return studied->aligned->alignment; }
};

// Whether clock and axes of an IMU are known, so that its samples can be fused with the samples of others.
bool can_be_taken(const StudiedImu& imu) {
  if (!imu.aligned) return false;
  const Alignment& alignment = imu.aligned->alignment;
  return std::isfinite(alignment.variance(AlignmentLayout::kClockOffset)) && alignment.boresight_sigma().allFinite();
}

std::vector<FusedImu> fused_imus(const RunConfig& run, const std::vector<StudiedImu>& studied,
                                 std::vector<std::string>& warnings) {
  std::vector<FusedImu> out;
  for (std::size_t i = 0; i < studied.size(); ++i) {
    const std::string& name = run.mems[i].name;
    if (!can_be_taken(studied[i])) {
      warnings.push_back(fmt::format("without {}, which is not aligned with the reference", name));
    } else if (out.size() == kMostImus) {
      warnings.push_back(fmt::format("without {}: at most {} IMUs are taken as one", name, kMostImus));
    } else {
      out.push_back({&studied[i], &run.mems[i]});
    }
  }
  if (out.size() < 2) throw DataError("", "fewer than two of the IMUs are aligned with the reference");
  return out;
}

// From the axes of an IMU to the axes of the first IMU.
Matrix3d axes_of(const FusedImu& single, const FusedImu& first) {
  return (first.alignment().q_rb.conjugate() * single.alignment().q_rb).toRotationMatrix();
}

// Cross-axis effect of the IMUs' estimated scales, in the axes of their mean.
Matrix3d across(const std::vector<FusedImu>& imus, const std::vector<ImuSensor>& sensors, TriadMember triad,
                int first) {
  const ImuVector weights = imu_weights(sensors, triad);
  Matrix3d out = Matrix3d::Zero();
  for (std::size_t i = 0; i < imus.size(); ++i) {
    Vector3d scale = Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const AxisEstimate* found = imus[i].studied->result.estimate(Method::kJointBothNoisy, first + axis);
      if (found && found->line) scale(axis) = found->line->value(1);
    }
    const Matrix3d R = axes_of(imus[i], imus.front());
    out += weights(static_cast<Eigen::Index>(i)) * R * scale.asDiagonal() * R.transpose();
  }
  out.diagonal().setZero();
  return out;
}

ReferencedImu together(const std::vector<FusedImu>& imus) {
  const FusedImu& first = imus.front();
  ReferencedImu out = *first.studied->aligned;
  out.recording.further.clear();
  for (const FusedImu& single : imus) {
    const ReferencedImu& own = *single.studied->aligned;
    FusedImuConditioning conditioning{.name = single.mounted->name, .imu = own.conditioning.imu, .sensor = own.sensor};
    if (&single != &first) {
      const Matrix3d R = axes_of(single, first);
      const Vector3d apart = own.alignment.p_rb_r - first.alignment().p_rb_r;
      conditioning.imu.R_bs = R * own.conditioning.imu.R_bs;
      conditioning.sensor = turned(own.sensor, R);
      conditioning.place = first.alignment().q_rb.conjugate() * own.alignment.known(apart, AlignmentLayout::kLeverArm);
      out.recording.further.push_back(own.recording.imu);
    }
    out.imus.push_back(conditioning.sensor);
    out.conditioning.imus.push_back(std::move(conditioning));
  }
  out.sensor = mean_sensor(out.imus);
  out.across_accel = across(imus, out.imus, &ImuSensor::accel, 0);
  out.across_gyro = across(imus, out.imus, &ImuSensor::gyro, 3);
  out.log = condition_imus(out.recording, out.conditioning);
  out.alignment.clock_offset = out.alignment.clock_drift = 0;  // its samples are in GPS time
  return out;
}

// The true errors of the mean of the IMUs, along the axes of the first, without the part that was subtracted from the
// signals.
std::optional<ImuTruth> mean_truth(const std::vector<FusedImu>& imus, const ReferencedImu& mean) {
  for (const FusedImu& single : imus) {
    if (!single.studied->truth) return std::nullopt;
  }
  const auto triad = [&](ImuTruth::Triad ImuTruth::*which, TriadMember sensor, const Matrix3d& taken) {
    const ImuVector weights = imu_weights(mean.imus, sensor);
    ImuTruth::Triad out = imus.front().studied->truth.value().*which;
    out.bias = out.scale = Vector3d::Zero();
    out.misalignment = Matrix3d::Identity() - taken;
    const std::array phases{&ImuTruth::Triad::before, &ImuTruth::Triad::run, &ImuTruth::Triad::after};
    for (const auto phase : phases) {
      if (out.*phase) (out.*phase)->drift.setZero();
    }
    for (std::size_t i = 0; i < imus.size(); ++i) {
      const double weight = weights(static_cast<Eigen::Index>(i));
      const ImuTruth::Triad& own = imus[i].studied->truth.value().*which;
      const Matrix3d R = axes_of(imus[i], imus.front());
      out.bias += weight * R * own.bias;
      out.misalignment += weight * R * gain_of(own) * R.transpose();
      for (const auto phase : phases) {
        if (out.*phase && own.*phase) (out.*phase)->drift += weight * R * (own.*phase)->drift;
      }
    }
    return out;
  };
  return ImuTruth{triad(&ImuTruth::gyro, &ImuSensor::gyro, mean.across_gyro),
                  triad(&ImuTruth::accel, &ImuSensor::accel, mean.across_accel)};
}

}  // namespace

std::optional<StudiedImu> study_as_one(const RunConfig& run, const RunReference& reference,
                                       const std::vector<StudiedImu>& studied, const Phases& phases,
                                       const StudyPlan& plan) {
  if (studied.size() < 2) return std::nullopt;
  StudiedImu out;
  SensorRun& result = out.result;
  out.phases = phases;
  try {
    const std::vector<FusedImu> imus = fused_imus(run, studied, result.warnings);
    for (const FusedImu& single : imus) result.imus.push_back(single.mounted->name);
    const ReferencedImu imu = together(imus);
    for (std::string& line : absence_lines(imu.log.counts.imus)) result.warnings.push_back(std::move(line));
    const SensorRun& first = imus.front().studied->result;
    result.clock_offset = first.clock_offset;
    result.clock_drift = first.clock_drift;
    result.boresight = first.boresight;
    result.sigma_boresight = first.sigma_boresight;
    result.lever_arm = first.lever_arm;
    study_aligned(run, reference, imu, phases, plan, out);
    if (const auto truth = mean_truth(imus, imu)) hold_against_truth(*truth, out);
  } catch (const Error& e) {
    result.failure = e.what();
  }
  return out;
}

}  // namespace piste
