#include "piste/consistency/warnings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "piste/consistency/disputes.h"

namespace piste {

std::vector<std::string> warnings_of(const Solution& filtered) {
  std::vector<std::string> warnings;
  for (const Dispute& dispute : disputes_of(filtered)) {
    if (filtered.sources[static_cast<std::size_t>(dispute.source)].starts_with("gnss"))
      warnings.push_back(text_of(dispute, filtered));
  }
  return warnings;
}

std::string adapted_line(const AdaptedNoise& adapted) {
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < adapted.names.size(); ++k) {
    const AdaptedNoise::Range range = adapted.range(k);
    parts.push_back(
        fmt::format("{} times {:.2g} ({:.2g} to {:.2g})", adapted.names[k], range.mean, range.least, range.most));
  }
  return fmt::format("adapted sigmas: {}", fmt::join(parts, ", "));
}

std::string batch_line(const BatchSummary& batch) {
  return fmt::format(
      "batch: {} nodes, {} fixes, of which {} were left out and {} that the filter had refused were used; "
      "{} in {} rounds, {} steps",
      batch.nodes, batch.fixes, batch.left_out, batch.taken_back, batch.converged ? "converged" : "NOT CONVERGED",
      batch.rounds, batch.iterations);
}

}  // namespace piste
