#include "diagnosis/doubts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "piste/core/state_table.h"
#include "piste/math/so3.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

bool suspicious(const Verdict& verdict) {
  constexpr double kUnlikely = 3, kLittle = 0.05, kPartOfBand = 0.8, kSuspicious = 0.02;
  return !verdict.consistent ||
         std::any_of(verdict.sources.begin(), verdict.sources.end(), [=](const SourceVerdict& s) {
           return s.rejected > kSuspicious || std::abs(s.nis - 1) > std::max(kLittle, kUnlikely * s.nis_error) ||
                  std::abs(s.whiteness) > kPartOfBand * s.band;
         });
}

// Whether wheels, barometer or antennas contradict the rest by more than their sigmas say. The verdict does not judge
// them, but their sigmas may be the cause.
bool aids_doubtful(const Log& log, const Solution& filtered) {
  constexpr double kTooFar = 1.5, kTooMany = 0.2;  // NIS of a row; share of rows left out
  constexpr std::size_t kFewest = 30;
  const UnderWay fixes(log, filtered.sources, filtered.time(0)),
      measured(log, filtered.sources, filtered.time(0), LookedAt::kMeasured);
  struct Sum {
    std::size_t used = 0, left_out = 0;
    double nis = 0;
  };
  std::vector<Sum> of(filtered.sources.size());
  for (const Innovation& v : filtered.innovations) {
    if (!measured.contains(v) || fixes.contains(v)) continue;
    Sum& sum = of[static_cast<std::size_t>(v.source)];
    if (was_used(v.outcome)) {
      ++sum.used;
      sum.nis += v.nis / v.dof;
    } else {
      ++sum.left_out;
    }
  }
  return std::ranges::any_of(of, [](const Sum& sum) {
    const auto all = static_cast<double>(sum.used + sum.left_out);
    return sum.used + sum.left_out >= kFewest &&
           (sum.nis > kTooFar * static_cast<double>(sum.used) || static_cast<double>(sum.left_out) > kTooMany * all);
  });
}

}  // namespace

bool doubtful(const Verdict& verdict, const Log& log, const Solution& filtered) {
  return suspicious(verdict) || aids_doubtful(log, filtered);
}

bool far_off(const Verdict& verdict) {
  constexpr double kWrong = 3, kUnused = 0.3;  // factor of the sigmas; share rejected
  return verdict.factor > kWrong || std::any_of(verdict.sources.begin(), verdict.sources.end(),
                                                [](const SourceVerdict& s) { return s.rejected > kUnused; });
}

void add_heading_jump(const InitialHeading& heading, const Solution& filtered, const Solution* smoothed,
                      Verdict& verdict) {
  constexpr double kWellKnown = 0.7;  // of the initial sigma
  using Source = InitialHeading::Source;
  if (heading.source != Source::kValue && heading.source != Source::kMagnetometer) return;
  if (smoothed == nullptr || smoothed->empty()) return;
  const double initial = filtered.sigmas(0).euler.z(), known = smoothed->sigmas(0).euler.z();
  if (!(known < kWellKnown * initial)) return;
  const auto heading_of = [](const Solution& s) {
    const Estimate x = s.estimate(0);
    return to_euler(Matrix3d(s.world().rotation_wn(x.p_wb).transpose() * x.R_wb())).z();
  };
  const double change = std::remainder(heading_of(*smoothed) - heading_of(filtered), 2 * std::numbers::pi);
  const PriorJump jump{"initial heading", change / std::sqrt(square(initial) - square(known))};
  const auto smaller = [&](const PriorJump& j) { return std::abs(j.sigmas) < std::abs(jump.sigmas); };
  verdict.jumps.insert(std::ranges::find_if(verdict.jumps, smaller), jump);
  if (std::abs(jump.sigmas) > kFarFromPrior) verdict.consistent = false;
}

std::optional<std::string> iron_that_is_none(const Verdict& verdict) {
  const auto jump = std::ranges::find_if(verdict.jumps, [](const PriorJump& j) {
    return j.name.starts_with("soft_iron") || j.name.starts_with("hard_iron");
  });
  if (jump == verdict.jumps.end() || std::abs(jump->sigmas) < kFarFromPrior) return std::nullopt;
  return fmt::format(
      "magnetometer ({} is {:.1f} sigmas from its prior; check its unit, its axes, and whether it sticks)", jump->name,
      jump->sigmas);
}

std::optional<std::string> biases_left_out(const Verdict& verdict, const FilterOptions& options) {
  if (verdict.consistent || options.estimates(Block::kGyroBias) || options.estimates(Block::kAccelBias))
    return std::nullopt;
  std::vector<std::string_view> names;
  for (const Block block : imu_error_blocks(options.sensor)) {
    if (!options.estimates(block)) names.push_back(info(block).name);
  }
  if (names.empty()) return std::nullopt;
  return fmt::format("`estimate` leaves out {}, which the sensor file says are not zero", fmt::join(names, ", "));
}

}  // namespace piste
