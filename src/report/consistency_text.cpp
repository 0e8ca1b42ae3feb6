#include "piste/report/consistency_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <vector>

#include "consistency/report_numbers.h"
#include "piste/core/state_table.h"

namespace piste {
namespace {

constexpr std::array kNavigation{Block::kPosition, Block::kVelocity, Block::kAttitude};

// Pads a number without a *, so that numbers are aligned.
std::string aligned(const std::string& text) { return text.ends_with('*') ? text : text + ' '; }

}  // namespace

std::string consistency_text(const ConsistencyReport& report) {
  std::string out = consistency_verdict(report) + "\n";
  const auto line = [&out](const std::string& name, const std::string& filter, const std::string& smoother,
                           const std::string& rest) {
    std::string text = fmt::format("{:22} {:>9} {:>9}   {}", name, aligned(filter), aligned(smoother), rest);
    text.erase(text.find_last_not_of(' ') + 1);
    out += text + "\n";
  };
  out += "\n";
  line("NEES per state", "filter", "smoother", percent(report.probability) + " band");
  for (std::size_t g = 0; g < report.groups.size(); ++g) {
    line("  " + report.groups[g].name, nees_text(report.filter, g), nees_text(report.smoother, g),
         band_text(report.bands[g]));
  }
  out += "\n";
  line("RMSE over its bound", "filter", "smoother", "");
  for (const Block block : kNavigation) {
    line(fmt::format("  {}", info(block).name), ratio_text(report, report.filter, block),
         ratio_text(report, report.smoother, block), "");
  }
  if (!report.sources.empty()) {
    out += "\n";
    line("NIS per row", "mean", "rejected", "band; correlation of successive ones");
  }
  for (const SourceConsistency& s : report.sources) {
    const std::vector<double> axes(s.autocorrelation.begin(), s.autocorrelation.begin() + s.dof);
    line("  " + s.name, starred(s.nis, s.test), fmt::format("{}", s.rejected),
         fmt::format("{}; {:.3f}{}, band ± {:.3f}", band_text(s.band), fmt::join(axes, " "), s.white() ? "" : "*",
                     s.autocorrelation_band));
  }
  if (report.heading.runs > 0) {
    out += fmt::format("\nHeading {:.4g} s after the departure, at worst: {}\n", report.heading.time,
                       heading_text(report.heading));
  }
  return out;
}

}  // namespace piste
