#include "piste/solve/trust.h"

#include <algorithm>
#include <cmath>

namespace piste {
namespace {

constexpr double kRecent = 2;            // s between fixes over which a jump can be told
constexpr double kSlight = 1;            // m or m/s: less is not worth coasting for
constexpr double kSlightPatience = 3;    // s in which it may come to more
constexpr double kMissedVelocity = 0.5;  // m/s that a filter may be wrong by unawares, as a position shows it,
constexpr double kMissedForce = 1;       // m/s², as a velocity shows it
constexpr double kSuspicion = 10;       // s after a gap or a readmission in which the filter, and no receiver, is wrong
constexpr double kShortestLapse = 0.5;  // s over which an error that the filter missed may have grown

double normalized(const Vector3d& z, const Matrix3d& S) { return z.dot(S.llt().solve(z)); }

bool of_position(const Linearization& lin) { return lin.observes == Block::kPosition; }

// Whether a residual is more than a filter can have gone wrong by since it believed the source, `lapse` s before.
bool leaps(const Linearization& lin, const Vector3d& residual, const Matrix3d& S, double lapse, double bound) {
  const double missed = lapse * (of_position(lin) ? kMissedVelocity : kMissedForce);
  return lapse <= kRecent && normalized(residual, S + missed * missed * Matrix3d::Identity()) > bound;
}

// Covariance by which the filter's own residual may change in a second: its velocity's, or a tilt's force.
Matrix3d own_change(const Linearization& lin, const Estimate& x, const Covariance& P) {
  if (of_position(lin)) {
    const Eigen::Matrix<double, 3, 9> velocity = ordinary_from_invariant(x).middleRows<3>(3);
    return velocity * P.topLeftCorner<9, 9>() * velocity.transpose();
  }
  return kStandardGravity * kStandardGravity * P.block<3, 3>(6, 6).trace() * Matrix3d::Identity();
}

}  // namespace

Trust::Trust(Sources sources, Limits limits)
    : places_(sources),
      limits_(limits),
      sources_(static_cast<std::size_t>(sources.count)),
      last_fix_(static_cast<std::size_t>(sources.receivers / 2)) {}

bool Trust::repeats(int receiver, const GnssFix& fix) {
  std::optional<GnssFix>& last = last_fix_[static_cast<std::size_t>(receiver)];
  const bool same = last && last->position == fix.position && last->velocity.has_value() == fix.velocity.has_value() &&
                    (!fix.velocity || last->velocity->value == fix.velocity->value);
  last = fix;
  return same;
}

void Trust::suspect_filter(double time) { accuses_from_ = std::max(accuses_from_, time + kSuspicion); }

// Velocity for the position of a receiver and the other way round; null for what is not a receiver's.
const Trust::Source* Trust::other(int source) const {
  return source < places_.receivers ? &sources_[static_cast<std::size_t>(source ^ 1)] : nullptr;
}

// Whose a residual outside the gate is, at the first one: the receiver's where it leaps, where its other source jumped,
// or where only its position disagrees.
bool Trust::receiver_jumped(int source, double time, const Linearization& lin, const Update& u, double bound) const {
  const Source* const neighbour = other(source);
  const double lapse = time - sources_[static_cast<std::size_t>(source)].believed;
  if (!neighbour || lapse > kRecent || time < accuses_from_) return false;
  if (leaps(lin, u.residual, u.S, lapse, bound)) return true;
  if (neighbour->rejected > 0) return neighbour->sudden;
  return of_position(lin) && time - neighbour->believed < kRecent;
}

void Trust::begin_dispute(int source, double time, const Linearization& lin, const Update& u, double bound) {
  Source& s = sources_[static_cast<std::size_t>(source)];
  s.sudden = receiver_jumped(source, time, lin, u, bound);
  s.slight = s.sudden;
  s.since = time;
  s.first_S = s.spread = u.S;
  s.offset = s.residual = u.residual;
  s.R = u.R;
}

bool Trust::is_patient(int source, double time) const {
  const Source& s = sources_[static_cast<std::size_t>(source)];
  if (source >= places_.rest) return true;
  if (!s.sudden) return s.rejected <= limits_.readmit_after;
  return time - s.since < (s.slight ? kSlightPatience : limits_.distrust);
}

Trust::Ruling Trust::rule(int source, double time, const Linearization& lin, const Update& u, double bound,
                          const Estimate& x, const Covariance& P) {
  Source& s = sources_[static_cast<std::size_t>(source)];
  const bool inside = u.nis <= bound;
  if (s.sudden && s.rejected > 0 && time - s.time > kRecent) {  // jumps over an outage are not seen
    s.sudden = false;
    s.rejected = 1;
  }
  if (s.rejected == 0 && !inside) begin_dispute(source, time, lin, u, bound);

  bool believed = inside;
  if (s.sudden && s.rejected > 0) {
    // As the covariance grows a lie may come to lie within the gate: after a moment the receiver's jumps, too sudden
    // for the filter's own error, must also have added up to none.
    const double dt = time - s.time;
    const Vector3d change = u.residual - s.residual;
    const Matrix3d spread = u.R + s.R + dt * dt * own_change(lin, x, P);
    if (normalized(change, spread) > bound) {
      s.offset += change;
      s.spread += spread;
    }
    s.residual = u.residual;
    s.R = u.R;
    believed = inside && (normalized(s.offset, s.spread) <= bound ||
                          (time - s.since < kRecent && normalized(u.residual, s.first_S) <= bound));
  }
  if (s.slight) {
    const Source* const neighbour = other(source);
    const bool neighbour_is_not = neighbour && neighbour->rejected > 0 && neighbour->sudden && !neighbour->slight;
    s.slight = u.residual.norm() < kSlight && !neighbour_is_not;
    if (s.slight) believed = inside;
  }
  s.time = time;

  Ruling ruling{.lapse = std::max(time - s.believed, kShortestLapse)};
  if (!believed) {
    ++s.rejected;
    if (is_patient(source, time)) {
      ruling.outcome = inside ? Outcome::kDisputed : Outcome::kRejected;
      return ruling;
    }
    if (s.slight) s.sudden = false;
    if (!inside) {
      ruling.outcome = Outcome::kReadmitted;
      ruling.parted = s.sudden || leaps(lin, s.offset, s.first_S, s.since - s.believed, bound);
      // A start that was wrong says nothing of what follows.
      if (!s.sudden && other(source) && std::isfinite(ruling.lapse)) suspect_filter(time);
    }
  }
  s.believed = time;
  s.rejected = 0;
  s.slight = false;
  return ruling;
}

}  // namespace piste
