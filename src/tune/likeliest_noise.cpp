#include "piste/tune/likeliest_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <string_view>
#include <utility>

#include "math/linear_algebra.h"
#include "piste/math/statistics.h"
#include "tune/noise_search.h"
#include "tune/stated_errors.h"

namespace piste {
namespace {

constexpr double kToldMore = 0.5, kWidest = 3;  // of the prior's 1-sigma; of a value, either way

// `about`: the interval of the logarithm. `width`: its 1-sigma before the data.
TunedNoise number(std::string name, std::string unit, double start, double value, const LogInterval& about,
                  double width) {
  const double reach = about.reach();
  return {.name = std::move(name),
          .unit = std::move(unit),
          .start = start,
          .value = value,
          .low = value * std::exp(about.low),
          .high = value * std::exp(about.high),
          .determined = reach < kToldMore * width * normal_quantile(0.975) && reach < std::log(kWidest),
          .prior = width};
}

LogInterval by_curvature(double variance) {
  const double reach = normal_quantile(0.975) * std::sqrt(variance);
  return {-reach, reach};
}

std::vector<TunedNoise> numbers_of(const NoiseFound& found, const Eigen::MatrixXd& covariance,
                                   const std::vector<LogInterval>& intervals, const NoiseModel& start) {
  std::vector<TunedNoise> numbers;
  NoiseModel best = found.best.model, before = start;
  for (std::size_t k = 0; k < found.knobs.size(); ++k) {
    const NoiseKnob& knob = found.knobs[k];
    numbers.push_back(number(knob.name, knob.unit, knob.factor * knob.at(before), knob.factor * knob.at(best),
                             intervals[k], knob.width));
  }
  // The factors of whole sigmas, from those of their white and their coloured part.
  for (std::size_t i = 0; i < best.gnss.size(); ++i) {
    if (!(best.gnss[i].drift > 0)) continue;
    constexpr double kLittle = 1e-6;
    const double scale = best.gnss[i].position();
    Eigen::VectorXd slope(static_cast<Eigen::Index>(found.knobs.size()));
    for (std::size_t k = 0; k < found.knobs.size(); ++k) {
      NoiseModel more = best;
      found.knobs[k].at(more) *= 1 + kLittle;
      slope(static_cast<Eigen::Index>(k)) = std::log(more.gnss[i].position() / scale) / kLittle;
    }
    numbers.push_back(number(fmt::format("gnss[{}].sigma_scale", i), "", start.gnss[i].position(), scale,
                             by_curvature(slope.dot(covariance * slope)), kSizeWidth));
  }
  return numbers;
}

// What Tuning::expected says.
NoiseModel expected(const NoiseFound& found, const std::vector<LogInterval>& intervals) {
  constexpr double kMost = 2;
  NoiseModel model = found.best.model;
  for (std::size_t k = 0; k < found.knobs.size(); ++k) {
    const NoiseKnob& knob = found.knobs[k];
    const bool of_imu = knob.name.starts_with("gyro.") || knob.name.starts_with("accel.");
    if (!of_imu || !(knob.name.ends_with(".noise") || knob.name.ends_with(".sigma"))) continue;
    const double sigma = intervals[k].reach() / normal_quantile(0.975);
    double& value = knob.at(model);
    value = std::clamp(value * std::min(std::exp(sigma * sigma), kMost), knob.least, knob.most);
  }
  return model;
}

// What the data say of the total that a receiver states: with more than they show, the factor of its sigmas is that of
// the white part, and they do not determine the total.
void add_stated_totals(const NoiseModel& found, const NoiseModel& kept, std::vector<TunedNoise>& numbers) {
  for (std::size_t i = 0; i < kept.gnss.size(); ++i) {
    const double before = found.gnss[i].position(), total = kept.gnss[i].position();
    if (total == before) continue;
    const std::string name = fmt::format("gnss[{}].sigma_scale", i);
    const auto whole = std::ranges::find(numbers, name, &TunedNoise::name);
    if (whole == numbers.end()) continue;
    if (!(kept.gnss[i].drift > 0)) {  // by its interval all may be white
      whole->value = total;
      whole->high = std::max(whole->high, total);
      continue;
    }
    TunedNoise stated = *whole;
    if (found.gnss[i].drift > 0) {
      numbers.erase(whole);
    } else {
      whole->name = fmt::format("gnss[{}].white_scale", i);
    }
    stated.high *= total / stated.value;
    stated.value = total;
    stated.determined = false;
    numbers.push_back(std::move(stated));
  }
}

// Of the measurements that a run uses.
std::vector<SourceNis> nis_of(const Evidence& run) {
  std::map<int, std::vector<double>> per_row;
  for (const Innovation& i : run.innovations) {
    if (was_used(i.outcome)) per_row[i.source].push_back(i.nis / i.dof);
  }
  std::vector<SourceNis> all;
  all.reserve(per_row.size());
  for (const auto& [source, nis] : per_row) {
    all.push_back(
        {run.sources[static_cast<std::size_t>(source)], nis.size(), mean(nis), standard_error_of_series(nis)});
  }
  return all;
}

// The same noise with a coloured error of the first receiver, of several sizes and times. What noise of the IMU was
// made for this error without it may be too large next to it.
std::vector<NoiseModel> with_drifts(const NoiseModel& model) {
  std::vector<NoiseModel> models;
  for (const double time : {1.0, 5.0, 30.0, 150.0}) {
    for (const double white : {1.0, 0.5}) {
      for (const double drift : {1.0, 3.0}) {
        for (const double imu : {1.0, 0.4}) {
          NoiseModel& m = models.emplace_back(model);
          m.sensor.gyro.noise *= imu;
          m.sensor.accel.noise *= imu;
          m.gnss.front().white *= white;
          m.gnss.front().drift = drift * model.gnss.front().white;
          m.gnss.front().drift_time = time;
        }
      }
    }
  }
  return models;
}

// Whether a receiver states sigmas of different kinds of fixes, such as fixed and float ones: by the leaps of
// SlowLevel.
bool has_kinds(const std::vector<GnssFix>& fixes) {
  const auto leaps = [](const GnssFix& a, const GnssFix& b) {
    return std::abs(std::log(a.sigma_position.x() / b.sigma_position.x())) > 1;
  };
  return std::adjacent_find(fixes.begin(), fixes.end(), leaps) != fixes.end();
}

// The same noise with a limit of the white error of the first receiver: of the better kind of its fixes nearly all is
// white, and nearly all is slow of the worse one.
std::vector<NoiseModel> with_kinds(const NoiseModel& model, const std::vector<GnssFix>& fixes) {
  std::vector<double> stated;
  stated.reserve(fixes.size());
  for (const GnssFix& fix : fixes) stated.push_back(fix.sigma_position.head<2>().mean());
  constexpr double kBetter = 0.1, kLittle = 0.3;  // a quantile; the slow share of the better kind
  const double least = model.gnss.front().white * quantile(std::move(stated), kBetter);
  std::vector<NoiseModel> models;
  for (const double time : {5.0, 20.0, 60.0}) {
    for (const double more : {1.0, 3.0, 10.0}) {
      ReceiverNoise& receiver = models.emplace_back(model).gnss.front();
      if (!(receiver.drift > 0)) receiver.drift = kLittle * receiver.white;
      receiver.drift_time = time;
      receiver.most_white = more * least;
    }
  }
  return models;
}

// By how much the heights of a receiver are worse than its north and east, both against their sigmas: by medians, as
// outliers are not to decide. 1 where it has no positions.
double ratio_of_heights(const Evidence& run, std::size_t receiver) {
  const std::string name = fmt::format("gnss[{}].position", receiver);
  std::vector<double> level, heights;  // squares, in sigmas
  for (const Innovation& i : run.innovations) {
    if (run.sources[static_cast<std::size_t>(i.source)] != name) continue;
    const auto square = [&i](int axis) { return std::pow(i.residual(axis) / i.sigma(axis), 2); };
    level.push_back(square(0));
    level.push_back(square(1));
    heights.push_back(square(2));
  }
  if (heights.empty()) return 1;
  return std::sqrt(median(std::move(heights)) / median(std::move(level)));
}

// The same noise, with heights of their own where those of a receiver look worse or better than the rest.
NoiseModel with_heights(NoiseModel model, const Evidence& run) {
  constexpr double kAlike = 1.1, kMost = 100;  // factors: not looked into; a receiver states nothing at all
  for (std::size_t i = 0; i < model.gnss.size(); ++i) {
    const double ratio = std::clamp(ratio_of_heights(run, i), 1 / kMost, kMost);
    if (std::abs(std::log(ratio)) < std::log(kAlike)) continue;
    model.gnss[i].height *= ratio;
    model.gnss[i].white *= std::pow(ratio, -1.0 / 3);  // north and east had been taken for as bad as the heights
  }
  return model;
}

// Of how many receivers the heights differ.
std::ptrdiff_t different_heights(const NoiseModel& a, const NoiseModel& b) {
  return std::inner_product(a.gnss.begin(), a.gnss.end(), b.gnss.begin(), std::ptrdiff_t{0}, std::plus<>(),
                            [](const ReceiverNoise& x, const ReceiverNoise& y) { return x.height != y.height; });
}

// Rows of the innovations of a source, or of all whose names end so.
double rows_of(const Evidence& run, std::string_view source) {
  double rows = 0;
  for (const Innovation& i : run.innovations) {
    if (run.sources[static_cast<std::size_t>(i.source)].ends_with(source)) rows += i.dof;
  }
  return rows;
}

const NoisePoint& most_likely(const std::vector<NoisePoint>& points) {
  return *std::max_element(points.begin(), points.end(),
                           [](const NoisePoint& a, const NoisePoint& b) { return a.value < b.value; });
}

// Whether the heights of a receiver are taken for better than their rounding leaves them.
bool too_exact(const ReceiverNoise& receiver, const StandingHeights& standing) {
  const SigmaScales scales = receiver.scales();
  return standing.too_small(scales.position * scales.height * receiver.stated.z());
}

// How much of the work is done after so many runs. Nobody knows how many there will be: as many as a rule are most of
// the way, and what goes beyond nears the end ever more slowly.
double part_after(std::size_t runs, double as_a_rule) {
  constexpr double kMost = 0.8;
  const double x = static_cast<double>(runs) / as_a_rule;
  return x < 1 ? kMost * x : 1 - (1 - kMost) / x;
}

// As likeliest_noise(), once.
Tuning sought(const Log& log, const FilterOptions& options, const Start& start, const TuneOptions& how,
              const ProgressCallback& progress) {
  const NoiseModel centre = noise_model(options, log);
  std::function<void(std::size_t)> ran;
  if (progress) ran = [&](std::size_t runs) { progress(part_after(runs, how.thorough ? kThoroughRuns : kRoughRuns)); };
  const NoiseSearch search(log, options, start, centre, how.thorough, how.jobs, {.length = how.hold_out},
                           std::move(ran));
  NoiseFound found = search.climb(centre);
  JudgedLog log_judged = search.judged(found.best.model);
  Tuning tuning;
  // The gain of the most likely of these models, which becomes the one that was found if it is above the penalty.
  const auto gain_of = [&](const std::vector<NoiseModel>& models, double penalty) {
    const double before = search.filtered(log_judged, found.best.model).evidence.likelihood;
    const std::vector<NoisePoint> coarse = search.filtered(log_judged, models);
    const NoisePoint& first = most_likely(coarse);
    const double rough = first.evidence.likelihood - before;
    if (!(rough > 0)) return rough;
    NoiseFound better = search.climb(first.model);
    const double gain = search.filtered(log_judged, better.best.model).evidence.likelihood - before;
    if (gain > penalty) {
      found = std::move(better);
      log_judged = search.judged(found.best.model);
    }
    return gain;
  };
  const NoiseModel uneven = with_heights(found.best.model, found.best.evidence);
  if (const auto more = static_cast<double>(different_heights(uneven, found.best.model)); more > 0)
    gain_of({uneven}, 0.5 * more * std::log(rows_of(found.best.evidence, ".position")));
  const double positions = rows_of(found.best.evidence, "gnss[0].position");
  const bool stated = std::any_of(centre.gnss.begin(), centre.gnss.end(), [](const auto& g) { return g.drift > 0; });
  const bool is_white = !centre.gnss.empty() && centre.gnss.front().is_white;  // by the user's word
  if (how.try_drift && !stated && !is_white && positions > 0) {
    tuning.drift_penalty = std::log(positions);  // two parameters
    tuning.drift_gain = gain_of(with_drifts(found.best.model), tuning.drift_penalty);
    if (has_kinds(log.gnss.front())) {
      tuning.kinds_penalty = (found.best.model.gnss.front().drift > 0 ? 0.5 : 1.5) * std::log(positions);
      tuning.kinds_gain = gain_of(with_kinds(found.best.model, log.gnss.front()), tuning.kinds_penalty);
    }
  }
  if (!found.best.model.gnss.empty()) {
    // Next to a coloured error of positions another one cannot be sought: its heights get what is their least.
    ReceiverNoise& receiver = found.best.model.gnss.front();
    const StandingHeights standing = standing_heights(log.gnss.front(), log.world);
    if (receiver.drift > 0 && too_exact(receiver, standing)) receiver.standing = standing;
  }
  tuning.likelihood_at_start = search.filtered(log_judged, centre).evidence.likelihood;
  tuning.likelihood = search.filtered(log_judged, found.best.model).evidence.likelihood;
  const Eigen::MatrixXd covariance =
      inverse(how.thorough ? observed_information(search, log_judged, found) : found.information);
  std::vector<LogInterval> intervals;
  if (how.thorough) {
    intervals = likelihood_intervals(search, log_judged, found, covariance);
  } else {
    for (const double variance : covariance.diagonal()) intervals.push_back(by_curvature(variance));
  }
  const auto with_stated = [&](const NoiseModel& model) {
    return with_stated_totals(model, how.stated, found.knobs, intervals, search, log_judged);
  };
  tuning.noise = with_stated(found.best.model);
  tuning.expected = with_stated(expected(found, intervals));
  tuning.numbers = numbers_of(found, covariance, intervals, centre);
  add_stated_totals(found.best.model, tuning.noise, tuning.numbers);
  tuning.rows = static_cast<std::size_t>(found.best.evidence.rows);
  tuning.nis = nis_of(search.gated(found.best.model, {.length = how.hold_out, .second = true}));
  tuning.held_out = how.hold_out;
  tuning.filter_runs = search.runs();
  return tuning;
}

}  // namespace

Tuning likeliest_noise(const Log& log, const FilterOptions& options, const Start& start, const TuneOptions& how,
                       const ProgressCallback& progress) {
  const bool stated = std::ranges::any_of(options.gnss, [](const auto& g) { return g.drift.has_value(); });
  if (stated || options.gnss.empty()) return sought(log, options, start, how, progress);
  const StandingHeights standing = standing_heights(log.gnss.front(), log.world);
  const double first = standing.slow > 0 ? 0.5 : 1;  // of the work: another search may follow
  Tuning found = sought(log, options, start, how, part_of(progress, 0, first));
  const bool coloured = found.drift_gain && *found.drift_gain > found.drift_penalty;
  if (coloured || !too_exact(found.expected.gnss.front(), standing)) return found;
  FilterOptions rounded = options;
  rounded.gnss.front().drift = standing.process();
  rounded.estimate = with_implied_blocks(rounded, rounded.estimate);
  return sought(log, rounded, start, how, part_of(progress, first, 1));
}

}  // namespace piste
