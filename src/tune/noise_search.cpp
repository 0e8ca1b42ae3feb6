#include "tune/noise_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "math/linear_algebra.h"
#include "math/parallel.h"
#include "piste/core/error.h"
#include "tune/held_delays.h"
#include "tune/spoilt_fixes.h"
#include "tune/thinned.h"

namespace piste {
namespace {

constexpr int kMostRounds = 3, kMostSteps = 8;
constexpr double kCoarse = 0.3, kFine = 0.05;  // of logarithms, between the runs of a difference
constexpr double kLongestStep = 1.2;           // of a logarithm
constexpr double kArrived = 0.3;               // of the log-likelihood: by chance a value gains half of one
constexpr double kNear = 2;                    // the same, where a rough answer will do
// Steps that are tried: how much they are damped, and how far they reach. Sigmas that are far too large come down by a
// half of their logarithm only at a reach of 1.
constexpr std::array<std::pair<double, double>, 4> kTrials{{{0, 1}, {0, 2}, {0, 4}, {1, 1}}};
constexpr double kNoGate = 1 - 1e-12;

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

// By how much residuals and sigmas of a run, `apart` from another in one knob, differ from those of that other, for a
// unit of the knob: dz/σ and √2 d ln σ.
Eigen::VectorXd change(const Evidence& here, const Evidence& there, double apart) {
  Eigen::VectorXd rows = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * here.innovations.size()));
  const std::vector<Innovation> innovations = in_order(here.innovations), others = in_order(there.innovations);
  auto other = others.begin();
  for (std::size_t k = 0; k < innovations.size(); ++k) {
    const Innovation& i = innovations[k];
    while (other != others.end() && before(*other, i)) ++other;
    if (other == others.end() || before(i, *other)) continue;
    for (int axis = 0; axis < i.dof; ++axis) {
      const auto row = static_cast<Eigen::Index>(6 * k + 2 * static_cast<std::size_t>(axis));
      rows(row) = (other->residual(axis) - i.residual(axis)) / (apart * i.sigma(axis));
      rows(row + 1) = std::sqrt(2) * std::log(other->sigma(axis) / i.sigma(axis)) / apart;
    }
  }
  return rows;
}

// Whether a delay, or the drift of the clock, is elsewhere in another run, by more than a part of its sigma.
bool delays_differ(const JudgedLog& a, const JudgedLog& b) {
  constexpr double kStill = 0.3;
  const auto differ = [&](Block block, double Estimate::*value) {
    return std::abs(b.start.x.*value - a.start.x.*value) > kStill * b.sigmas(full_offset(block));
  };
  return differ(Block::kGnssDelay, &Estimate::gnss_delay) || differ(Block::kVelocityDelay, &Estimate::velocity_delay) ||
         differ(Block::kAttitudeDelay, &Estimate::attitude_delay) || differ(Block::kClockDrift, &Estimate::clock_drift);
}

}  // namespace

Eigen::VectorXd logarithms(const std::vector<NoiseKnob>& knobs, NoiseModel model) {
  Eigen::VectorXd at(static_cast<Eigen::Index>(knobs.size()));
  for (Eigen::Index i = 0; i < at.size(); ++i) at(i) = std::log(knobs[static_cast<std::size_t>(i)].at(model));
  return at;
}

NoiseModel moved(const std::vector<NoiseKnob>& knobs, NoiseModel model, const Eigen::VectorXd& by) {
  for (Eigen::Index i = 0; i < by.size(); ++i) {
    const NoiseKnob& knob = knobs[static_cast<std::size_t>(i)];
    double& value = knob.at(model);
    value = std::clamp(value * std::exp(by(i)), knob.least, knob.most);
  }
  return model;
}

