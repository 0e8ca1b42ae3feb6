#include "filter/fault_detection.h"

#include <algorithm>
#include <cmath>

namespace piste {
namespace {

// Fixes in a row outside the gate after which several IMUs disagree by more than chance. The mean that the filter
// follows is then at fault, and a receiver that contradicts it is not.
constexpr int kNoChance = 2;

double normalized(const Vector3d& z, const Matrix3d& S) { return z.dot(S.llt().solve(z)); }

bool of_position(const Linearization& lin) { return lin.observes == Block::kPosition; }

// Whether a residual exceeds an error that the filter could have accumulated since it last used the source, `lapse` s
// ago.
bool leaps(const Linearization& lin, const Vector3d& residual, const Matrix3d& S, double lapse, double bound,
           const FaultDetectionOptions& options) {
  const double missed = lapse * (of_position(lin) ? options.missed_velocity : options.missed_force);
  return lapse <= options.recent && normalized(residual, S + missed * missed * Matrix3d::Identity()) > bound;
}

// Covariance of the change of a residual within one second that errors of the filter cause. An error in velocity
// changes the residual of a position; a tilt changes that of a velocity.
Matrix3d own_change(const Linearization& lin, const Estimate& x, const Covariance& P) {
  if (of_position(lin)) {
    const Eigen::Matrix<double, 3, 9> velocity = ordinary_from_invariant(x).middleRows<3>(3);
    return velocity * P.topLeftCorner<9, 9>() * velocity.transpose();
  }
  return kStandardGravity * kStandardGravity * P.block<3, 3>(6, 6).trace() * Matrix3d::Identity();
}

}  // namespace

FaultDetection::FaultDetection(const std::vector<MeasurementSource>& sources, const FaultDetectionOptions& options)
    : options_(options), sources_(sources.size()) {
  for (std::size_t i = 0; i < sources.size(); ++i) {
    sources_[i].partner = sources[i].partner;
    sources_[i].readmitted = sources[i].readmitted;
    sources_[i].hold = sources[i].hold;
  }
}

void FaultDetection::suspect_filter(double time) { accuses_from_ = std::max(accuses_from_, time + options_.suspicion); }

// The velocity of a receiver for its position, and vice versa; null for other sources.
const FaultDetection::Source* FaultDetection::partner_of(const Source& s) const {
  return s.partner < 0 ? nullptr : &sources_[static_cast<std::size_t>(s.partner)];
}

// Whether a fix that claims to be better than those that were used disagrees by no more than these claimed: float
// solutions err by half a metre for a minute, and a fixed one after them is right.
bool FaultDetection::errs_as_claimed_before(const Source& s, const Update& u, double bound) {
  constexpr double kBetter = 2;  // of sigmas
  return kBetter * kBetter * u.R.trace() < s.believed_R.trace() && normalized(u.residual, u.S + s.believed_R) <= bound;
}

// At the first residual outside the gate: whether the receiver is at fault. It is if the residual jumps, if its other
// channel jumped, or if only its position disagrees.
bool FaultDetection::receiver_jumped(const Source& s, double time, const Linearization& lin, const Update& u,
                                     double bound) const {
  const Source* const partner = partner_of(s);
  const double lapse = time - s.believed;
  if (!partner || lapse > options_.recent || time < accuses_from_) return false;
  if (errs_as_claimed_before(s, u, bound)) return false;
  if (leaps(lin, u.residual, u.S, lapse, bound, options_)) return true;
  if (partner->dispute != Dispute::kNone) return partner->jumped();
  return of_position(lin) && time - partner->believed < options_.recent;
}

void FaultDetection::begin_dispute(Source& s, double time, const Linearization& lin, const Update& u, double bound) {
  s.dispute = receiver_jumped(s, time, lin, u, bound) ? Dispute::kSlightJump : Dispute::kFilter;
  s.since = time;
  s.first_S = s.spread = u.S;
  s.offset = s.residual = u.residual;
  s.R = u.R;
}

// Whether a receiver that jumped has returned. As the covariance grows, a wrong fix may come to lie inside the gate. So
// after the first `recent` seconds the receiver's jumps must add up to zero. A jump is a change too sudden for an error
// of the filter.
bool FaultDetection::jumps_add_up_to_none(Source& s, double time, const Linearization& lin, const Update& u,
                                          double bound, const Estimate& x, const Covariance& P) const {
  const double dt = time - s.time;
  const Vector3d change = u.residual - s.residual;
  const Matrix3d spread = u.R + s.R + dt * dt * own_change(lin, x, P);
  if (normalized(change, spread) > bound) {
    s.offset += change;
    s.spread += spread;
  }
  s.residual = u.residual;
  s.R = u.R;
  return normalized(s.offset, s.spread) <= bound ||
         (time - s.since < options_.recent && normalized(u.residual, s.first_S) <= bound);
}

bool FaultDetection::is_patient(const Source& s, double time) const {
  if (!s.readmitted) return true;
  if (!s.jumped()) return s.rejected <= options_.readmit_after;
  return time - s.since < (s.dispute == Dispute::kSlightJump ? options_.slight_patience : options_.distrust);
}

FaultDetection::Ruling FaultDetection::rule(int source, double time, const Linearization& lin, const Update& u,
                                            double bound, const Estimate& x, const Covariance& P) {
  Source& s = sources_[static_cast<std::size_t>(source)];
  const bool inside = u.nis <= bound;
  if (lin.excluded) {
    return {inside ? Outcome::kDisputed : Outcome::kRejected, std::max(time - s.believed, options_.shortest_lapse)};
  }
  if (s.hold > 0) {
    if (!inside) s.held_until = time + s.hold;
    Ruling ruling{.lapse = std::max(time - s.believed, options_.shortest_lapse)};
    if (time < s.held_until) {
      ruling.outcome = inside ? Outcome::kDisputed : Outcome::kRejected;
    } else {
      s.believed = time;
    }
    return ruling;
  }
  if (s.jumped() && time - s.time > options_.recent) {  // jumps during an outage were not observed
    s.dispute = Dispute::kFilter;
    s.rejected = 1;
  }
  bool believed = inside;
  if (s.dispute == Dispute::kNone) {
    if (!inside) begin_dispute(s, time, lin, u, bound);
  } else if (s.jumped()) {
    believed = jumps_add_up_to_none(s, time, lin, u, bound, x, P) && inside;
  }
  if (s.dispute == Dispute::kSlightJump) {  // only of a source with a partner
    if (u.residual.norm() >= options_.slight || partner_of(s)->dispute == Dispute::kJump) {
      s.dispute = Dispute::kJump;
    } else {
      believed = inside;
    }
  }
  s.time = time;

  Ruling ruling{.lapse = std::max(time - s.believed, options_.shortest_lapse)};
  if (!believed) {
    ++s.rejected;
    if (s.rejected == kNoChance && s.readmitted && !is_navigation(lin.observes)) suspect_filter(time);
    if (is_patient(s, time)) {
      ruling.outcome = inside ? Outcome::kDisputed : Outcome::kRejected;
      return ruling;
    }
    if (s.dispute == Dispute::kSlightJump) s.dispute = Dispute::kFilter;
    if (!inside) {
      ruling.outcome = Outcome::kReadmitted;
      ruling.parted = s.jumped() || leaps(lin, s.offset, s.first_S, s.since - s.believed, bound, options_);
      // An error of the initial state is no evidence on later disagreements.
      if (!s.jumped() && s.partner >= 0 && std::isfinite(ruling.lapse)) suspect_filter(time);
    }
  }
  s.believed = time;
  s.believed_R = u.R;
  s.rejected = 0;
  s.dispute = Dispute::kNone;
  return ruling;
}

}  // namespace piste
