#include "piste/experiment/tune.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "experiment/innovation_likelihood.h"
#include "experiment/noise_search.h"
#include "piste/condition/pipeline.h"
#include "piste/core/error.h"
#include "piste/inspect/imu_health.h"
#include "piste/solve/attitude_noise.h"
#include "piste/solve/start.h"

namespace piste {
namespace {

constexpr double kNormal95 = 1.959963984540054;
constexpr double kToldMore = 0.5, kWidest = 3;  // of the prior's 1-sigma; of a value, either way

bool is_told(double sigma, double width) {
  return sigma < kToldMore * width && kNormal95 * sigma < std::log(kWidest);
}

TunedNoise number(const NoiseKnob& knob, const NoiseModel& found, const NoiseModel& start, double sigma) {
  NoiseModel there = found, before = start;
  const double value = knob.factor * knob.at(there);
  return {.name = knob.name,
          .unit = knob.unit,
          .start = knob.factor * knob.at(before),
          .value = value,
          .low = value * std::exp(-kNormal95 * sigma),
          .high = value * std::exp(kNormal95 * sigma),
          .determined = is_told(sigma, knob.width)};
}

// The factors of whole sigmas of receivers with a coloured error, from those of their white and their coloured part.
void add_whole_scales(const NoiseFound& found, const NoiseModel& start, std::vector<TunedNoise>& numbers) {
  for (std::size_t i = 0; i < found.best.model.gnss.size(); ++i) {
    const ReceiverNoise& receiver = found.best.model.gnss[i];
    if (!(receiver.drift > 0)) continue;
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(found.knobs.size()));
    for (std::size_t k = 0; k < found.knobs.size(); ++k) {
      NoiseModel more = found.best.model;
      found.knobs[k].at(more) *= 1 + 1e-6;
      slope(static_cast<Eigen::Index>(k)) = 1e6 * std::log(more.gnss[i].position() / receiver.position());
    }
    const double sigma = std::sqrt(slope.dot(found.covariance * slope)), value = receiver.position();
    numbers.push_back({.name = "gnss[" + std::to_string(i) + "].sigma_scale",
                       .unit = "",
                       .start = start.gnss[i].position(),
                       .value = value,
                       .low = value * std::exp(-kNormal95 * sigma),
                       .high = value * std::exp(kNormal95 * sigma),
                       .determined = is_told(sigma, std::log(10))});
  }
}

// Of the measurements in motion that a replay with this noise uses.
std::vector<SourceNis> nis_of(const Solution& solution, double start, const std::vector<Interval>& rest) {
  struct Sum {
    double nis = 0, rows = 0;
    std::size_t count = 0;
  };
  std::map<int, Sum> sums;
  for (const Innovation& i : telling(solution, start, rest)) {
    if (!was_used(i.outcome)) continue;
    Sum& sum = sums[i.source];
    sum.nis += i.nis;
    sum.rows += i.dof;
    ++sum.count;
  }
  std::vector<SourceNis> all;
  for (const auto& [source, sum] : sums)
    all.push_back({solution.sources[static_cast<std::size_t>(source)], sum.count, sum.nis / sum.rows});
  return all;
}

// The same noise with a coloured error of the first receiver, of several sizes and times.
std::vector<NoiseModel> with_drifts(const NoiseModel& model) {
  std::vector<NoiseModel> models;
  for (const double time : {5.0, 20.0, 100.0}) {
    for (const double white : {1.0, 0.5}) {
      for (const double drift : {0.3, 1.0, 3.0, 10.0}) {
        NoiseModel& m = models.emplace_back(model);
        m.gnss.front().white *= white;
        m.gnss.front().drift = drift * model.gnss.front().white;
        m.gnss.front().drift_time = time;
      }
    }
  }
  return models;
}

}  // namespace

Tuning likeliest_noise(const Log& log, const FilterOptions& options, const Start& start, std::size_t jobs,
                       const TuneProgress& progress) {
  const NoiseModel centre = noise_model(options, log);
  const NoiseSearch search(log, options, start, centre, jobs);
  const auto show = [&](double from, double to) {
    return [&progress, from, to](double part) {
      if (progress) progress(from + (to - from) * part);
    };
  };
  NoiseFound found = search.climb(centre, show(0, 0.6));
  Tuning tuning;
  tuning.likelihood_at_start = found.likelihood_at_start;
  const bool drift_stated = std::any_of(options.gnss.begin(), options.gnss.end(), [](const auto& g) { return g.drift; });
  double positions = 0;
  for (const Innovation& i : found.best.innovations)
    positions += found.best.sources[static_cast<std::size_t>(i.source)] == "gnss[0].position" ? i.dof : 0;
  if (!drift_stated && positions > 0) {
    tuning.drift_penalty = std::log(positions);  // two parameters
    const NoisePoint white = search.likeliest(found.best.model, {found.best.model});
    const NoisePoint first = search.likeliest(found.best.model, with_drifts(found.best.model));
    tuning.drift_gain = first.likelihood - white.likelihood;
    if (*tuning.drift_gain > 0) {
      NoiseFound coloured = search.climb(first.model, show(0.6, 1));
      tuning.drift_gain = search.likeliest(found.best.model, {coloured.best.model}).likelihood - white.likelihood;
      if (*tuning.drift_gain > tuning.drift_penalty) found = std::move(coloured);
    }
  }
  tuning.noise = found.best.model;
  tuning.likelihood = found.best.likelihood;
  for (std::size_t k = 0; k < found.knobs.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    tuning.numbers.push_back(
        number(found.knobs[k], found.best.model, centre, std::sqrt(found.covariance(i, i))));
  }
  add_whole_scales(found, centre, tuning.numbers);
  for (const Innovation& i : found.best.innovations) tuning.rows += static_cast<std::size_t>(i.dof);
  tuning.filter_runs = search.runs();
  tuning.nis = nis_of(search.run(log, tuning.noise, true), start.time, log.rest);
  return tuning;
}

Tuning tune(const Recording& recording, const ReplayOptions& options, const TuneOptions& how,
            const TuneProgress& progress) {
  const Log log = condition(recording, options.conditioning);
  FilterOptions filter = with_white_part(with_attitude_sigmas(options.filter, recording.attitude), log);
  const Start start = options.start ? *options.start : find_start(log, filter, options.heading).start;
  Tuning tuning = likeliest_noise(log, filter, start, how.jobs, progress);
  if (recording.imu.time.size() >= 3) {
    const ImuHealth health = imu_health(recording.imu);
    tuning.at_rest = {health.gyro.noise.maxCoeff(), health.accel.noise.maxCoeff()};
  }
  return tuning;
}

}  // namespace piste
