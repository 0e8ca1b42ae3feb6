#pragma once
/// Decides whether a fix is used. Where a fix disagrees with the filter, either the receiver is wrong or the filter is.

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "filter/update.h"
#include "piste/core/behaviour.h"
#include "piste/core/solution.h"
#include "piste/model/measurement_list.h"

namespace piste {

/// Keeps for each source whether its last fixes were used, and rules on each new fix.
///
/// A fix outside the gate is rejected. What follows depends on whether the receiver or the filter is taken to be wrong:
///
/// - **The receiver jumped.** An error of the filter grows smoothly. So the receiver is wrong if the residual jumps
///   although a fix of the source was used just before, or if only its position disagrees while its velocity agrees.
///   The filter then uses no fix of the source, as in an outage, until the jumps of the receiver add up to zero, for
///   `distrust` seconds at most. A fix that lies within the gate only because the covariance has grown meanwhile is not
///   used.
/// - **The receiver jumped slightly.** If the disagreement does not reach a metre, or a metre a second, within three
///   seconds, the source is used again: sigmas of centimetres are seldom that true, and such a jump is not worth an
///   outage.
/// - **The filter is wrong.** This is so in all other cases: at a start, after an outage or a gap of the IMU, or
///   where the disagreement grew slowly. After `readmit_after` rejected fixes in a row the filter uses the next one.
///   For some seconds after that, no receiver is taken to have jumped.
///
/// A channel with a `hold` (MeasurementChannel) is not used after a fix outside the gate, until none has been for so
/// long. It is never readmitted: a wheel that slips must not turn the filter.
///
/// Limits: a false fix is used if the receiver is wrong for longer than `distrust`, if its error begins when the filter
/// may be wrong, or if it grows slowly enough to stay within the gate. A slow ramp is such an error for a receiver
/// without velocities or with coarse ones. A fault of the IMU that appears as a jump between two fixes is taken for one
/// of the receiver.
class FaultDetection {
 public:
  /// The decision on one fix.
  struct Ruling {
    Outcome outcome = Outcome::kUsed;
    double lapse = 0;     ///< time since a fix of the source was last used, at least 0.5; infinite if none was [s]
    bool parted = false;  ///< readmitted after a jump, which no error that grows smoothly explains
  };

  FaultDetection() = default;
  FaultDetection(const std::vector<MeasurementSource>& sources, const FaultDetectionOptions& options);

  /// Rules on a fix at `time`. `bound`: the largest NIS within the gate. The estimate `x` and its covariance `P` say
  /// how fast the filter's own error may change. No heap.
  Ruling rule(int source, double time, const Linearization& lin, const Update& u, double bound, const Estimate& x,
              const Covariance& P);

  /// Whether `fix` repeats the last fix of its source in every digit. Keeps the fix for the next call.
  template <class Type>
  bool repeats(int source, const typename Type::Fix& fix) {
    std::optional<AnyFix>& last = sources_[static_cast<std::size_t>(source)].last;
    const bool same = last && Type::repeats(fix, std::get<typename Type::Fix>(*last));
    last = fix;
    return same;
  }

  /// For some seconds from `time` on, a disagreement is taken to be an error of the filter.
  void suspect_filter(double time);

 private:
  /// What is taken to be wrong, for a source whose last fix was not used.
  enum class Dispute {
    kNone,        ///< nothing: the last fix was used
    kFilter,      ///< the filter, which uses the source again after some fixes
    kSlightJump,  ///< the receiver, but it jumped by too little to be worth an outage
    kJump,        ///< the receiver
  };
  struct Source {
    int partner = -1;
    bool readmitted = true;
    double hold = 0;
    double held_until = -std::numeric_limits<double>::infinity();
    std::optional<AnyFix> last;  // fix
    Dispute dispute = Dispute::kNone;
    int rejected = 0;                                            // fixes in a row since the dispute began
    double believed = -std::numeric_limits<double>::infinity();  // time of the last fix that was used
    // Of the dispute:
    double since = 0;
    Matrix3d first_S = Matrix3d::Zero();  // innovation covariance at its first fix
    Vector3d offset = Vector3d::Zero();   // sum of the receiver's jumps so far
    Matrix3d spread = Matrix3d::Zero();   // and its covariance
    double time = 0;                      // of the last fix, its residual and its noise
    Vector3d residual = Vector3d::Zero();
    Matrix3d R = Matrix3d::Zero();

    bool jumped() const { return dispute == Dispute::kJump || dispute == Dispute::kSlightJump; }
  };

  void begin_dispute(Source& s, double time, const Linearization& lin, const Update& u, double bound);
  bool receiver_jumped(const Source& s, double time, const Linearization& lin, const Update& u, double bound) const;
  bool jumps_add_up_to_none(Source& s, double time, const Linearization& lin, const Update& u, double bound,
                            const Estimate& x, const Covariance& P) const;
  bool is_patient(const Source& s, double time) const;
  const Source* partner_of(const Source& s) const;

  FaultDetectionOptions options_;
  std::vector<Source> sources_;
  double accuses_from_ = -std::numeric_limits<double>::infinity();  // before it no receiver is taken to have jumped
};

}  // namespace piste
