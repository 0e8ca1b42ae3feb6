#include "report/findings_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "piste/core/state_table.h"

namespace piste {
namespace {

std::string interval_text(const char* name, const std::optional<Interval>& phase) {
  return phase ? fmt::format("{} {:.1f} to {:.1f} s", name, phase->start, phase->end) : fmt::format("no {}", name);
}

// Value and total sigma with as many decimals as are significant.
std::string term_text(const std::optional<Term>& t, double factor) {
  if (!t) return "-";
  const double sigma = factor * t->total();
  const int decimals = sigma > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 9) : 6;
  return fmt::format("{:.{}f} ± {:.{}f}", factor * t->value, decimals, sigma, decimals);
}

TextTable matrix_rows(std::string_view triad, const MatrixFit& fit, Block bias_block, Block scale_block) {
  const BlockInfo &bias = info(bias_block), &scale = info(scale_block);
  std::vector<std::string> head{"3x3", fmt::format("bias [{}]", bias.unit)};
  for (const std::string_view axis : bias.axes) {
    if (!axis.empty()) head.push_back(fmt::format("gain on {} [{}]", axis, scale.unit));
  }
  if (fit.has_g_sensitivity()) {
    for (const std::string_view axis : bias.axes) {
      if (!axis.empty()) head.push_back(fmt::format("on f{} [{}/(m/s^2)]", axis, bias.unit));
    }
  }
  TextTable out{head};
  for (int k = 0; k < 3; ++k) {
    std::vector<std::string> cells{fmt::format("{} {}", triad, bias.axes[static_cast<std::size_t>(k)]),
                                   term_text(fit.bias(k), bias.factor)};
    for (int of = 0; of < 3; ++of) cells.push_back(term_text(fit.gain(k, of), scale.factor));
    for (int of = 0; fit.has_g_sensitivity() && of < 3; ++of) {
      cells.push_back(term_text(fit.g_sensitivity(k, of), bias.factor));
    }
    out.push_back(std::move(cells));
  }
  return out;
}

}  // namespace

std::string phases_text(const Findings& found) {
  return fmt::format("{}, {}, {}", interval_text("rest", found.phases.before), interval_text("run", found.phases.run),
                     interval_text("rest", found.phases.after));
}

TextTable findings_by_axis(const Findings& found) {
  TextTable out{{"axis", "at rest before", "change until after", "run: bias only", "run: bias", "run: scale [ppm]",
                 "from the other side", "both noisy", "correlation", "order"}};
  for (const AxisFindings& a : found.axes) {
    const BlockInfo &bias = info(a.bias_block), &scale = info(a.scale_block);
    std::vector<std::string> cells{fmt::format("{} {}", a.name, bias.unit), term_text(a.before, bias.factor),
                                   term_text(a.change, bias.factor)};
    if (const auto& r = a.run) {
      cells.insert(
          cells.end(),
          {term_text(r->bias_only, bias.factor), term_text(r->joint.reverse.bias(), bias.factor),
           term_text(r->joint.reverse.scale(), scale.factor), term_text(r->joint.forward.scale(), scale.factor),
           term_text(r->both_noisy.scale(), scale.factor), fmt::format("{:.2f}", r->joint.reverse.correlation()),
           r->polynomial ? fmt::format("{}", r->polynomial->order) : "-"});
    }
    out.push_back(std::move(cells));
  }
  return out;
}

std::vector<TextTable> findings_by_triad(const Findings& found) {
  std::vector<TextTable> out;
  if (const auto& fit = found.accel_matrix)
    out.push_back(matrix_rows("accel", *fit, Block::kAccelBias, Block::kAccelScale));
  if (const auto& fit = found.gyro_matrix)
    out.push_back(matrix_rows("gyro", *fit, Block::kGyroBias, Block::kGyroScale));
  return out;
}

}  // namespace piste
