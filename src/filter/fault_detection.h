#pragma once
/// Fault detection and exclusion (FDE): decides whether a fix is used. Where a fix and the filter disagree, either the
/// receiver or the filter is at fault.

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "piste/core/behaviour.h"
#include "piste/core/solution.h"
#include "piste/filter/update.h"
#include "piste/model/measurement_list.h"

namespace piste {

/// Keeps for each source whether its last fixes were used, and decides whether each new fix is used.
///
/// A fix outside the gate is rejected. What follows depends on whether the receiver or the filter is at fault:
///
/// - **The receiver jumped.** An error of the filter grows smoothly. So the receiver is at fault if the residual jumps
///   although a fix of the source was used just before. It is also at fault if only its position disagrees while its
///   velocity agrees. The source is then excluded, as in an outage, until the jumps of the receiver add up to zero, for
///   `distrust` seconds at most. A fix that lies inside the gate only because the covariance has grown meanwhile is not
///   used.
/// - **The receiver jumped slightly.** The disagreement does not reach a metre, or a metre per second, within three
///   seconds. The source is then used again: stated sigmas of centimetres are seldom accurate, and such a jump does not
///   justify an outage.
/// - **The fixes before were less certain.** A fix that claims to be better than those used before, by a factor of two
/// and
///   more, disagrees by no more than these claimed for themselves: their errors lasted, and the filter averaged them as
///   if they did not. The filter is then at fault.
/// - **The filter is at fault.** This holds in all other cases: at a start, after an outage, after a gap of the IMU, or
///   if the disagreement grew slowly. After `readmit_after` rejected fixes in a row the filter uses the next one. For
///   `suspicion` seconds after that, no receiver is taken to have jumped.
///
/// A channel with a `hold` (MeasurementChannel) is excluded after a fix outside the gate, until none has been for that
/// time. It is never readmitted: a slipping wheel must not turn the filter.
///
/// Limits: a wrong fix is used if the receiver is at fault for longer than `distrust`. It is also used if its error
/// begins while the filter may be at fault, or grows slowly enough to stay inside the gate. A slow ramp is such an
/// error; conditioning excludes the ramps that velocities show (condition/ramp_faults.h). A fault
/// of the IMU that appears as a jump between two fixes is attributed to the receiver.
class FaultDetection {
 public:
  /// The decision on one fix.
  struct Ruling {
    Outcome outcome = Outcome::kUsed;
    double lapse = 0;     ///< s since a fix of the source was last used, at least 0.5; infinite if none was
    bool parted = false;  ///< readmitted after a jump, which no smoothly growing error explains
  };

  FaultDetection() = default;
  FaultDetection(const std::vector<MeasurementSource>& sources, const FaultDetectionOptions& options);

  /// Decides on a fix at `time`. `bound`: the largest NIS inside the gate. The estimate `x` and its covariance `P` give
  /// the rate at which the filter's own error may change. No heap.
  Ruling rule(int source, double time, const Linearization& lin, const Update& u, double bound, const Estimate& x,
              const Covariance& P);

  /// Whether `fix` repeats the previous fix of its source in every digit. Stores the fix for the next call.
  template <class Type>
  bool repeats(int source, const typename Type::Fix& fix) {
    std::optional<AnyFix>& last = sources_[static_cast<std::size_t>(source)].last;
    const bool same = last && Type::repeats(fix, std::get<typename Type::Fix>(*last));
    last = fix;
    return same;
  }

  /// For `suspicion` seconds from `time` on, the filter is taken to be at fault where it disagrees with a fix.
  void suspect_filter(double time);

 private:
  /// What is taken to be at fault, for a source whose last fix was not used.
  enum class Dispute {
    kNone,        ///< nothing: the last fix was used
    kFilter,      ///< the filter, which uses the source again after some fixes
    kSlightJump,  ///< the receiver, by too small a jump to justify an outage
    kJump,        ///< the receiver
  };
  struct Source {
    int partner = -1;
    bool readmitted = true;
    double hold = 0;
    double held_until = -std::numeric_limits<double>::infinity();
    std::optional<AnyFix> last;  // previous fix
    Dispute dispute = Dispute::kNone;
    int rejected = 0;                                            // fixes in a row that were not used
    double believed = -std::numeric_limits<double>::infinity();  // time of the last fix that was used
    Matrix3d believed_R = Matrix3d::Zero();                      // and its noise
    // Of the dispute:
    double since = 0;
    Matrix3d first_S = Matrix3d::Zero();  // innovation covariance at its first fix
    Vector3d offset = Vector3d::Zero();   // sum of the receiver's jumps so far
    Matrix3d spread = Matrix3d::Zero();   // and its covariance
    double time = 0;                      // of the last fix, with its residual and its noise:
    Vector3d residual = Vector3d::Zero();
    Matrix3d R = Matrix3d::Zero();

    bool jumped() const { return dispute == Dispute::kJump || dispute == Dispute::kSlightJump; }
  };

  void begin_dispute(Source& s, double time, const Linearization& lin, const Update& u, double bound);
  bool receiver_jumped(const Source& s, double time, const Linearization& lin, const Update& u, double bound) const;
  static bool errs_as_claimed_before(const Source& s, const Update& u, double bound);
  bool jumps_add_up_to_none(Source& s, double time, const Linearization& lin, const Update& u, double bound,
                            const Estimate& x, const Covariance& P) const;
  bool is_patient(const Source& s, double time) const;
  const Source* partner_of(const Source& s) const;

  FaultDetectionOptions options_;
  std::vector<Source> sources_;
  double accuses_from_ = -std::numeric_limits<double>::infinity();  // before it no receiver is taken to have jumped
};

}  // namespace piste
