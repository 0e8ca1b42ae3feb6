#include "consistency/report_numbers.h"

#include <fmt/format.h>

#include "piste/core/state_table.h"

namespace piste {
namespace {

const GroupConsistency* under_way(const EstimatorConsistency& estimator, std::size_t group) {
  const auto& found = estimator.groups[static_cast<std::size_t>(Phase::kUnderWay)];
  return group < found.size() ? &found[group] : nullptr;
}

const BlockAccuracy* under_way(const ConsistencyReport& report, const EstimatorConsistency& estimator, Block block) {
  const auto& found = estimator.blocks[static_cast<std::size_t>(Phase::kUnderWay)];
  for (std::size_t b = 0; b < found.size(); ++b) {
    if (report.layout.blocks()[b] == block) return &found[b];
  }
  return nullptr;
}

}  // namespace

std::string starred(double value, const MeanTest& test) {
  return fmt::format("{:.3f}{}", value, test.holds ? "" : "*");
}

std::string band_text(const Band& band) { return fmt::format("{:.3f} to {:.3f}", band.low, band.high); }

std::string percent(double probability) { return fmt::format("{:.4g} %", 100 * probability); }

std::string nees_text(const EstimatorConsistency& estimator, std::size_t group) {
  const GroupConsistency* found = under_way(estimator, group);
  return found ? starred(found->nees, found->test) : "-";
}

std::string ratio_text(const ConsistencyReport& report, const EstimatorConsistency& estimator, Block block) {
  const BlockAccuracy* found = under_way(report, estimator, block);
  return found ? fmt::format("{:.3f}", found->ratio) : "-";
}

std::string heading_text(const HeadingFound& heading) {
  if (heading.runs == 0) return "-";
  return fmt::format("{:.2f} deg, {:.1f} sigma", kDegreesPerRadian * heading.largest, heading.largest_ratio);
}

}  // namespace piste
