#include "piste/study/study_findings.h"

#include <algorithm>
#include <cmath>

namespace piste {
namespace {

double unit_of(StudyQuantity quantity, int axis) {
  return quantity == StudyQuantity::kBias ? signal_info(axis).factor : 1;
}

Term in_unit(Term term, double factor) {
  term.value *= factor;
  term.averages *= factor;
  term.effects *= factor;
  for (double* size : {&term.sigma, &term.standard_error, &term.systematic}) *size *= std::abs(factor);
  return term;
}

}  // namespace

Study of_all_as_one(const Study& study) {
  return {.name = study.name,
          .low_pass = study.low_pass,
          .simulated = study.simulated,
          .sensors = {std::string(kAsOne)},
          .runs = study.runs,
          .results = study.as_one,
          .article = {}};
}

const AxisEstimate* SensorRun::estimate(Method method, int axis) const {
  const auto found = std::ranges::find(estimates, method, &MethodEstimate::method);
  if (found == estimates.end()) return nullptr;
  const AxisEstimate& at = found->axes[static_cast<std::size_t>(axis)];
  return at.empty() ? nullptr : &at;
}

std::optional<Term> shown(const AxisEstimate& estimate, StudyQuantity quantity, int axis) {
  const double factor = unit_of(quantity, axis);
  if (estimate.line) {
    const BiasScale line = correction(*estimate.line);
    return in_unit(quantity == StudyQuantity::kBias ? line.bias() : line.scale(), factor);
  }
  if (estimate.bias_alone && quantity == StudyQuantity::kBias) return in_unit(*estimate.bias_alone, -factor);
  return std::nullopt;
}

std::optional<double> shown_truth(const AxisEstimate& estimate, StudyQuantity quantity, int axis) {
  const double factor = unit_of(quantity, axis);
  if (estimate.line) {
    if (!estimate.true_bias || !estimate.true_scale) return std::nullopt;
    const double error = quantity == StudyQuantity::kBias ? *estimate.true_bias : *estimate.true_scale;
    return -factor * error / (1 + *estimate.true_scale);
  }
  if (estimate.bias_alone && estimate.true_bias && quantity == StudyQuantity::kBias)
    return -factor * *estimate.true_bias;
  return std::nullopt;
}

}  // namespace piste
