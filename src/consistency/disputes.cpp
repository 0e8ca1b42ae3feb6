#include "piste/consistency/disputes.h"

#include <fmt/format.h>

#include <optional>

namespace piste {

std::vector<Dispute> disputes_of(const Solution& solution, double shortest) {
  std::vector<Dispute> found;
  std::vector<std::optional<Dispute>> open(solution.sources.size());
  const auto close = [&](std::optional<Dispute>& dispute, bool believed) {
    if (dispute && dispute->during.end - dispute->during.start >= shortest) {
      dispute->believed = believed;
      found.push_back(*dispute);
    }
    dispute.reset();
  };
  for (const Innovation& v : solution.innovations) {
    std::optional<Dispute>& dispute = open[static_cast<std::size_t>(v.source)];
    if (was_used(v.outcome)) {
      close(dispute, v.outcome == Outcome::kReadmitted);
      continue;
    }
    if (!dispute) dispute = Dispute{.source = v.source, .during = {v.time, v.time}};
    dispute->during.end = v.time;
    ++dispute->fixes;
    if (dispute->size == 0 && v.outcome == Outcome::kRejected) dispute->size = v.residual.head(v.dof).norm();
    dispute->repeated = dispute->repeated || v.outcome == Outcome::kRepeated;
  }
  for (std::optional<Dispute>& dispute : open) close(dispute, false);
  return found;
}

std::string text_of(const Dispute& d, const Solution& solution) {
  const std::string& source = solution.sources[static_cast<std::size_t>(d.source)];
  const std::string_view unit = source.ends_with("position")                                  ? "m"
                                : source.ends_with("velocity") && !source.starts_with("rest") ? "m/s"
                                                                                              : "";
  std::string what = d.repeated ? " repeated its last fix" : " contradicted the rest";
  if (d.size > 0 && !unit.empty()) what += fmt::format(", by {:.3g} {} at first", d.size, unit);
  return fmt::format("{}{}: {} fixes from {:.3f} s, over {:.1f} s, were left out{}", source, what, d.fixes,
                     d.during.start, d.during.end - d.during.start,
                     d.believed ? "; after that it was believed, and what came before is less sure than it says" : "");
}

}  // namespace piste