NoiseSearch::NoiseSearch(const Log& log, FilterOptions options, Start start, NoiseModel centre, bool thorough,
                         std::size_t jobs, Stretches fitted, std::function<void(std::size_t)> ran)
    : log_(thorough ? log : thinned(log)),
      options_(std::move(options)),
      start_(std::move(start)),
      centre_(std::move(centre)),
      white_(white_noise_range(log)),
      thorough_(thorough),
      jobs_(jobs),
      fitted_(fitted),
      ran_(std::move(ran)) {
  // What may be wrong here is the noise, and not a receiver: none is left out for long.
  options_.behaviour.trust.distrust = std::min(options_.behaviour.trust.distrust, 1.0);
  holding_ = holding_delays(options_);
  holding_.behaviour.trust.gate = kNoGate;
}

void NoiseSearch::count_run() const {
  ++runs_;
  if (!ran_) return;
  const std::lock_guard lock(mutex_);
  ran_(runs_);
}

Evidence NoiseSearch::gated(const NoiseModel& model, const Stretches& counted) const {
  Evidence run = filter_again(with_noise(log_, model), with_noise(options_, model), start_, kToTheEnd, counted);
  count_run();
  return run;
}

JudgedLog NoiseSearch::judged(const NoiseModel& model) const {
  const Evidence run = gated(model);
  return {with_spoilt_fixes(log_, run), run.rows > 0 ? with_delays(start_, run.last) : start_, run.sigmas};
}

NoisePoint NoiseSearch::filtered(const JudgedLog& judged, const NoiseModel& model) const {
  NoisePoint point;
  point.model = model;
  point.evidence =
      filter_again(with_noise(judged.log, model), with_noise(holding_, model), judged.start, kToTheEnd, fitted_);
  point.value = point.evidence.likelihood + prior(model);
  count_run();
  return point;
}

std::vector<NoisePoint> NoiseSearch::filtered(const JudgedLog& log, const std::vector<NoiseModel>& models) const {
  std::vector<NoisePoint> points(models.size());
  for_each_parallel(models.size(), jobs_, [&](std::size_t i) { points[i] = filtered(log, models[i]); });
  return points;
}

double NoiseSearch::prior(const NoiseModel& model) const {
  double sum = 0;
  NoiseModel here = model, centre = centre_;
  for (const NoiseKnob& knob : knobs_of(model, options_, log_, white_)) {
    const double start = knob.at(centre);
    if (start > 0) sum -= 0.5 * std::pow(std::log(knob.at(here) / start) / knob.width, 2);
  }
  return sum;
}

NoiseFound NoiseSearch::climb(const NoiseModel& from) const {
  NoiseFound found;
  found.knobs = knobs_of(from, options_, log_, white_);
  found.best.model = moved(found.knobs, from, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(found.knobs.size())));
  std::optional<JudgedLog> before;
  for (int round = 0; round < kMostRounds; ++round) {
    JudgedLog log = judged(found.best.model);
    const bool same = before && (!thorough_ || same_sigmas(before->log, log.log));
    if (same && !delays_differ(*before, log)) break;
    found.best = filtered(log, found.best.model);
    double apart = round == 0 ? kCoarse : kFine;
    for (int step = 0; step < kMostSteps && climb_once(log, found, apart); ++step) apart = kFine;
    before = std::move(log);
  }
  if (found.best.evidence.rows == 0) {
    throw DataError("", "no innovation tells the noise: the body has to move for more than 5 s after the start");
  }
  return found;
}

// One step; whether another one is worth its while.
bool NoiseSearch::climb_once(const JudgedLog& log, NoiseFound& found, double apart) const {
  const auto n = static_cast<Eigen::Index>(found.knobs.size());
  const auto tried = [&](const std::vector<Eigen::VectorXd>& steps) {
    std::vector<NoiseModel> models;
    models.reserve(steps.size());
    for (const Eigen::VectorXd& by : steps) models.push_back(moved(found.knobs, found.best.model, by));
    return filtered(log, models);
  };
  std::vector<Eigen::VectorXd> steps;
  for (Eigen::Index i = 0; i < n; ++i) steps.emplace_back(apart * Eigen::VectorXd::Unit(n, i));
  std::vector<NoisePoint> points = tried(steps);
  const Ascent ascent = this->ascent(found.knobs, found.best, points, apart);
  found.information = ascent.information;

  steps.clear();
  for (const auto& [damping, reach] : kTrials) {
    Eigen::MatrixXd damped = ascent.information;
    damped.diagonal() *= 1 + damping;
    const Eigen::VectorXd by = reach * solve_symmetric(damped, ascent.slope);
    steps.emplace_back(by * std::min(1.0, kLongestStep / by.cwiseAbs().maxCoeff()));
  }
  for (NoisePoint& point : tried(steps)) points.push_back(std::move(point));
  const auto best = std::max_element(points.begin(), points.end(),
                                     [](const NoisePoint& a, const NoisePoint& b) { return a.value < b.value; });
  const double gain = best->value - found.best.value;
  if (gain > 0) found.best = std::move(*best);
  return gain > (thorough_ ? kArrived : kNear) || apart > kFine;
}

