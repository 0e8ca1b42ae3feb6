#include "tune/noise_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
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
constexpr int kChords = 2;                     // steps by the differences of the one before
constexpr double kCoarse = 0.3, kFine = 0.05;  // of logarithms, between the runs of a difference
constexpr double kLongestStep = 1.2;           // of a logarithm
constexpr double kArrived = 0.1;               // of the log-likelihood: by chance a value gains half of one
constexpr double kNear = 1;                    // the same, where a rough answer will do
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

// Calls `see(k, one, other)` for the innovations of the same measurement, the k-th of `ordered` and that of another
// run.
template <class See>
void for_each_pair(const std::vector<Innovation>& ordered, const Evidence& run, See&& see) {
  const std::vector<Innovation> others = in_order(run.innovations);
  auto other = others.begin();
  for (std::size_t k = 0; k < ordered.size(); ++k) {
    while (other != others.end() && before(*other, ordered[k])) ++other;
    if (other == others.end()) return;
    if (!before(ordered[k], *other)) see(k, ordered[k], *other);
  }
}

Eigen::Index row_of(std::size_t k, int axis) {
  return static_cast<Eigen::Index>(6 * k + 2 * static_cast<std::size_t>(axis));
}

// By how much residuals and sigmas of a run, `apart` from another in one knob, differ from those of that other, for a
// unit of the knob: dz/σ and √2 d ln σ.
Eigen::VectorXd change(const std::vector<Innovation>& here, const Evidence& there, double apart) {
  Eigen::VectorXd rows = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * here.size()));
  for_each_pair(here, there, [&](std::size_t k, const Innovation& i, const Innovation& other) {
    for (int axis = 0; axis < i.dof; ++axis) {
      rows(row_of(k, axis)) = (other.residual(axis) - i.residual(axis)) / (apart * i.sigma(axis));
      rows(row_of(k, axis) + 1) = std::sqrt(2) * std::log(other.sigma(axis) / i.sigma(axis)) / apart;
    }
  });
  return rows;
}

// What the residuals and sigmas of a run multiply the changes with in the gradient of −Σ (½ z²/σ² + ln σ).
Eigen::VectorXd weights(const std::vector<Innovation>& here, const Evidence& there) {
  Eigen::VectorXd of_rows = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(6 * here.size()));
  for_each_pair(here, there, [&](std::size_t k, const Innovation& i, const Innovation& other) {
    if (is_outlier(other, there.sources)) return;  // its likelihood does not change
    for (int axis = 0; axis < i.dof; ++axis) {
      const double z = other.residual(axis) / other.sigma(axis);
      of_rows(row_of(k, axis)) = -z * i.sigma(axis) / other.sigma(axis);
      of_rows(row_of(k, axis) + 1) = (z * z - 1) / std::sqrt(2);
    }
  });
  return of_rows;
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

// Steps by one set of differences; whether others are worth their while. After the first step the gradient is carried
// along by the changes of residuals and sigmas, which the differences gave (Shamanskii 1967: chord steps).
bool NoiseSearch::climb_once(const JudgedLog& log, NoiseFound& found, double apart) const {
  const auto n = static_cast<Eigen::Index>(found.knobs.size());
  const double enough = thorough_ ? kArrived : kNear;
  std::vector<NoiseModel> models;
  for (Eigen::Index i = 0; i < n; ++i)
    models.push_back(moved(found.knobs, found.best.model, apart * Eigen::VectorXd::Unit(n, i)));
  std::vector<NoisePoint> around = filtered(log, models);
  Ascent ascent = this->ascent(found.knobs, found.best, around, apart);
  found.information = ascent.information;
  ascent.hold(found.knobs, found.best.model);
  const bool is_rough = apart > kFine;
  for (int chord = 0; chord <= kChords; ++chord) {
    const bool has_gradient = std::isfinite(found.best.value);
    if (has_gradient && ascent.gain() < enough) return is_rough || chord > 0;
    const NoisePoint from = found.best;
    const double gain = step(log, found, ascent, std::exchange(around, {}));
    if (gain < enough) return is_rough || chord > 0;
    carry(ascent, found.knobs, from, found.best);
  }
  return true;
}

