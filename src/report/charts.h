#pragma once
/// The charts of a report as data: thinned columns of numbers, which report.js draws.

#include <string>
#include <string_view>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste::charts {

/// One curve, and its 1-sigma band if `sigma` is not empty.
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

/// The charts of a solution over time: speed, height, roll, pitch, heading, estimated blocks, sigmas.
std::vector<Chart> of_solution(const Solution& solution, double start);

/// Two charts for each source: residuals divided by their sigmas, and NIS with its gate. As above, an empty chart is
/// left out. A chart of the noise that an adapting filter estimated comes first.
std::vector<Chart> of_innovations(const Solution& solution, double start);

/// JSON of a chart with about `limit` rows: of lines the extremes, of dots a fair sample (plot/thin.h).
std::string json(const Chart& chart, std::size_t limit);

}  // namespace piste::charts
