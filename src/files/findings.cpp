#include "piste/files/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "files/alignment_members.h"
#include "io/json.h"

namespace piste {
namespace {

constexpr const char* kConvention =
    "measured = (1 + scale) true + bias. `article` is the same line as a correction to add: true = (1 + scale) "
    "measured "
    "+ bias; a bias alone changes its sign";
constexpr const char* kDirections =
    "reverse: the IMU regressed on the reference; forward: the reference on the IMU, inverted; both_noisy: Deming's, "
    "with noise_ratio the variance of the IMU's noise over that of the reference's. Where both are noisy the truth "
    "lies between reverse and forward";
constexpr const char* kMatrix =
    "measured = (I + gain) true + bias + g_sensitivity force, against the boresight that was found; inflation of each "
    "variance by the other columns, in the order of these members";

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

// A line of one axis, at the indentation of `depth`.
std::string line_json(const BiasScale& line, double bias_factor, double scale_factor, int depth) {
  const BiasScale article = correction(line);
  return json::object({{"bias", term_json(line.bias(), bias_factor)},
                       {"scale", term_json(line.scale(), scale_factor)},
                       {"correlation", json::number(line.correlation(), 6)},
                       {"inflation", json::number(line.inflation(), 6)},
                       {"article", json::object({{"bias", json::number(bias_factor * article.value(0))},
                                                 {"scale", json::number(scale_factor * article.value(1))}})}},
                      depth + 1);
}

std::string both_json(const BothDirections& both, double bias_factor, double scale_factor) {
  return json::object({{"reverse", line_json(both.reverse, bias_factor, scale_factor, 4)},
                       {"forward", line_json(both.forward, bias_factor, scale_factor, 4)}},
                      4);
}

std::string polynomial_json(const PolynomialFit& fit, double bias_factor, double scale_factor) {
  std::vector<std::string> terms;
  for (int j = 0; j <= fit.order; ++j) {
    terms.push_back(term_json(fit.coefficients.term(j), std::pow(bias_factor, 1 - j)));
  }
  return json::object({{"order", fmt::format("{}", fit.order)},
                       {"bic", json::numbers(fit.bic)},
                       {"effective_samples", json::number(fit.effective_samples, 6)},
                       {"coefficients", json::array(terms)},
                       {"tangent", line_json(fit.tangent, bias_factor, scale_factor, 4)}},
                      4);
}

using TermOf = Term (MatrixFit::*)(int, int) const;

std::string row_json(const MatrixFit& fit, TermOf term, int axis, double factor) {
  const auto on = [&](int of) { return term_json((fit.*term)(axis, of), factor); };
  return json::array({on(0), on(1), on(2)});
}

std::string matrix_json(const std::optional<MatrixFit>& fit, Block bias_block, Block scale_block) {
  if (!fit) return "null";
  const BlockInfo &bias = info(bias_block), &scale = info(scale_block);
  json::Members axes{{"unit", json::string(bias.unit)}, {"gain_unit", json::string(scale.unit)}};
  if (fit->has_g_sensitivity()) {
    axes.emplace_back("g_sensitivity_unit", json::string(fmt::format("{}/(m/s^2)", bias.unit)));
  }
  for (int k = 0; k < 3; ++k) {
    const Regression& found = fit->axes[static_cast<std::size_t>(k)].regression;
    json::Members members{{"residual_rms", json::number(bias.factor * found.residual)},
                          {"bias", term_json(fit->bias(k), bias.factor)},
                          {"gain", row_json(*fit, &MatrixFit::gain, k, scale.factor)}};
    if (fit->has_g_sensitivity()) {
      members.emplace_back("g_sensitivity", row_json(*fit, &MatrixFit::g_sensitivity, k, bias.factor));
    }
    members.emplace_back("correlation", json::number(fit->line(k).correlation(), 6));
    members.emplace_back("inflation", json::numbers(found.inflation, 6));
    axes.emplace_back(bias.axes[static_cast<std::size_t>(k)], json::object(members, 3));
  }
  return json::object(axes, 2);
}

std::string axis_json(const AxisFindings& a) {
  const BlockInfo &bias = info(a.bias_block), &scale = info(a.scale_block);
  std::string run = "null";
  if (const auto& r = a.run) {
    run = json::object(
        {{"samples", fmt::format("{}", r->samples)},
         {"reference_mean", json::number(bias.factor * r->mean)},
         {"reference_rms", json::number(bias.factor * r->rms)},
         {"residual_rms", json::number(bias.factor * r->residual)},
         {"bias_only", term_json(r->bias_only, bias.factor)},
         {"scale_only", r->scale_only ? both_json(*r->scale_only, bias.factor, scale.factor) : "null"},
         {"joint", both_json(r->joint, bias.factor, scale.factor)},
         {"noise_ratio", json::number(r->noise_ratio, 6)},
         {"both_noisy", line_json(r->both_noisy, bias.factor, scale.factor, 3)},
         {"polynomial", r->polynomial ? polynomial_json(*r->polynomial, bias.factor, scale.factor) : "null"}},
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
  members.emplace_back("matrix",
                       json::object({{"convention", json::string(kMatrix)},
                                     {"accel", matrix_json(found.accel_matrix, Block::kAccelBias, Block::kAccelScale)},
                                     {"gyro", matrix_json(found.gyro_matrix, Block::kGyroBias, Block::kGyroScale)}},
                                    1));
  return json::object(members, 0) + "\n";
}

}  // namespace piste
