// Headings that are told wrong, as the cause: that of the start, for which the motion finds another one, and two
// antennas whose baseline does not point where the configuration says. What motion and receiver tell without them says
// by how much.

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

#include "diagnosis/granting.h"
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
std::optional<double> turned_by(Told told, double end) {
  constexpr double kUnfelt = 1e3;  // rad
  constexpr std::size_t kFewestHeadings = 10;
  for (HeadingFix& fix : told.log.heading) fix.sigma = kUnfelt;
  const Evidence found = filter_again(told.log, told.options, told.start, end);
  std::vector<double> apart;
  for (const Innovation& v : found.innovations) {
    if (found.sources[static_cast<std::size_t>(v.source)] == DualHeading::kName) apart.push_back(v.residual.x());
  }
  return apart.size() < kFewestHeadings ? std::nullopt : std::optional(median(std::move(apart)));
}

Cause baseline(const InitialHeading& heading) {
  return [heading](const Told& told, const Evidence& base, double end) {
    Told changed = told;
    changed.log.heading.clear();
    if (!start_anew(changed, heading)) return Granted{};
    changed.log.heading = told.log.heading;
    const std::optional<double> by = turned_by(changed, end);
    if (!by) return Granted{};
    for (HeadingFix& fix : changed.log.heading) fix.heading -= *by;
    return searched(lasting_gain(filter_again(changed.log, changed.options, changed.start, end), base),
                    fmt::format("direction of `baseline` (the headings of the two antennas are {:+.2g} deg off)",
                                *by * kDegreesPerRadian));
  };
}

// The heading at the start, as the motion tells it. Without this cause a lever arm or a noise that makes up for a part
// of the wrong heading would be named.
Granted by_motion(const Told& told, const Evidence& base, double end) {
  FoundStart found;
  try {
    found = find_start(told.log, told.options, {});
  } catch (const Error&) {
    return {};
  }
  if (!found.aligned) return {};
  found.start.covariance = found.start.covariance.topLeftCorner(9, 9).eval();
  const Matrix3d R_nw = told.log.world.rotation_wn(found.start.x.p_wb).transpose();
  const Quaterniond q_nb = Quaterniond(R_nw) * found.start.x.q_wb;
  const Matrix3d attitude = R_nw * found.start.covariance.block<3, 3>(6, 6) * R_nw.transpose();
  const double value = kDegreesPerRadian * to_euler(q_nb).z(),
               sigma = kDegreesPerRadian * euler_sigma(q_nb, attitude).z();
  return searched(gained(filter_again(told.log, told.options, found.start, end), base),
                  fmt::format("`initial: heading` ({} ± {} deg is likelier, as `auto` finds it from the motion)",
                              rounded(value, sigma), rounded(sigma, sigma)));
}

}  // namespace

std::vector<Cause> heading_causes(const Told& told, const InitialHeading& heading) {
  std::vector<Cause> causes;
  using Source = InitialHeading::Source;
  if (heading.source == Source::kValue || heading.source == Source::kMagnetometer) causes.emplace_back(by_motion);
  if (!told.log.heading.empty()) causes.push_back(baseline(heading));
  return causes;
}

}  // namespace piste
