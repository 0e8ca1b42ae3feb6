// Two antennas whose baseline does not point where the configuration says, as the cause: what motion and receiver tell
// of the heading without them says by how much.

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

#include "diagnosis/granting.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// By how much the headings are larger than those of a run that does not use them, in the median; nothing where there
// are few.
std::optional<double> turned_by(Told told, double end) {
  constexpr double kUnfelt = 1e3;  // rad
  constexpr std::size_t kFewestHeadings = 10;
  for (HeadingFix& fix : told.log.heading) fix.sigma = kUnfelt;
  const Evidence found = filter_again(told.log, told.options, told.start, end);
  std::vector<double> apart;
  for (const Innovation& v : found.innovations) {
    if (found.sources[static_cast<std::size_t>(v.source)] == "heading") apart.push_back(v.residual.x());
  }
  return apart.size() < kFewestHeadings ? std::nullopt : std::optional(median(std::move(apart)));
}

Cause baseline(const InitialHeading& heading) {
  return [heading](const Told& told, const Evidence& base, double end) {
    Told changed = told;
    changed.log.heading.clear();
    try {
      changed.start = find_start(changed.log, changed.options, heading).start;
    } catch (const Error&) {
      return Granted{};
    }
    changed.start.covariance = changed.start.covariance.topLeftCorner(9, 9).eval();
    changed.log.heading = told.log.heading;
    const std::optional<double> by = turned_by(changed, end);
    if (!by) return Granted{};
    for (HeadingFix& fix : changed.log.heading) fix.heading -= *by;
    return searched(gained(filter_again(changed.log, changed.options, changed.start, end), base),
                    fmt::format("direction of `baseline` (the headings of the two antennas are {:+.2g} deg off)",
                                *by * kDegreesPerRadian));
  };
}

}  // namespace

std::vector<Cause> heading_causes(const Told& told, const InitialHeading& heading) {
  if (told.log.heading.empty()) return {};
  return {baseline(heading)};
}

}  // namespace piste
