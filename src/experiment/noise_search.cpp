#include "experiment/noise_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string_view>
#include <utility>

#include "experiment/innovation_likelihood.h"
#include "experiment/parallel.h"
#include "piste/core/error.h"
#include "piste/math/linear_algebra.h"
#include "piste/solve/run.h"

namespace piste {
namespace {

constexpr double kMinusInfinity = -std::numeric_limits<double>::infinity();
constexpr int kMostSteps = 12, kInVain = 3;
constexpr double kCoarse = 0.5, kFine = 0.1;  // of logarithms, between the runs of a difference
constexpr double kLongestStep = 1.2;               // of a logarithm
constexpr double kEnough = 0.05;                   // of the log-likelihood: by chance a value gains half of one
constexpr std::array kDamping{0.0, 0.3, 3.0};
constexpr double kNoGate = 1 - 1e-12;

// Makes the sigmas of a fix those of a spoilt one. `source` is its name in a solution.
void spoil(Log& log, std::string_view source, double time) {
  constexpr double kWider = 5, kSame = 1e-6;  // s
  const auto find = [&](auto& fixes) {
    const auto fix = std::find_if(fixes.begin(), fixes.end(), [&](const auto& f) { return f.time >= time - kSame; });
    return fix != fixes.end() && fix->time <= time + kSame ? &*fix : nullptr;
  };
  for (std::size_t i = 0; i < log.gnss.size(); ++i) {
    const std::string name = fmt::format("gnss[{}].", i);
    if (!source.starts_with(name)) continue;
    GnssFix* fix = find(log.gnss[i]);
    if (fix == nullptr) continue;
    if (source.ends_with("position")) fix->sigma_position *= kWider;
    if (source.ends_with("velocity") && fix->velocity) fix->velocity->sigma *= kWider;
  }
  for (std::size_t i = 0; i < log.attitude.size(); ++i) {
    if (source != fmt::format("attitude[{}]", i)) continue;
    if (AttitudeFix* fix = find(log.attitude[i])) fix->covariance *= kWider * kWider;
  }
}

// The innovation of the same measurement in another run.
bool before(const Innovation& a, const Innovation& b) {
  constexpr double kSameFix = 1e-6;  // s
  if (a.source != b.source) return a.source < b.source;
  return a.time + a.late < b.time + b.late - kSameFix;
}

std::vector<Innovation> in_order(std::vector<Innovation> innovations) {
  std::stable_sort(innovations.begin(), innovations.end(), before);
  return innovations;
}

// The values of the knobs, as logarithms.
Eigen::VectorXd logarithms(const std::vector<NoiseKnob>& knobs, NoiseModel model) {
  Eigen::VectorXd at(static_cast<Eigen::Index>(knobs.size()));
  for (Eigen::Index i = 0; i < at.size(); ++i) at(i) = std::log(knobs[static_cast<std::size_t>(i)].at(model));
  return at;
}

NoiseModel moved(const std::vector<NoiseKnob>& knobs, NoiseModel model, const Eigen::VectorXd& by) {
  for (Eigen::Index i = 0; i < by.size(); ++i) knobs[static_cast<std::size_t>(i)].at(model) *= std::exp(by(i));
  return model;
}

// How residuals and sigmas of one run differ from those of another, a column each: rows are dz/σ and √2 d ln σ.
struct Change {
  Eigen::VectorXd rows;
  double likelihood = 0;
};

Change change(const NoisePoint& here, const NoisePoint& low, const NoisePoint& high, double apart) {
  // A run that diverged is replaced by the one in the middle.
  const bool no_low = !std::isfinite(low.likelihood), no_high = !std::isfinite(high.likelihood);
  const NoisePoint &from = no_low ? here : low, &to = no_high ? here : high;
  const double between = apart * ((no_low ? 0 : 1) + (no_high ? 0 : 1));
  Change c{Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * here.innovations.size())), 0};
  if (between == 0) return c;
  c.likelihood = (to.likelihood - from.likelihood) / between;
  auto a = from.innovations.begin(), b = to.innovations.begin();
  for (std::size_t k = 0; k < here.innovations.size(); ++k) {
    const Innovation& i = here.innovations[k];
    while (a != from.innovations.end() && before(*a, i)) ++a;
    while (b != to.innovations.end() && before(*b, i)) ++b;
    if (a == from.innovations.end() || b == to.innovations.end() || before(i, *a) || before(i, *b)) continue;
    const bool counts = was_used(i.outcome) && was_used(a->outcome) && was_used(b->outcome);
    for (int axis = 0; counts && axis < i.dof; ++axis) {
      const auto row = static_cast<Eigen::Index>(6 * k) + 2 * axis;
      c.rows(row) = (b->residual(axis) - a->residual(axis)) / (between * i.sigma(axis));
      c.rows(row + 1) = std::sqrt(2) * std::log(b->sigma(axis) / a->sigma(axis)) / between;
    }
  }
  return c;
}

}  // namespace

NoiseSearch::NoiseSearch(const Log& log, const FilterOptions& options, const Start& start, const NoiseModel& centre,
                         std::size_t jobs)
    : log_(log), options_(options), start_(start), centre_(centre), jobs_(jobs) {
  // What may be wrong here is the noise, and not a receiver: none is left out for long.
  options_.behaviour.trust.distrust = std::min(options_.behaviour.trust.distrust, 1.0);
}

