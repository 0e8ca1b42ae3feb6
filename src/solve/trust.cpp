#include "piste/solve/trust.h"

#include <algorithm>
#include <cmath>

namespace piste {
namespace {

constexpr double kRecent = 2;          // s between fixes over which a jump can be seen
constexpr double kSlight = 1;          // m or m/s: a smaller jump is not worth an outage
constexpr double kSlightPatience = 3;  // s in which a slight jump may grow
// How fast an error that the covariance does not know may grow: of a position [m/s], of a velocity [m/s²].
constexpr double kMissedVelocity = 0.5;
constexpr double kMissedForce = 1;
constexpr double kSuspicion =
    10;  // s after a gap or a readmission in which the filter is taken to be wrong, and no receiver
constexpr double kShortestLapse = 0.5;  // s: such an error has grown for at least that long

double normalized(const Vector3d& z, const Matrix3d& S) { return z.dot(S.llt().solve(z)); }

bool of_position(const Linearization& lin) { return lin.observes == Block::kPosition; }

// Whether a residual is larger than an error that grew in the filter since it last used the source, `lapse` s before.
bool leaps(const Linearization& lin, const Vector3d& residual, const Matrix3d& S, double lapse, double bound) {
  const double missed = lapse * (of_position(lin) ? kMissedVelocity : kMissedForce);
  return lapse <= kRecent && normalized(residual, S + missed * missed * Matrix3d::Identity()) > bound;
}

// Covariance of the change in one second of a residual that errors of the filter make: by an error in velocity for a
// position, by a tilt for a velocity.
Matrix3d own_change(const Linearization& lin, const Estimate& x, const Covariance& P) {
  if (of_position(lin)) {
    const Eigen::Matrix<double, 3, 9> velocity = ordinary_from_invariant(x).middleRows<3>(3);
    return velocity * P.topLeftCorner<9, 9>() * velocity.transpose();
  }
  return kStandardGravity * kStandardGravity * P.block<3, 3>(6, 6).trace() * Matrix3d::Identity();
}

}  // namespace

Trust::Trust(const std::vector<MeasurementSource>& sources, Limits limits) : limits_(limits), sources_(sources.size()) {
  for (std::size_t i = 0; i < sources.size(); ++i) {
    sources_[i].partner = sources[i].partner;
    sources_[i].readmitted = sources[i].readmitted;
  }
}

void Trust::suspect_filter(double time) { accuses_from_ = std::max(accuses_from_, time + kSuspicion); }

// The velocity of a receiver for its position and the other way round; null for other sources.
const Trust::Source* Trust::partner_of(const Source& s) const {
  return s.partner < 0 ? nullptr : &sources_[static_cast<std::size_t>(s.partner)];
}

// At the first residual outside the gate: whether the receiver is wrong. It is if the residual jumps, if its other
// source jumped, or if only its position disagrees.
bool Trust::receiver_jumped(const Source& s, double time, const Linearization& lin, const Update& u,
                            double bound) const {
  const Source* const partner = partner_of(s);
  const double lapse = time - s.believed;
  if (!partner || lapse > kRecent || time < accuses_from_) return false;
  if (leaps(lin, u.residual, u.S, lapse, bound)) return true;
  if (partner->dispute != Dispute::kNone) return partner->jumped();
  return of_position(lin) && time - partner->believed < kRecent;
}

void Trust::begin_dispute(Source& s, double time, const Linearization& lin, const Update& u, double bound) {
  s.dispute = receiver_jumped(s, time, lin, u, bound) ? Dispute::kSlightJump : Dispute::kFilter;
  s.since = time;
  s.first_S = s.spread = u.S;
  s.offset = s.residual = u.residual;
  s.R = u.R;
}

// Whether a receiver that jumped has come back. As the covariance grows, a false fix may come to lie within the gate.
// So after the first moments it is required that the receiver's jumps, which are changes too sudden for an error of the
// filter, add up to zero.
bool Trust::jumps_add_up_to_none(Source& s, double time, const Linearization& lin, const Update& u, double bound,
                                 const Estimate& x, const Covariance& P) {
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
         (time - s.since < kRecent && normalized(u.residual, s.first_S) <= bound);
}

bool Trust::is_patient(const Source& s, double time) const {
  if (!s.readmitted) return true;
  if (!s.jumped()) return s.rejected <= limits_.readmit_after;
  return time - s.since < (s.dispute == Dispute::kSlightJump ? kSlightPatience : limits_.distrust);
}

Trust::Ruling Trust::rule(int source, double time, const Linearization& lin, const Update& u, double bound,
                          const Estimate& x, const Covariance& P) {
  Source& s = sources_[static_cast<std::size_t>(source)];
  const bool inside = u.nis <= bound;
  if (s.jumped() && time - s.time > kRecent) {  // jumps during an outage were not seen
    s.dispute = Dispute::kFilter;
    s.rejected = 1;
  }
  bool believed = inside;
  if (s.dispute == Dispute::kNone) {
    if (!inside) begin_dispute(s, time, lin, u, bound);
  } else if (s.jumped()) {
    believed = jumps_add_up_to_none(s, time, lin, u, bound, x, P) && inside;
  }
  if (s.dispute == Dispute::kSlightJump) {
    const Source* const partner = partner_of(s);
    if (u.residual.norm() >= kSlight || (partner && partner->dispute == Dispute::kJump)) {
      s.dispute = Dispute::kJump;
    } else {
      believed = inside;
    }
  }
  s.time = time;

  Ruling ruling{.lapse = std::max(time - s.believed, kShortestLapse)};
  if (!believed) {
    ++s.rejected;
    if (is_patient(s, time)) {
      ruling.outcome = inside ? Outcome::kDisputed : Outcome::kRejected;
      return ruling;
    }
    if (s.dispute == Dispute::kSlightJump) s.dispute = Dispute::kFilter;
    if (!inside) {
      ruling.outcome = Outcome::kReadmitted;
      ruling.parted = s.jumped() || leaps(lin, s.offset, s.first_S, s.since - s.believed, bound);
      // If the start was wrong, this says nothing about what follows.
      if (!s.jumped() && s.partner >= 0 && std::isfinite(ruling.lapse)) suspect_filter(time);
    }
  }
  s.believed = time;
  s.rejected = 0;
  s.dispute = Dispute::kNone;
  return ruling;
}

}  // namespace piste
