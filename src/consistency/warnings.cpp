#include "piste/consistency/warnings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "piste/consistency/disputes.h"

namespace piste {

std::vector<std::string> warnings_of(const Solution& filtered) {
  constexpr std::size_t kMost = 5;
  struct Rest {
    std::size_t disputes = 0, fixes = 0;
    double end = 0;
  };
  std::vector<std::string> warnings;
  std::vector<Rest> of_source(filtered.sources.size());
  for (const Dispute& dispute : disputes_of(filtered)) {
    const auto source = static_cast<std::size_t>(dispute.source);
    if (!filtered.sources[source].starts_with("gnss")) continue;
    Rest& all = of_source[source];
    if (++all.disputes <= kMost) {
      warnings.push_back(text_of(dispute, filtered));
    } else {
      all.fixes += dispute.fixes;
      all.end = dispute.during.end;
    }
  }
  for (std::size_t source = 0; source < of_source.size(); ++source) {
    const Rest& all = of_source[source];
    if (all.disputes <= kMost) continue;
    warnings.push_back(fmt::format("{} was left out {} more times until {:.3f} s, {} fixes in all of them",
                                   filtered.sources[source], all.disputes - kMost, all.end, all.fixes));
  }
  return warnings;
}

std::string_view name_of(ImuFault fault) {
  switch (fault) {
    case ImuFault::kClipped:
      return "clipped";
    case ImuFault::kStuck:
      return "stuck";
    case ImuFault::kSpike:
      return "spike";
    case ImuFault::kSilent:
      return "silent";
    case ImuFault::kBiased:
      return "biased";
  }
  return "";
}

std::vector<std::string> absence_lines(const std::vector<ImuReport>& imus) {
  std::vector<std::string> lines;
  for (const ImuReport& unit : imus) {
    if (unit.absences.empty()) continue;
    std::vector<std::string> parts;
    for (const ImuFault fault :
         {ImuFault::kClipped, ImuFault::kStuck, ImuFault::kSpike, ImuFault::kSilent, ImuFault::kBiased}) {
      const auto is_it = [&](const ImuAbsence& a) { return a.fault == fault; };
      const auto times = std::ranges::count_if(unit.absences, is_it);
      if (times == 0) continue;
      const Interval& first = std::ranges::find_if(unit.absences, is_it)->time;
      parts.push_back(fmt::format("{} {}, first from {:.3f} to {:.3f} s", name_of(fault),
                                  times == 1 ? "once" : fmt::format("{} times", times), first.start, first.end));
    }
    lines.push_back(
        fmt::format("IMU {} was left out in {} epochs: {}", unit.name, unit.left_out, fmt::join(parts, "; ")));
  }
  return lines;
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
