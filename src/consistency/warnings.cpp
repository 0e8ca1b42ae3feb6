#include "piste/consistency/warnings.h"

#include <fmt/format.h>

#include "piste/consistency/disputes.h"

namespace piste {

std::vector<std::string> warnings_of(const Solution& filtered) {
  constexpr double kTooMany = 0.2;  // of the measurements
  constexpr int kFew = 20;
  std::vector<int> all(filtered.sources.size()), rejected(filtered.sources.size());
  for (const Innovation& v : filtered.innovations) {
    const auto source = static_cast<std::size_t>(v.source);
    ++all[source];
    rejected[source] += was_used(v.outcome) ? 0 : 1;
  }
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i] < kFew || rejected[i] <= kTooMany * all[i]) continue;
    warnings.push_back(
        fmt::format("{} of {} measurements of {} were rejected, and the solution is not to be relied on; check its "
                    "units, sigmas and lever arm, and the clock and the axes of the IMU",
                    rejected[i], all[i], filtered.sources[i]));
  }
  for (const Dispute& dispute : disputes_of(filtered)) {
    if (filtered.sources[static_cast<std::size_t>(dispute.source)].starts_with("gnss"))
      warnings.push_back(text_of(dispute, filtered));
  }
  return warnings;
}

}  // namespace piste
