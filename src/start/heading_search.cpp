#include "start/heading_search.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

// 1-sigma of the attitude about down, in the local level `q_wn`.
double heading_sigma(const Filter& filter, const Quaterniond& q_wn) {
  const Vector3d down = q_wn * Vector3d::UnitZ();
  return std::sqrt(down.dot(filter.covariance().block<3, 3>(6, 6) * down));
}

}  // namespace

HeadingSearch::HeadingSearch(const FilterOptions& options, const World& world, std::span<const Start> starts)
    : world_(world), options_(options.behaviour.start) {
  all_.reserve(starts.size());
  for (const Start& start : starts) all_.push_back({.filter = Filter(options, world, start), .start = all_.size()});
}

void HeadingSearch::add(int sensor, const AnyFix& fix) {
  for (Hypothesis& h : all_) h.filter.add(sensor, fix);
}

bool HeadingSearch::add(const ImuSample& sample) {
  bool epoch = false, measured = false;
  std::erase_if(all_, [&](Hypothesis& h) {
    try {
      epoch = h.filter.add(sample) || epoch;
    } catch (const DataError&) {
      return true;
    }
    for (const Innovation& i : h.filter.innovations()) {
      if (sample.at_rest) break;  // sway is no evidence on the heading
      h.nis += std::min(i.nis, i.gate > 0 ? options_.most_gates * i.gate : i.nis);
      h.log_determinant += i.log_determinant;
      h.rows += i.dof;
      measured = true;
    }
    h.filter.clear_innovations();
    return false;
  });
  if (all_.empty()) {
    throw DataError("start", "the filter diverges with every heading: check units, axes and time stamps of the logs");
  }
  if (measured) weigh();
  return epoch;
}

void HeadingSearch::weigh() {
  // Where a delay is estimated, each hypothesis uses a fix at its own time, so that some are a fix ahead. A fix that
  // one of them has not used yet counts as the mean of those used: it must not decide.
  double most = 0;
  for (const Hypothesis& h : all_) most = std::max(most, h.rows);
  const auto cost = [most](const Hypothesis& h, double scale) {
    return h.rows > 0 ? (h.nis / scale + h.log_determinant) * most / h.rows : 0;
  };
  const auto best = std::min_element(all_.begin(), all_.end(),
                                     [&](const Hypothesis& a, const Hypothesis& b) { return cost(a, 1) < cost(b, 1); });
  const double scale = std::max(1.0, best->nis / std::max(1.0, best->rows)), least = cost(*best, scale);
  for (Hypothesis& h : all_) h.weight = std::exp(-0.5 * (cost(h, scale) - least));
  std::erase_if(all_, [this](const Hypothesis& h) { return h.weight < options_.least_weight; });
  const auto heaviest = std::max_element(all_.begin(), all_.end(),
                                         [](const Hypothesis& a, const Hypothesis& b) { return a.weight < b.weight; });
  best_ = static_cast<std::size_t>(heaviest - all_.begin());
}

Quaterniond HeadingSearch::local_level() const { return Quaterniond(world_.rotation_wn(best().estimate().p_wb)); }

// Rotation about down from the best hypothesis to this one [rad].
double HeadingSearch::apart(const Hypothesis& h, const Quaterniond& q_wn) const {
  const Quaterniond turn = h.filter.estimate().q_wb * best().estimate().q_wb.conjugate();
  const double down = turn.vec().dot(q_wn * Vector3d::UnitZ());
  return 2 * std::remainder(std::atan2(down, turn.w()), std::numbers::pi);
}

HeadingEstimate HeadingSearch::heading() const {
  const Quaterniond q_wn = local_level();
  double total = 0, within = 0;
  std::complex<double> mean = 0;
  for (const Hypothesis& h : all_) {
    total += h.weight;
    within += h.weight * square(heading_sigma(h.filter, q_wn));
    mean += h.weight * std::polar(1.0, apart(h, q_wn));
  }
  const double length = std::clamp(std::abs(mean) / total, 1e-6, 1.0);
  const double between = -2 * std::log(length);  // of a wrapped normal distribution (Mardia and Jupp 2000, 3.5.10)
  return {
      std::remainder(to_euler(q_wn.conjugate() * best().estimate().q_wb).z() + std::arg(mean), 2 * std::numbers::pi),
      std::min(std::sqrt(within / total + between), kUnknownHeading)};
}

bool HeadingSearch::resolved() const {
  const Quaterniond q_wn = local_level();
  const double sigma = heading_sigma(best(), q_wn);
  if (sigma > options_.sure) return false;
  return std::all_of(all_.begin(), all_.end(), [&](const Hypothesis& h) {
    return std::abs(apart(h, q_wn)) <= options_.agree * sigma + options_.agree_apart || h.weight < options_.outvoted;
  });
}

}  // namespace piste
