#pragma once
/// Whose a disagreement is: the receiver's or the filter's.

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "piste/core/solution.h"
#include "piste/model/measurement_list.h"
#include "piste/solve/update.h"

namespace piste {

/// What a filter holds of its sources of fixes.
///
/// A fix outside the gate is rejected, and then either the sensor or the filter is wrong. A filter goes wrong smoothly:
/// a residual that leaps where the source was believed just before, or one of position alone while the velocities of
/// the same receiver agree, is the receiver's. The filter coasts as in an outage until the receiver's jumps add up to
/// none, for `distrust` at most; a fix that only comes to lie within the gate as the covariance grows is not believed.
/// A disagreement that does not come to a metre, or a metre a second, within three seconds is not worth coasting for:
/// sigmas of centimetres are seldom that true.
/// In all other cases (a start, an outage, a gap of the IMU, a disagreement that grew) the filter is held to be wrong
/// after `readmit_after` fixes in a row, and takes them; for some seconds no receiver is held to have jumped then.
///
/// Where that ends: a lie that is longer than `distrust`, that begins when the filter may be wrong, or that creeps in
/// below the gate is believed. A ramp is such a one for a receiver without velocities, or with coarse ones. A fault of
/// the IMU that shows as a leap between two fixes is taken for one of the receiver.
class Trust {
 public:
  struct Limits {
    int readmit_after = 0;  ///< rejections in a row
    double distrust = 0;    ///< [s]
  };

  /// Whether a fix is used. One that is readmitted is outside the gate.
  struct Ruling {
    Outcome outcome = Outcome::kUsed;
    double lapse = 0;  ///< since the source was last believed, half a second at least; infinite where it never was [s]
    bool parted = false;  ///< readmitted, and nothing that led to the disagreement explains it: it came at once
  };

  Trust() = default;
  Trust(const std::vector<MeasurementSource>& sources, Limits limits);

  /// Rules on a fix at `time`, whose innovation may have an NIS of `bound`; estimate and covariance say how fast the
  /// filter's own error may change. No heap.
  Ruling rule(int source, double time, const Linearization& lin, const Update& u, double bound, const Estimate& x,
              const Covariance& P);

  /// Whether the sensor whose first source this is gives its last fix again, in every digit. Keeps the fix.
  template <class Type>
  bool repeats(int source, const typename Type::Fix& fix) {
    std::optional<AnyFix>& last = sources_[static_cast<std::size_t>(source)].last;
    const bool same = last && Type::repeats(fix, std::get<typename Type::Fix>(*last));
    last = fix;
    return same;
  }

  /// For some seconds from `time` on it is the filter that may be wrong, and no receiver.
  void suspect_filter(double time);

 private:
  /// Of a source whose last fix was not used: what is held to be wrong.
  enum class Dispute {
    kNone,
    kFilter,      ///< the filter may be; it gives way after some fixes
    kSlightJump,  ///< the receiver jumped, but by so little that it is not worth coasting for
    kJump,        ///< the receiver jumped
  };
  struct Source {
    int partner = -1;
    bool readmitted = true;
    std::optional<AnyFix> last;  // of the sensor's first source
    Dispute dispute = Dispute::kNone;
    int rejected = 0;                                            // fixes in a row since the dispute began
    double believed = -std::numeric_limits<double>::infinity();  // time of the last fix that was used
    // Of the dispute:
    double since = 0;
    Matrix3d first_S = Matrix3d::Zero();  // innovation covariance as it began
    Vector3d offset = Vector3d::Zero();   // sum of the receiver's jumps so far
    Matrix3d spread = Matrix3d::Zero();   // and its covariance
    double time = 0;                      // of the last fix, its residual and its noise
    Vector3d residual = Vector3d::Zero();
    Matrix3d R = Matrix3d::Zero();

    bool jumped() const { return dispute == Dispute::kJump || dispute == Dispute::kSlightJump; }
  };

  void begin_dispute(Source& s, double time, const Linearization& lin, const Update& u, double bound);
  bool receiver_jumped(const Source& s, double time, const Linearization& lin, const Update& u, double bound) const;
  static bool jumps_add_up_to_none(Source& s, double time, const Linearization& lin, const Update& u, double bound,
                                   const Estimate& x, const Covariance& P);
  bool is_patient(const Source& s, double time) const;
  const Source* partner_of(const Source& s) const;

  Limits limits_;
  std::vector<Source> sources_;
  double accuses_from_ = -std::numeric_limits<double>::infinity();  // before, no receiver is held to have jumped
};

}  // namespace piste
