#include "walker/own_times.h"

#include <optional>

#include "core/time_search.h"

namespace piste {
namespace {

constexpr double kFarApart = 2.5;  // s: largest time between two fixes that are interpolated

// Velocity at the time t, interpolated between the fixes around it.
std::optional<FixVelocity> velocity_at(const std::vector<GnssFix>& fixes, double t) {
  const auto after = first_at_or_after(fixes, t);
  if (after == fixes.end() || !after->velocity) return std::nullopt;
  if (after->time == t) return after->velocity;
  if (after == fixes.begin()) return std::nullopt;
  const auto before = after - 1;
  const double apart = after->time - before->time;
  if (!before->velocity || apart > kFarApart) return std::nullopt;
  const double part = (t - before->time) / apart;
  return FixVelocity{(1 - part) * before->velocity->value + part * after->velocity->value,
                     before->velocity->sigma.cwiseMax(after->velocity->sigma)};
}

}  // namespace

std::vector<GnssFix> at_own_times(std::vector<GnssFix> fixes, const GnssOptions& receiver) {
  const double delay = receiver.use_position ? receiver.delay : receiver.delay_of_velocity();
  const double apart = receiver.delay_of_velocity() - delay;
  if (apart != 0) {
    const std::vector<GnssFix> as_given = fixes;
    for (GnssFix& fix : fixes) fix.velocity = velocity_at(as_given, fix.time + apart);
  }
  for (GnssFix& fix : fixes) fix.time -= delay;
  return fixes;
}

std::vector<AttitudeFix> at_own_times(std::vector<AttitudeFix> fixes, const AttitudeOptions& reference) {
  for (AttitudeFix& fix : fixes) fix.time -= reference.delay;
  return fixes;
}

}  // namespace piste
