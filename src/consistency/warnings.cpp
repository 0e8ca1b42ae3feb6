#include "piste/consistency/warnings.h"

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

}  // namespace piste
