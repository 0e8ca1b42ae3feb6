#include "piste/files/consistency.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "consistency/report_numbers.h"
#include "io/json.h"
#include "piste/math/units.h"

namespace piste {
namespace {

std::string pair_json(double first, double second) { return json::numbers(std::array{first, second}); }

// ---- consistency.json ----

std::string group_json(const StateGroup& group, const GroupConsistency& found, const Band& band) {
  return json::object({{"dof", fmt::format("{}", group.rows.size())},
                       {"nees", json::number(found.nees)},
                       {"standard_error", json::number(found.standard_error)},
                       {"band", pair_json(band.low, band.high)},
                       {"inside", json::boolean(found.test.holds)},
                       {"p_value", json::number(found.test.p_value)},
                       {"outside_epochs", json::number(found.outside)},
                       {"coverage", json::numbers(found.coverage)},
                       {"largest_sigmas", json::number(found.largest)},
                       {"largest_seed", fmt::format("{}", found.largest_seed)}});
}

std::string block_json(const BlockInfo& block, const BlockAccuracy& found) {
  return json::object({{"unit", json::string(block.unit)},
                       {"rmse", json::number(block.factor * found.rmse)},
                       {"bound", json::number(block.factor * found.bound)},
                       {"claimed", json::number(block.factor * found.claimed)},
                       {"ratio", json::number(found.ratio)},
                       {"ratio_standard_error", json::number(found.standard_error)}});
}

std::string estimator_json(const ConsistencyReport& report, const EstimatorConsistency& estimator) {
  json::Members phases;
  for (std::size_t p = 0; p < kPhaseNames.size(); ++p) {
    json::Members groups, blocks;
    for (std::size_t g = 0; g < estimator.groups[p].size(); ++g) {
      groups.emplace_back(report.groups[g].name, group_json(report.groups[g], estimator.groups[p][g], report.bands[g]));
    }
    for (std::size_t b = 0; b < estimator.blocks[p].size(); ++b) {
      const BlockInfo& block = info(report.layout.blocks()[b]);
      blocks.emplace_back(block.name, block_json(block, estimator.blocks[p][b]));
    }
    const json::Members both{{"groups", json::object(groups, 3)}, {"blocks", json::object(blocks, 3)}};
    phases.emplace_back(kPhaseNames[p], groups.empty() ? "null" : json::object(both, 2));
  }
  return json::object(phases, 1);
}

std::string series_json(const ConsistencyReport& report, const EstimatorConsistency& estimator) {
  constexpr int kDigits = 6;
  json::Members nees, rmse, bound, claimed;
  for (std::size_t g = 0; g < estimator.nees.size(); ++g) {
    nees.emplace_back(report.groups[g].name, json::numbers(estimator.nees[g], kDigits));
  }
  for (std::size_t b = 0; b < estimator.accuracy.size(); ++b) {
    const BlockInfo& block = info(report.layout.blocks()[b]);
    const auto add = [&](json::Members& members, double BlockAccuracy::*term) {
      std::vector<double> values;
      for (const BlockAccuracy& at : estimator.accuracy[b]) values.push_back(block.factor * at.*term);
      members.emplace_back(block.name, json::numbers(values, kDigits));
    };
    add(rmse, &BlockAccuracy::rmse);
    add(bound, &BlockAccuracy::bound);
    add(claimed, &BlockAccuracy::claimed);
  }
  return json::object({{"nees", json::object(nees, 3)},
                       {"rmse", json::object(rmse, 3)},
                       {"bound", json::object(bound, 3)},
                       {"claimed", json::object(claimed, 3)}},
                      2);
}

std::string source_json(const SourceConsistency& source) {
  const std::vector<double> axes(source.autocorrelation.begin(), source.autocorrelation.begin() + source.dof);
  return json::object({{"dof", fmt::format("{}", source.dof)},
                       {"count", json::number(source.count)},
                       {"rejected", json::number(source.rejected)},
                       {"nis", json::number(source.nis)},
                       {"band", pair_json(source.band.low, source.band.high)},
                       {"inside", json::boolean(source.test.holds)},
                       {"standard_error", json::number(source.standard_error)},
                       {"p_value", json::number(source.test.p_value)},
                       {"autocorrelation", json::numbers(axes)},
                       {"autocorrelation_band", json::number(source.autocorrelation_band)}});
}

std::string heading_json(const HeadingFound& heading) {
  if (heading.runs == 0) return "null";
  return json::object({{"time_s", json::number(heading.time)},
                       {"runs", json::number(heading.runs)},
                       {"unit", json::string("deg")},
                       {"rmse", json::number(kDegreesPerRadian * heading.rmse)},
                       {"largest_error", json::number(kDegreesPerRadian * heading.largest)},
                       {"largest_sigma", json::number(kDegreesPerRadian * heading.largest_sigma)},
                       {"largest_in_sigmas", json::number(heading.largest_ratio)}});
}

// ---- Markdown ----

// Columns of the table of ensembles, and their widths in a terminal.
struct Column {
  std::string_view head;
  int width;
};
constexpr std::array<Column, 11> kColumns{{{"scenario", 24},
                                           {"runs", 5},
                                           {"NEES filter", 11},
                                           {"smoother", 8},
                                           {"band", 14},
                                           {"groups outside", 14},
                                           {"RMSE/bound: attitude", 20},
                                           {"velocity", 13},
                                           {"position", 13},
                                           {"heading at 5 s", 22},
                                           {"NIS", 3}}};

std::string row(const std::array<std::string, kColumns.size()>& cells) {
  std::string out;
  for (std::size_t i = 0; i < cells.size(); ++i) out += fmt::format("| {:{}} ", cells[i], kColumns[i].width);
  return out + "|\n";
}

}  // namespace

std::string consistency_json(const ConsistencyReport& report, const std::string& title) {
  std::vector<std::string> failures;
  for (const FailedRun& f : report.failures) {
    failures.push_back(json::object({{"seed", fmt::format("{}", f.seed)}, {"what", json::string(f.what)}}));
  }
  json::Members phases, nis;
  for (std::size_t p = 0; p < kPhaseNames.size(); ++p) {
    const auto interval = report.grid.interval(static_cast<Phase>(p));
    phases.emplace_back(kPhaseNames[p], interval ? pair_json(interval->start, interval->end) : "null");
  }
  for (const SourceConsistency& source : report.sources) nis.emplace_back(source.name, source_json(source));
  std::vector<double> time;
  for (int epoch = report.grid.first; epoch <= report.grid.last; ++epoch) time.push_back(report.grid.time(epoch));
  return json::object({{"title", json::string(title)},
                       {"runs", fmt::format("{}", report.runs)},
                       {"failures", json::array(failures)},
                       {"probability", json::number(report.probability)},
                       {"consistent", json::boolean(report.consistent())},
                       {"phases", json::object(phases)},
                       {"filter", estimator_json(report, report.filter)},
                       {"smoother", estimator_json(report, report.smoother)},
                       {"nis", json::object(nis, 1)},
                       {"heading_found", heading_json(report.heading)},
                       {"time_series", json::object({{"time_s", json::numbers(time)},
                                                     {"filter", series_json(report, report.filter)},
                                                     {"smoother", series_json(report, report.smoother)}},
                                                    1)}},
                      0) +
         "\n";
}

std::string consistency_row_head() {
  std::array<std::string, kColumns.size()> heads, rules;
  for (std::size_t i = 0; i < heads.size(); ++i) {
    heads[i] = kColumns[i].head;
    rules[i] = std::string(static_cast<std::size_t>(kColumns[i].width), '-');
  }
  return row(heads) + row(rules);
}

std::string consistency_row(const ConsistencyReport& report, const std::string& title) {
  std::string name;
  for (const char c : title) name += c == '|' ? "\\|" : c == '\n' ? " " : std::string(1, c);
  const auto ratios = [&](Block block) {
    return ratio_text(report, report.filter, block) + " / " + ratio_text(report, report.smoother, block);
  };
  const std::size_t judged = report.filter.groups[static_cast<std::size_t>(Phase::kUnderWay)].size() +
                             report.smoother.groups[static_cast<std::size_t>(Phase::kUnderWay)].size();
  std::vector<std::string> nis;
  for (const SourceConsistency& s : report.sources) nis.push_back(fmt::format("{} {}", s.name, starred(s.nis, s.test)));
  return row({name, fmt::format("{}", report.runs), nees_text(report.filter, 0), nees_text(report.smoother, 0),
              report.bands.empty() ? "-" : band_text(report.bands.front()),
              fmt::format("{} of {}", report.outside().size(), judged), ratios(Block::kAttitude),
              ratios(Block::kVelocity), ratios(Block::kPosition), heading_text(report.heading),
              fmt::format("{}", fmt::join(nis, ", "))});
}

}  // namespace piste