std::vector<NoisePoint> NoiseSearch::climbed(const JudgedLog& log, const std::vector<NoiseKnob>& knobs,
                                             std::vector<NoisePoint> from, const std::vector<std::size_t>& held) const {
  const std::size_t others = knobs.size() - 1;
  if (others == 0) return from;
  std::vector<std::vector<NoiseKnob>> free(from.size(), knobs);
  std::vector<NoiseModel> models;
  const auto add = [&](std::size_t k, const Eigen::VectorXd& by) {
    models.push_back(moved(free[k], from[k].model, by));
  };
  for (std::size_t k = 0; k < from.size(); ++k) {
    free[k].erase(free[k].begin() + static_cast<std::ptrdiff_t>(held[k]));
    for (std::size_t i = 0; i < others; ++i) {
      add(k, kFine * Eigen::VectorXd::Unit(static_cast<Eigen::Index>(others), static_cast<Eigen::Index>(i)));
    }
  }
  const std::vector<NoisePoint> around = filtered(log, std::exchange(models, {}));
  constexpr std::array kReaches{0.5, 1.0};
  for (std::size_t k = 0; k < from.size(); ++k) {
    const auto first = around.begin() + static_cast<std::ptrdiff_t>(k * others);
    const Ascent here = ascent(free[k], from[k], {first, first + static_cast<std::ptrdiff_t>(others)}, kFine);
    const Eigen::VectorXd by = solve_symmetric(here.information, here.slope);
    const double shortened = std::min(1.0, kLongestStep / by.cwiseAbs().maxCoeff());
    for (const double reach : kReaches) add(k, reach * shortened * by);
  }
  const std::vector<NoisePoint> tried = filtered(log, models);
  for (std::size_t k = 0; k < tried.size(); ++k) {
    NoisePoint& best = from[k / kReaches.size()];
    if (tried[k].value > best.value) best = tried[k];
  }
  return from;
}

// Gradient and curvature `here`; of the points, each has one knob higher. The likelihood is taken to be a parabola of
// that curvature between them.
NoiseSearch::Ascent NoiseSearch::ascent(const std::vector<NoiseKnob>& knobs, const NoisePoint& here,
                                        const std::vector<NoisePoint>& around, double apart) const {
  const auto n = static_cast<Eigen::Index>(knobs.size());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(6 * here.evidence.innovations.size()), n);
  Ascent ascent;
  ascent.slope = Eigen::VectorXd::Zero(n);
  const Eigen::VectorXd at = logarithms(knobs, here.model), centre = logarithms(knobs, centre_);
  for (Eigen::Index i = 0; i < n; ++i) {
    const NoisePoint& there = around[static_cast<std::size_t>(i)];
    if (!std::isfinite(there.value) || !std::isfinite(here.value)) continue;
    rows.col(i) = change(here.evidence, there.evidence, apart);
    ascent.slope(i) =
        (there.evidence.likelihood - here.evidence.likelihood) / apart + 0.5 * apart * rows.col(i).squaredNorm();
  }
  ascent.information = rows.transpose() * rows;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double width = knobs[static_cast<std::size_t>(i)].width;
    ascent.information(i, i) += 1 / (width * width);
    if (std::isfinite(centre(i))) ascent.slope(i) -= (at(i) - centre(i)) / (width * width);
  }
  return ascent;
}

}  // namespace piste
