#include "piste/tune/likeliest_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "piste/math/linear_algebra.h"
#include "tune/noise_search.h"

namespace piste {
namespace {

constexpr double kNormal95 = 1.959963984540054;
constexpr double kToldMore = 0.5, kWidest = 3;  // of the prior's 1-sigma; of a value, either way

bool is_told(double sigma, double width) { return sigma < kToldMore * width && kNormal95 * sigma < std::log(kWidest); }

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
void add_whole_scales(const NoiseFound& found, const Eigen::MatrixXd& covariance, const NoiseModel& start,
                      std::vector<TunedNoise>& numbers) {
  for (std::size_t i = 0; i < found.best.model.gnss.size(); ++i) {
    const ReceiverNoise& receiver = found.best.model.gnss[i];
    if (!(receiver.drift > 0)) continue;
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(found.knobs.size()));
    for (std::size_t k = 0; k < found.knobs.size(); ++k) {
      NoiseModel more = found.best.model;
      found.knobs[k].at(more) *= 1 + 1e-6;
      slope(static_cast<Eigen::Index>(k)) = 1e6 * std::log(more.gnss[i].position() / receiver.position());
    }
    const double sigma = std::sqrt(slope.dot(covariance * slope)), value = receiver.position();
    numbers.push_back({.name = "gnss[" + std::to_string(i) + "].sigma_scale",
                       .unit = "",
                       .start = start.gnss[i].position(),
                       .value = value,
                       .low = value * std::exp(-kNormal95 * sigma),
                       .high = value * std::exp(kNormal95 * sigma),
                       .determined = is_told(sigma, std::log(10))});
  }
}

// Of the measurements that a run uses.
std::vector<SourceNis> nis_of(const Evidence& run) {
  struct Sum {
    double nis = 0, rows = 0;
    std::size_t count = 0;
  };
  std::map<int, Sum> sums;
  for (const Innovation& i : run.innovations) {
    if (!was_used(i.outcome)) continue;
    Sum& sum = sums[i.source];
    sum.nis += i.nis;
    sum.rows += i.dof;
    ++sum.count;
  }
  std::vector<SourceNis> all;
  all.reserve(sums.size());
  for (const auto& [source, sum] : sums)
    all.push_back({run.sources[static_cast<std::size_t>(source)], sum.count, sum.nis / sum.rows});
  return all;
}

// The same noise with a coloured error of the first receiver, of several sizes and times.
std::vector<NoiseModel> with_drifts(const NoiseModel& model) {
  std::vector<NoiseModel> models;
  for (const double time : {5.0, 30.0, 150.0}) {
    for (const double white : {1.0, 0.5}) {
      for (const double drift : {1.0, 3.0}) {
        NoiseModel& m = models.emplace_back(model);
        m.gnss.front().white *= white;
        m.gnss.front().drift = drift * model.gnss.front().white;
        m.gnss.front().drift_time = time;
      }
    }
  }
  return models;
}

const NoisePoint& likeliest(const std::vector<NoisePoint>& points) {
  return *std::max_element(points.begin(), points.end(),
                           [](const NoisePoint& a, const NoisePoint& b) { return a.value < b.value; });
}

}  // namespace

Tuning likeliest_noise(const Log& log, const FilterOptions& options, const Start& start, const TuneOptions& how,
                       const TuneProgress& progress) {
  const NoiseModel centre = noise_model(options, log);
  const NoiseSearch search(log, options, start, centre, how.thorough, how.jobs);
  const auto show = [&](double from, double to) {
    return [&progress, from, to](double part) {
      if (progress) progress(from + (to - from) * part);
    };
  };
  NoiseFound found = search.climb(centre, show(0, 0.5));
  Log log_judged = search.judged(found.best.model);
  Tuning tuning;
  double positions = 0;
  for (const Innovation& i : found.best.evidence.innovations)
    positions += found.best.evidence.sources[static_cast<std::size_t>(i.source)] == "gnss[0].position" ? i.dof : 0;
  const bool stated = std::any_of(options.gnss.begin(), options.gnss.end(), [](const auto& g) { return g.drift; });
  if (how.try_drift && !stated && positions > 0) {
    tuning.drift_penalty = std::log(positions);  // two parameters
    const NoisePoint white = search.filtered(log_judged, found.best.model);
    const std::vector<NoisePoint> coarse = search.filtered(log_judged, with_drifts(found.best.model));
    const NoisePoint& first = likeliest(coarse);
    tuning.drift_gain = first.evidence.likelihood - white.evidence.likelihood;
    if (*tuning.drift_gain > 0) {
      NoiseFound coloured = search.climb(first.model, show(0.5, 0.8));
      tuning.drift_gain =
          search.filtered(log_judged, coloured.best.model).evidence.likelihood - white.evidence.likelihood;
      if (*tuning.drift_gain > tuning.drift_penalty) {
        found = std::move(coloured);
        log_judged = search.judged(found.best.model);
      }
    }
  }
  tuning.noise = found.best.model;
  tuning.likelihood_at_start = search.filtered(log_judged, centre).evidence.likelihood;
  tuning.likelihood = search.filtered(log_judged, found.best.model).evidence.likelihood;
  const Eigen::MatrixXd covariance =
      inverse(how.thorough ? observed_information(search, log_judged, found) : found.information);
  for (std::size_t k = 0; k < found.knobs.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    tuning.numbers.push_back(number(found.knobs[k], found.best.model, centre, std::sqrt(covariance(i, i))));
  }
  add_whole_scales(found, covariance, centre, tuning.numbers);
  tuning.rows = static_cast<std::size_t>(found.best.evidence.rows);
  tuning.nis = nis_of(search.gated(found.best.model));
  tuning.filter_runs = search.runs();
  return tuning;
}

}  // namespace piste
