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
#include "solve/feeder.h"

namespace piste {
namespace {

constexpr double kMinusInfinity = -std::numeric_limits<double>::infinity();
constexpr int kMostSteps = 12, kInVain = 3;
constexpr double kCoarse = 0.3, kFine = 0.05;  // of logarithms, between the runs of a difference
constexpr double kLongestStep = 1.2;               // of a logarithm
constexpr double kEnough = 0.05, kArrived = 0.3;   // of the log-likelihood: by chance a value gains half of one
// Steps that are tried: how much they are damped, and how far they reach. Sigmas that are far too large come down by a
// half of their logarithm only at a reach of 1.
constexpr std::array<std::pair<double, double>, 4> kTrials{{{0, 1}, {0, 2}, {0, 4}, {1, 1}}};
constexpr double kNoGate = 1 - 1e-12;

// The measurements of a run that count as spoilt: those that it rejects, of each source one in fifty at most, the worst.
// Where it rejects more, its sigmas are too small.
std::vector<Innovation> spoilt(const Solution& solution) {
  constexpr double kMost = 0.02;
  std::vector<Innovation> all;
  for (std::size_t source = 0; source < solution.sources.size(); ++source) {
    std::vector<Innovation> rejected;
    double count = 0;
    for (const Innovation& i : solution.innovations) {
      if (i.source != static_cast<int>(source) || i.outcome == Outcome::kRepeated) continue;
      ++count;
      if (!was_used(i.outcome)) rejected.push_back(i);
    }
    std::stable_sort(rejected.begin(), rejected.end(),
                     [](const Innovation& a, const Innovation& b) { return a.nis > b.nis; });
    rejected.resize(std::min(rejected.size(), static_cast<std::size_t>(kMost * count)));
    all.insert(all.end(), rejected.begin(), rejected.end());
  }
  return all;
}

// Makes the sigmas of what was measured those of a spoilt measurement. `source` is its name in a solution.
void spoil(Log& log, std::string_view source, const Innovation& innovation) {
  constexpr double kWider = 5, kSame = 1e-6;  // s
  const double time = innovation.time + innovation.late;
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

// By how much residuals and sigmas of a run, `apart` from another in one knob, differ from those of that other, for a
// unit of the knob: dz/σ and √2 d ln σ.
Eigen::VectorXd change(const NoisePoint& here, const NoisePoint& there, double apart) {
  Eigen::VectorXd rows = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * here.innovations.size()));
  auto other = there.innovations.begin();
  for (std::size_t k = 0; k < here.innovations.size(); ++k) {
    const Innovation& i = here.innovations[k];
    while (other != there.innovations.end() && before(*other, i)) ++other;
    if (other == there.innovations.end() || before(i, *other)) continue;
    for (int axis = 0; axis < i.dof; ++axis) {
      const auto row = static_cast<Eigen::Index>(6 * k) + 2 * axis;
      rows(row) = (other->residual(axis) - i.residual(axis)) / (apart * i.sigma(axis));
      rows(row + 1) = std::sqrt(2) * std::log(other->sigma(axis) / i.sigma(axis)) / apart;
    }
  }
  return rows;
}

}  // namespace

NoiseSearch::NoiseSearch(const Log& log, const FilterOptions& options, const Start& start, const NoiseModel& centre,
                         std::size_t jobs)
    : log_(log), options_(options), start_(start), centre_(centre), jobs_(jobs) {
  // What may be wrong here is the noise, and not a receiver: none is left out for long.
  options_.behaviour.trust.distrust = std::min(options_.behaviour.trust.distrust, 1.0);
}

// A run of which only the innovations are kept.
Solution NoiseSearch::run(const Log& log, const NoiseModel& model, bool gated) const {
  ++runs_;
  FilterOptions options = with_noise(options_, model);
  if (!gated) options.behaviour.trust.gate = kNoGate;
  const Log noisy = with_noise(log, model);
  Filter filter(options, noisy.world, start_);
  LogPlace place = place_at(noisy, start_.time, 1e300);
  Feeder feeder(noisy, place, filter);
  while (!feeder.done()) feeder.step();
  filter.finish();
  Solution solution;
  solution.sources = filter.sources();
  solution.innovations.assign(filter.innovations().begin(), filter.innovations().end());
  return solution;
}

Log NoiseSearch::judged(const NoiseModel& model) const {
  Log log = log_;
  try {
    const Solution solution = run(log_, model, true);
    for (const Innovation& i : spoilt(solution)) spoil(log, solution.sources[static_cast<std::size_t>(i.source)], i);
  } catch (const DataError&) {
    return log;  // it diverged: nothing is known
  }
  return log;
}

NoisePoint NoiseSearch::filtered(const Log& log, const NoiseModel& model) const {
  NoisePoint point;
  point.model = model;
  point.likelihood = point.value = kMinusInfinity;
  try {
    const Solution solution = run(log, model, false);
    point.innovations = in_order(telling(solution, start_.time, log.rest));
    point.sources = solution.sources;
  } catch (const DataError&) {
    return point;  // it diverged: not likely at all
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
    for (Eigen::Index i = 0; i < n; ++i) steps.push_back(apart * Eigen::VectorXd::Unit(n, i));
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
    for (const auto& [damping, reach] : kTrials) {
      Eigen::MatrixXd damped = ascent.information;
      damped.diagonal() *= 1 + damping;
      const Eigen::VectorXd by = reach * solve_symmetric(damped, ascent.slope);
      steps.push_back(by * std::min(1.0, kLongestStep / by.cwiseAbs().maxCoeff()));
    }
    const std::vector<NoisePoint> ahead = all(steps);
    const NoisePoint* next = &around.front();
    for (const std::vector<NoisePoint>* some : {&ahead, &around}) {
      for (const NoisePoint& point : *some) {
        if (point.value > next->value) next = &point;
      }
    }
    const bool arrived = apart == kFine && next->value - around.front().value < kArrived;
    model = next->model;
    apart = kFine;
    if (progress) progress(static_cast<double>(step + 1) / kMostSteps);
    if (arrived) {
      found.best = *next;
      break;
    }
  }
  if (!std::isfinite(found.best.likelihood)) {
    throw DataError("", "no innovation tells the noise: the body has to move for more than 15 s after the start");
  }
  return found;
}

// Gradient and curvature at the first of the points; then comes for each knob the one above. The likelihood is taken to
// be a parabola of that curvature between them.
NoiseSearch::Ascent NoiseSearch::ascent(const std::vector<NoiseKnob>& knobs, const std::vector<NoisePoint>& points,
                                        double apart) const {
  const NoisePoint& here = points.front();
  const auto n = static_cast<Eigen::Index>(knobs.size());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(6 * here.innovations.size()), n);
  Ascent ascent;
  ascent.slope = Eigen::VectorXd::Zero(n);
  const Eigen::VectorXd at = logarithms(knobs, here.model), centre = logarithms(knobs, centre_);
  for (Eigen::Index i = 0; i < n; ++i) {
    const NoisePoint& there = points[static_cast<std::size_t>(i + 1)];
    if (!std::isfinite(there.likelihood) || !std::isfinite(here.likelihood)) continue;
    rows.col(i) = change(here, there, apart);
    ascent.slope(i) = (there.likelihood - here.likelihood) / apart + 0.5 * apart * rows.col(i).squaredNorm();
  }
  ascent.information = rows.transpose() * rows;
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
