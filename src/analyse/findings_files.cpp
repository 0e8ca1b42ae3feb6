#include "piste/analyse/findings_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "analyse/alignment_members.h"
#include "io/json.h"

namespace piste {
namespace {

constexpr const char* kConvention =
    "measured = (1 + scale) true + bias. `article` is the same line as a correction to add: true = (1 + scale) "
    "measured "
    "+ bias; a bias alone changes its sign";
constexpr const char* kDirections =
    "reverse: the IMU regressed on the reference; forward: the reference on the IMU, inverted. Where both are noisy "
    "the "
    "truth lies between";

std::string interval_json(const std::optional<Interval>& phase) {
  return phase ? json::numbers(std::array{phase->start, phase->end}, 12) : "null";
}

std::string term_json(const Term& t, double factor) {
  return json::object({{"value", json::number(factor * t.value)},
                       {"sigma", json::number(factor * t.sigma)},
                       {"standard_error", json::number(factor * t.standard_error)},
                       {"systematic", json::number(factor * t.systematic)},
                       {"dof", json::number(t.dof, 6)},
                       {"p_value", json::number(t.p_value(), 6)}});
}

std::string term_json(const std::optional<Term>& t, double factor) { return t ? term_json(*t, factor) : "null"; }

// A line of one axis, four deep.
std::string line_json(const BiasScale& line, double bias_factor, double scale_factor) {
  const BiasScale article = correction(line);
  return json::object({{"bias", term_json(line.bias(), bias_factor)},
                       {"scale", term_json(line.scale(), scale_factor)},
                       {"correlation", json::number(line.correlation(), 6)},
                       {"inflation", json::number(line.inflation(), 6)},
                       {"article", json::object({{"bias", json::number(bias_factor * article.value(0))},
                                                 {"scale", json::number(scale_factor * article.value(1))}})}},
                      5);
}

std::string both_json(const BothDirections& both, double bias_factor, double scale_factor) {
  return json::object({{"reverse", line_json(both.reverse, bias_factor, scale_factor)},
                       {"forward", line_json(both.forward, bias_factor, scale_factor)}},
                      4);
}

std::string axis_json(const AxisFindings& a) {
  const BlockInfo &bias = info(a.bias_block), &scale = info(a.scale_block);
  std::string run = "null";
  if (const auto& r = a.run) {
    run = json::object({{"samples", fmt::format("{}", r->samples)},
                        {"reference_mean", json::number(bias.factor * r->mean)},
                        {"reference_rms", json::number(bias.factor * r->rms)},
                        {"residual_rms", json::number(bias.factor * r->residual)},
                        {"bias_only", term_json(r->bias_only, bias.factor)},
                        {"scale_only", r->scale_only ? both_json(*r->scale_only, bias.factor, scale.factor) : "null"},
                        {"joint", both_json(r->joint, bias.factor, scale.factor)}},
                       3);
  }
  return json::object({{"unit", json::string(bias.unit)},
                       {"scale_unit", json::string(scale.unit)},
                       {"rest", json::object({{"before", term_json(a.before, bias.factor)},
                                              {"after", term_json(a.after, bias.factor)},
                                              {"change", term_json(a.change, bias.factor)}},
                                             3)},
                       {"run", run}},
                      2);
}

// ---- Text ----

std::string interval_text(const char* name, const std::optional<Interval>& phase) {
  return phase ? fmt::format("{} {:.1f} to {:.1f} s", name, phase->start, phase->end) : fmt::format("no {}", name);
}

// Value and total sigma, with the decimals that this sigma is worth.
std::string term_text(const std::optional<Term>& t, double factor) {
  if (!t) return "-";
  const double sigma = factor * t->total();
  const int decimals = sigma > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 9) : 6;
  return fmt::format("{:.{}f} ± {:.{}f}", factor * t->value, decimals, sigma, decimals);
}

using Cells = std::array<std::string, 8>;

std::string row(const Cells& cells) {
  std::string out;
  for (std::size_t i = 0; i < cells.size(); ++i) out += fmt::format("{:<{}}", cells[i], i == 0 ? 10 : 23);
  out.erase(out.find_last_not_of(' ') + 1);
  return out + "\n";
}

}  // namespace

std::string findings_json(const Findings& found, const Alignment& alignment) {
  json::Members members = alignment_members(alignment), axes;
  for (const AxisFindings& a : found.axes) axes.emplace_back(a.name, axis_json(a));
  members.emplace_back("convention", json::string(kConvention));
  members.emplace_back("directions", json::string(kDirections));
  members.emplace_back("low_pass_hz", json::number(found.low_pass));
  members.emplace_back("phases", json::object({{"before", interval_json(found.phases.before)},
                                               {"run", interval_json(found.phases.run)},
                                               {"after", interval_json(found.phases.after)}}));
  members.emplace_back("axes", json::object(axes, 1));
  return json::object(members, 0) + "\n";
}

std::string findings_text(const Findings& found) {
  std::string out = fmt::format("{}, {}, {}\n", interval_text("rest", found.phases.before),
                                interval_text("run", found.phases.run), interval_text("rest", found.phases.after));
  out += row({"axis", "at rest before", "change until after", "run: bias only", "run: bias", "run: scale [ppm]",
              "from the other side", "correlation"});
  for (const AxisFindings& a : found.axes) {
    const BlockInfo &bias = info(a.bias_block), &scale = info(a.scale_block);
    Cells cells{fmt::format("{} {}", a.name, bias.unit), term_text(a.before, bias.factor),
                term_text(a.change, bias.factor)};
    if (const auto& r = a.run) {
      cells[3] = term_text(r->bias_only, bias.factor);
      cells[4] = term_text(r->joint.reverse.bias(), bias.factor);
      cells[5] = term_text(r->joint.reverse.scale(), scale.factor);
      cells[6] = term_text(r->joint.forward.scale(), scale.factor);
      cells[7] = fmt::format("{:.2f}", r->joint.reverse.correlation());
    }
    out += row(cells);
  }
  return out;
}

}  // namespace piste