Log NoiseSearch::judged(const NoiseModel& model) const {
  Log log = log_;
  ++runs_;
  try {
    const Solution solution = run_filter(with_noise(log_, model), with_noise(options_, model), start_).solution;
    for (const Innovation& i : solution.innovations) {
      if (!was_used(i.outcome) && i.outcome != Outcome::kRepeated)
        spoil(log, solution.sources[static_cast<std::size_t>(i.source)], i.time + i.late);
    }
  } catch (const DataError&) {
    return log;
  }
  return log;
}

NoisePoint NoiseSearch::filtered(const Log& log, const NoiseModel& model) const {
  ++runs_;
  NoisePoint point;
  point.model = model;
  point.likelihood = point.value = kMinusInfinity;
  try {
    FilterOptions options = with_noise(options_, model);
    options.behaviour.trust.gate = kNoGate;
    Solution solution = run_filter(with_noise(log, model), options, start_).solution;
    if (solution.empty()) return point;
    point.innovations = in_order(telling(solution, log.rest));
    point.sources = std::move(solution.sources);
  } catch (const DataError&) {
    return point;  // the filter diverged: not likely at all
  }
  point.likelihood = log_likelihood(point.innovations);
  point.value = point.likelihood + prior(model);
  return point;
}

double NoiseSearch::prior(const NoiseModel& model) const {
  double sum = 0;
  NoiseModel here = model, centre = centre_;
  for (const NoiseKnob& knob : knobs_of(model, options_, log_)) {
    const double start = knob.at(centre);
    if (start > 0) sum -= 0.5 * std::pow(std::log(knob.at(here) / start) / knob.width, 2);
  }
  return sum;
}

NoiseFound NoiseSearch::climb(const NoiseModel& from, const std::function<void(double)>& progress) const {
  NoiseFound found;
  found.knobs = knobs_of(from, options_, log_);
  found.best.value = kMinusInfinity;
  const auto n = static_cast<Eigen::Index>(found.knobs.size());
  NoiseModel model = from;
  double apart = kCoarse;
  for (int step = 0, in_vain = 0; step < kMostSteps && in_vain < kInVain; ++step) {
    const Log log = judged(model);
    const auto all = [&](const std::vector<Eigen::VectorXd>& steps) {
      std::vector<NoisePoint> points(steps.size());
      for_each_parallel(steps.size(), jobs_, [&](std::size_t k) {
        points[k] = filtered(log, moved(found.knobs, model, steps[k]));
      });
      return points;
    };
    std::vector<Eigen::VectorXd> steps{Eigen::VectorXd::Zero(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
      for (const double by : {-apart, apart}) steps.push_back(by * Eigen::VectorXd::Unit(n, i));
    }
    const std::vector<NoisePoint> around = all(steps);
    const Ascent ascent = this->ascent(found.knobs, around, apart);
    if (step == 0) found.likelihood_at_start = around.front().likelihood;
    const bool better = around.front().value > found.best.value + kEnough;
    in_vain = better ? 0 : in_vain + 1;
    if (around.front().value >= found.best.value) {
      found.best = around.front();
      found.covariance = inverse(ascent.information);
    }

    steps.clear();
    for (const double damping : kDamping) {
      Eigen::MatrixXd damped = ascent.information;
      damped.diagonal() *= 1 + damping;
      const Eigen::VectorXd by = solve_symmetric(damped, ascent.slope);
      steps.push_back(by * std::min(1.0, kLongestStep / by.cwiseAbs().maxCoeff()));
    }
    const std::vector<NoisePoint> ahead = all(steps);
    const NoisePoint* next = &around.front();
    for (const std::vector<NoisePoint>* some : {&ahead, &around}) {
      for (const NoisePoint& point : *some) {
        if (point.value > next->value) next = &point;
      }
    }
    const bool arrived = apart == kFine && next->value - around.front().value < kEnough;
    model = next->model;
    apart = kFine;
    if (progress) progress(static_cast<double>(step + 1) / kMostSteps);
    if (arrived) break;
  }
  if (!std::isfinite(found.best.likelihood)) {
    throw DataError("", "no innovation tells the noise: the body has to move for more than 15 s after the start");
  }
  return found;
}

// Gradient and curvature at the first of the points; then come, for each knob, the one below and the one above.
NoiseSearch::Ascent NoiseSearch::ascent(const std::vector<NoiseKnob>& knobs, const std::vector<NoisePoint>& around,
                                        double apart) const {
  const NoisePoint& here = around.front();
  const auto n = static_cast<Eigen::Index>(knobs.size());
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(6 * here.innovations.size()), n);
  Ascent ascent;
  ascent.slope.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(2 * i + 1);
    const Change c = change(here, around[k], around[k + 1], apart);
    rows.col(i) = c.rows;
    ascent.slope(i) = c.likelihood;
  }
  ascent.information = rows.transpose() * rows;
  const Eigen::VectorXd at = logarithms(knobs, here.model), centre = logarithms(knobs, centre_);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double width = knobs[static_cast<std::size_t>(i)].width;
    ascent.information(i, i) += 1 / (width * width);
    if (std::isfinite(centre(i))) ascent.slope(i) -= (at(i) - centre(i)) / (width * width);
  }
  return ascent;
}

NoisePoint NoiseSearch::likeliest(const NoiseModel& judge, const std::vector<NoiseModel>& models) const {
  const Log log = judged(judge);
  std::vector<NoisePoint> points(models.size());
  for_each_parallel(models.size(), jobs_, [&](std::size_t i) { points[i] = filtered(log, models[i]); });
  return *std::max_element(points.begin(), points.end(),
                           [](const NoisePoint& a, const NoisePoint& b) { return a.value < b.value; });
}

}  // namespace piste
