// The verdict on an ensemble, in one sentence.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "consistency/report_numbers.h"
#include "piste/consistency/consistency.h"

namespace piste {

std::string consistency_verdict(const ConsistencyReport& report) {
  if (report.consistent()) {
    return fmt::format("Consistent: over {} runs, under way, the NEES of every group is 1 within its bounds ({}).",
                       report.runs, percent(report.probability));
  }
  std::vector<std::string> reasons;
  constexpr auto kSeen = static_cast<std::size_t>(Phase::kUnderWay);
  for (const auto& [name, estimator] : {std::pair{"filter", &report.filter}, {"smoother", &report.smoother}}) {
    if (estimator->groups[kSeen].empty()) reasons.push_back(fmt::format("the {} was not seen under way", name));
  }
  constexpr std::size_t kNamed = 6;
  auto outside = report.outside();
  if (!outside.empty()) {
    const std::size_t more = outside.size() - std::min(outside.size(), kNamed);
    outside.resize(outside.size() - more);
    if (more > 0) outside.back() += fmt::format(" and {} more", more);
    reasons.push_back(fmt::format("over {} runs, under way, the NEES of {} is not 1 ({})", report.runs,
                                  fmt::join(outside, ", "), percent(report.probability)));
  }
  if (!report.failures.empty()) {
    reasons.push_back(fmt::format("{} of {} runs failed", report.failures.size(),
                                  report.failures.size() + static_cast<std::size_t>(report.runs)));
  }
  return fmt::format("Not consistent: {}.", fmt::join(reasons, "; "));
}

}  // namespace piste
