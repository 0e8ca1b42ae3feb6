#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "piste/math/statistics.h"
#include "tune/noise_search.h"

namespace piste {
namespace {

constexpr int kRounds = 8;
constexpr double kUndetermined = 2;                      // of the reach: hardly determined, and not looked at closely
constexpr double kClose = 0.03;                          // of a 1-sigma
constexpr double kLeastStretch = 0.3, kMostStretch = 3;  // of the reach, in a round

// One end of an interval: how far from the top in the logarithm, and the search for it between two places.
struct End {
  Eigen::VectorXd along;  // of all knobs, for a unit of this one
  double reach, inside = 0, outside = std::numeric_limits<double>::infinity();
  bool found = false;

  // What is `depth` below the top at `reach`, as the number of 1-sigmas of a parabola; `wanted` is that of the end.
  void judge(double depth, double wanted) {
    const double sigmas = std::sqrt(2 * std::max(depth, 0.0));
    (sigmas < wanted ? inside : outside) = reach;
    found = std::abs(sigmas - wanted) < kClose;
    if (found) return;
    const double stretch = sigmas > 0 ? std::clamp(wanted / sigmas, kLeastStretch, kMostStretch) : kMostStretch;
    const double next = reach * stretch;
    reach = next > inside && next < outside ? next : (inside + outside) / 2;
  }
};

}  // namespace

std::vector<LogInterval> likelihood_intervals(const NoiseSearch& search, const JudgedLog& log, const NoiseFound& found,
                                              const Eigen::MatrixXd& covariance) {
  const double wanted = normal_quantile(0.975);
  const auto n = static_cast<Eigen::Index>(found.knobs.size());
  std::vector<End> ends;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::VectorXd along = covariance.col(i) / covariance(i, i);
    for (const double side : {-1.0, 1.0})
      ends.push_back({.along = side * along, .reach = wanted * std::sqrt(covariance(i, i))});
  }
  // How far the limits of the number itself let it go.
  const auto room = [&](std::size_t end) {
    const NoiseKnob& knob = found.knobs[end / 2];
    NoiseModel best = found.best.model;
    return std::abs(std::log((end % 2 == 0 ? knob.least : knob.most) / knob.at(best)));
  };
  for (std::size_t end = 0; end < ends.size(); ++end) ends[end].reach = std::min(ends[end].reach, room(end));
  const double top = search.filtered(log, found.best.model).value;
  const auto model_at = [&](const End& end) { return moved(found.knobs, found.best.model, end.reach * end.along); };
  const auto seek = [&] {
    for (int round = 0; round < kRounds; ++round) {
      std::vector<std::size_t> open;
      std::vector<NoiseModel> models;
      for (std::size_t end = 0; end < ends.size(); ++end) {
        if (ends[end].found || !(ends[end].reach > 0)) continue;
        open.push_back(end);
        models.push_back(model_at(ends[end]));
      }
      if (open.empty()) return;
      const std::vector<NoisePoint> points = search.filtered(log, models);
      for (std::size_t k = 0; k < open.size(); ++k) {
        End& end = ends[open[k]];
        const double most = room(open[k]);
        const bool at_limit = end.reach >= most;
        end.judge(top - points[k].value, wanted);
        if (end.reach < most) continue;
        end.reach = most;
        end.found |= at_limit;
      }
    }
  };
  seek();
  // The end is farther where the other knobs are most likely at it than where they went along.
  const Eigen::VectorXd middle = logarithms(found.knobs, found.best.model);
  std::vector<std::size_t> open, held;
  std::vector<NoiseModel> models;
  for (std::size_t end = 0; end < ends.size(); ++end) {
    const double reach = ends[end].reach;
    if (!(reach > 0) || reach >= room(end) || reach > kUndetermined) continue;
    open.push_back(end);
    held.push_back(end / 2);
    models.push_back(model_at(ends[end]));
  }
  const std::vector<NoisePoint> points = search.climbed(log, found.knobs, search.filtered(log, models), held);
  for (std::size_t k = 0; k < open.size(); ++k) {
    End& end = ends[open[k]];
    end = {.along = (logarithms(found.knobs, points[k].model) - middle) / end.reach, .reach = end.reach};
  }
  seek();
  std::vector<LogInterval> intervals;
  for (std::size_t i = 0; i < found.knobs.size(); ++i) intervals.push_back({-ends[2 * i].reach, ends[2 * i + 1].reach});
  return intervals;
}

}  // namespace piste