// Takes the most likely of some steps, and of the points `around`. Returns what it gains.
double NoiseSearch::step(const JudgedLog& log, NoiseFound& found, const Ascent& ascent,
                         std::vector<NoisePoint> around) const {
  const auto model = [&](const Eigen::VectorXd& by) { return moved(found.knobs, found.best.model, by); };
  const auto add = [&](std::vector<NoisePoint> more) { std::ranges::move(more, std::back_inserter(around)); };
  const auto best = [&] {
    return std::ranges::max_element(around, {}, [](const NoisePoint& point) { return point.value; });
  };
  const Eigen::VectorXd first = ascent.step(kLongestStep);
  const bool is_whole = ascent.step(std::numeric_limits<double>::infinity()) == first;
  // Sigmas that are far too large come down by a half of their logarithm only at a reach of 1.
  const Eigen::VectorXd second = is_whole ? 2 * first : ascent.step(kLongestStep / 4);
  add(filtered(log, std::vector{model(first), model(second)}));
  if (is_whole && best() == around.end() - 1 && best()->value > found.best.value) {
    add(filtered(log, std::vector{model(4 * first)}));
  } else if (is_whole && !(best()->value > found.best.value)) {
    add(filtered(log, std::vector{model(first / 2)}));
  }
  const double gain = best()->value - found.best.value;
  if (gain > 0) found.best = std::move(*best());
  return std::max(0.0, gain);
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
    const Eigen::VectorXd by = here.step(kLongestStep);
    for (const double reach : kReaches) add(k, reach * by);
  }
  const std::vector<NoisePoint> tried = filtered(log, models);
  for (std::size_t k = 0; k < tried.size(); ++k) {
    NoisePoint& best = from[k / kReaches.size()];
    if (tried[k].value > best.value) best = tried[k];
  }
  return from;
}

// The largest part of Newton's step is at most `most`: it is damped (Levenberg 1944), so that numbers that the data
// determine go all the way where others would go too far.
Eigen::VectorXd NoiseSearch::Ascent::step(double most) const {
  const auto damped = [&](double damping) -> Eigen::VectorXd {
    return solve_symmetric(information + damping * Eigen::MatrixXd::Identity(information.rows(), information.cols()),
                           slope);
  };
  const auto is_long = [&](double damping) { return damped(damping).cwiseAbs().maxCoeff() > most; };
  if (!is_long(0)) return damped(0);
  double low = 0, high = slope.norm() / most;  // (A + μ 1)⁻¹ g is no longer than g / μ
  for (int halving = 0; halving < 30; ++halving) {
    const double middle = (low + high) / 2;
    (is_long(middle) ? low : high) = middle;
  }
  return damped(high);
}

// A number at its limit, towards which the likelihood rises, stays there.
void NoiseSearch::Ascent::hold(const std::vector<NoiseKnob>& knobs, const NoiseModel& model) {
  const Eigen::VectorXd moves = logarithms(knobs, moved(knobs, model, slope)) - logarithms(knobs, model);
  for (Eigen::Index i = 0; i < slope.size(); ++i) {
    if (moves(i) != 0) continue;
    slope(i) = 0;
    changes.col(i).setZero();
    information.row(i).setZero();
    information.col(i).setZero();
    information(i, i) = 1;
  }
}

// Gradient and curvature `here`; of the points, each has one knob higher. The likelihood is taken to be a parabola of
// that curvature between them.
NoiseSearch::Ascent NoiseSearch::ascent(const std::vector<NoiseKnob>& knobs, const NoisePoint& here,
                                        const std::vector<NoisePoint>& around, double apart) const {
  const auto n = static_cast<Eigen::Index>(knobs.size());
  Ascent ascent;
  ascent.innovations = in_order(here.evidence.innovations);
  ascent.changes = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(6 * ascent.innovations.size()), n);
  ascent.slope = prior_slope(knobs, here.model);
  for (Eigen::Index i = 0; i < n; ++i) {
    const NoisePoint& there = around[static_cast<std::size_t>(i)];
    if (!std::isfinite(there.value) || !std::isfinite(here.value)) continue;
    ascent.changes.col(i) = change(ascent.innovations, there.evidence, apart);
    ascent.slope(i) += (there.evidence.likelihood - here.evidence.likelihood) / apart +
                       0.5 * apart * ascent.changes.col(i).squaredNorm();
  }
  ascent.information = ascent.changes.transpose() * ascent.changes;
  for (Eigen::Index i = 0; i < n; ++i)
    ascent.information(i, i) += std::pow(knobs[static_cast<std::size_t>(i)].width, -2);
  return ascent;
}

// The gradient at `to` from that at `from`, by the changes of residuals and sigmas that `ascent` has.
void NoiseSearch::carry(Ascent& ascent, const std::vector<NoiseKnob>& knobs, const NoisePoint& from,
                        const NoisePoint& to) const {
  const auto weight = [&](const NoisePoint& point) { return weights(ascent.innovations, point.evidence); };
  ascent.slope += ascent.changes.transpose() * (weight(to) - weight(from)) + prior_slope(knobs, to.model) -
                  prior_slope(knobs, from.model);
  ascent.hold(knobs, to.model);
}

Eigen::VectorXd NoiseSearch::prior_slope(const std::vector<NoiseKnob>& knobs, const NoiseModel& model) const {
  const Eigen::VectorXd off = logarithms(knobs, centre_) - logarithms(knobs, model);
  Eigen::VectorXd slope(off.size());
  for (Eigen::Index i = 0; i < slope.size(); ++i) {
    // A value that is 0 at the start has no prior.
    slope(i) = std::isfinite(off(i)) ? off(i) * std::pow(knobs[static_cast<std::size_t>(i)].width, -2) : 0;
  }
  return slope;
}

}  // namespace piste
