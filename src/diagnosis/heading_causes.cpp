// Wrong headings as the cause. One is the initial heading, for which the motion yields another value. The other is the
// baseline of two antennas, which may point elsewhere than configured: the error is the median difference from a run
// without these headings.

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

#include "diagnosis/cause_support.h"
#include "math/words.h"
#include "piste/core/error.h"
#include "piste/math/so3.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/model/dual_heading.h"

namespace piste {
namespace {

// By how much the headings are larger than those of a run that does not use them, in the median; nothing where there
// are few.
std::optional<double> turned_by(FilterInput input, double end) {
  constexpr double kUnfelt = 1e3;  // rad
  constexpr std::size_t kFewestHeadings = 10;
  for (HeadingFix& fix : input.log.heading) fix.sigma = kUnfelt;
  const Evidence found = filter_again(input.log, input.options, input.start, end);
  std::vector<double> apart;
  for (const Innovation& v : found.innovations) {
    if (found.sources[static_cast<std::size_t>(v.source)] == DualHeading::kName) apart.push_back(v.residual.x());
  }
  return apart.size() < kFewestHeadings ? std::nullopt : std::optional(median(std::move(apart)));
}

Cause baseline(const InitialHeading& heading) {
  return [heading](const FilterInput& input, const Evidence& base, double end) {
    FilterInput changed = input;
    changed.log.heading.clear();
    if (!start_anew(changed, heading)) return TestedCause{};
    changed.log.heading = input.log.heading;
    const std::optional<double> by = turned_by(changed, end);
    if (!by) return TestedCause{};
    for (HeadingFix& fix : changed.log.heading) fix.heading -= *by;
    return searched(lasting_gain(filter_again(changed.log, changed.options, changed.start, end), base),
                    fmt::format("direction of `baseline` (the headings of the two antennas are {:+.2g} deg off)",
                                *by * kDegreesPerRadian));
  };
}

// The initial heading, as determined by the motion. Without this cause the verdict would name a lever arm or a noise
// that absorbs a part of the wrong heading.
TestedCause by_motion(const FilterInput& input, const Evidence& base, double end) {
  FoundStart found;
  try {
    found = find_start(input.log, input.options, {});
  } catch (const Error&) {
    return {};
  }
  if (!found.aligned) return {};
  found.start.covariance = found.start.covariance.topLeftCorner(9, 9).eval();
  const Matrix3d R_nw = input.log.world.rotation_wn(found.start.x.p_wb).transpose();
  const Quaterniond q_nb = Quaterniond(R_nw) * found.start.x.q_wb;
  const Matrix3d attitude = R_nw * found.start.covariance.block<3, 3>(6, 6) * R_nw.transpose();
  const double value = kDegreesPerRadian * to_euler(q_nb).z(),
               sigma = kDegreesPerRadian * euler_sigma(q_nb, attitude).z();
  return searched(gained(filter_again(input.log, input.options, found.start, end), base),
                  fmt::format("`initial: heading` ({} ± {} deg is likelier, as `auto` finds it from the motion)",
                              rounded(value, sigma), rounded(sigma, sigma)));
}

}  // namespace

std::vector<Cause> heading_causes(const FilterInput& input, const InitialHeading& heading) {
  std::vector<Cause> causes;
  using Source = InitialHeading::Source;
  if (heading.source == Source::kValue || heading.source == Source::kMagnetometer) causes.emplace_back(by_motion);
  if (!input.log.heading.empty()) causes.push_back(baseline(heading));
  return causes;
}

}  // namespace piste
