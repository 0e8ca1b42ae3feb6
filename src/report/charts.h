#pragma once
/// The charts of a report as data: columns of numbers, thinned, that report.js draws.

#include <string>
#include <string_view>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste::charts {

/// One curve, and its 1-sigma band where `sigma` is not empty.
struct Curve {
  std::string label;
  std::vector<double> value, sigma = {};
};

/// Curves over a common time, seconds after the first epoch. NaN breaks a curve.
struct Chart {
  std::string title, unit;
  std::vector<double> time;
  std::vector<Curve> curves;
  bool points = false;     ///< dots instead of lines
  bool log_scale = false;  ///< of the values
};

/// Everything over time that one solution tells: speed, height, attitude, estimated blocks, sigmas.
std::vector<Chart> of_solution(const Solution& solution, double start);

/// Two charts a source: residuals over their sigmas, and NIS against its gate.
std::vector<Chart> of_innovations(const Solution& solution, double start);

/// JSON of a chart with at most about `limit` rows.
std::string json(const Chart& chart, std::size_t limit);

}  // namespace piste::charts
