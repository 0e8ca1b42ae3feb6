#include "piste/allan/noise_process.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr std::array<double, 3> kWeights{1, -2, 1};  // of the sums in Y

// e^(−x) − 1 + x, without x²/2 if `cubic`: a second difference of sums does not see x².
double beyond_line(double x, bool cubic) {
  constexpr double kSmall = 0.3;
  if (!cubic) return std::expm1(-x) + x;
  if (x > kSmall) return std::expm1(-x) + x - x * x / 2;
  double term = -x * x * x / 6, sum = term;
  for (int n = 4; n < 16; ++n) sum += term *= -x / n;
  return sum;
}

/// One process by its generalised covariance.
class LagCovariance {
 public:
  LagCovariance(const NoiseProcess& process, double interval) : process_(process), interval_(interval) {
    const double size2 = square(process.size);
    switch (process.kind) {
      case ProcessKind::kQuantisation:
        factor_ = size2 / square(interval);
        break;
      case ProcessKind::kWhite:
        factor_ = -size2 / interval / 2;
        break;
      case ProcessKind::kBiasInstability:
        factor_ = size2 / (2 * std::numbers::pi);
        break;
      case ProcessKind::kRandomWalk:
        factor_ = size2 * interval / 12;
        break;
      case ProcessKind::kGaussMarkov:
        decay_ = interval / process.correlation_time;
        factor_ = -size2 / (4 * square(std::sinh(decay_ / 2)));
        excess_ = decay_ < 0.1 ? decay_ * decay_ * decay_ / 6 * (1 + decay_ * decay_ / 20) : std::sinh(decay_) - decay_;
        break;
      case ProcessKind::kRamp:
        break;
    }
  }

  // cov(Y_j(t), Y_k(t − d)) for clusters of a and b samples.
  double operator()(double a, double b, double d) const {
    const bool apart = d >= 2 * b || d <= -2 * a;  // no sample is in both
    switch (process_.kind) {
      case ProcessKind::kRamp:
        return 0;
      case ProcessKind::kWhite:
      case ProcessKind::kRandomWalk:
        if (apart) return 0;
        break;
      case ProcessKind::kGaussMarkov:
        if (apart) return far_gauss_markov(a, b, d);
        break;
      case ProcessKind::kBiasInstability: {
        constexpr double kFar = 8;  // times both clusters: the next term of the series is a hundredth there
        const double between = d + a - b;
        if (std::abs(between) > kFar * (a + b)) return -2 * factor_ * square(a * b / between);
        break;
      }
      case ProcessKind::kQuantisation:
        break;
    }
    const bool cubic = decay_ * 2 * (a + b) < 1;
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double h = std::abs(d + static_cast<double>(i) * a - static_cast<double>(k) * b);
        sum += kWeights[i] * kWeights[k] * generalised(h, cubic);
      }
    }
    return factor_ * sum;
  }

  // Variance of Y for clusters of m samples: as covariances with themselves, with equal distances taken together.
  double variance(double m) const {
    if (process_.kind == ProcessKind::kRamp) return 0;
    const bool cubic = decay_ * 4 * m < 1;
    return factor_ * (6 * generalised(0, cubic) - 8 * generalised(m, cubic) + 2 * generalised(2 * m, cubic));
  }

  double allan_variance(double m) const { return (variance(m) + square(mean(m))) / (2 * m * m); }

  // Mean of Y.
  double mean(double m) const { return process_.kind == ProcessKind::kRamp ? process_.size * interval_ * m * m : 0; }

 private:
  double generalised(double h, bool cubic) const {
    switch (process_.kind) {
      case ProcessKind::kQuantisation:
        return h == 0 ? 1 : 0;
      case ProcessKind::kWhite:
        return h;
      case ProcessKind::kBiasInstability:
        return h > 0 ? h * h * std::log(h) : 0;
      case ProcessKind::kRandomWalk:
        return h * (h * h - 1);
      case ProcessKind::kGaussMarkov:
        return beyond_line(decay_ * h, cubic) + h * excess_;
      case ProcessKind::kRamp:
        break;
    }
    return 0;
  }

  // Of clusters that have no sample in common: the covariance of two sums of exponentials is a product.
  double far_gauss_markov(double a, double b, double d) const {
    const double gap = d >= 2 * b ? d - 2 * b : -2 * a - d;
    const double edge = -std::expm1(-decay_);
    const auto sum = [&](double m) { return square(std::expm1(-decay_ * m)) / edge; };
    return -square(process_.size) * std::exp(-decay_ * (gap + 1)) * sum(a) * sum(b);  // a rise against a fall
  }

  NoiseProcess process_;
  double interval_, factor_ = 0, decay_ = 0, excess_ = 0;
};

/// Stretches of equal length.
struct Stretches {
  double length, count;
};

// At most so many lengths: where there are more, neighbouring ones are taken together.
std::vector<Stretches> grouped(std::vector<std::size_t> lengths) {
  constexpr std::size_t kMost = 24;
  std::sort(lengths.begin(), lengths.end());
  std::vector<Stretches> groups;
  for (const std::size_t n : lengths) {
    const auto length = static_cast<double>(n);
    if (groups.empty() || groups.back().length != length) groups.push_back({length, 0});
    ++groups.back().count;
  }
  while (groups.size() > kMost) {
    std::vector<Stretches> fewer;
    for (std::size_t i = 0; i < groups.size(); i += 2) {
      Stretches g = groups[i];
      if (i + 1 < groups.size()) {
        const double count = g.count + groups[i + 1].count;
        g = {(g.length * g.count + groups[i + 1].length * groups[i + 1].count) / count, count};
      }
      fewer.push_back(g);
    }
    groups = std::move(fewer);
  }
  return groups;
}

// Number of pairs Y_j(t), Y_k(t − d).
double pairs(const std::vector<Stretches>& groups, double a, double b, double d) {
  double n = 0;
  for (const Stretches& g : groups) {
    const double of_j = g.length - 2 * a + 1, of_k = g.length - 2 * b + 1;
    if (of_j <= 0 || of_k <= 0) continue;
    n += g.count * std::max(0.0, std::min(of_k, of_j - d) - std::max(0.0, -d));
  }
  return n;
}

// Σ f(d) over the integers first ≤ d ≤ last, of a function that is smooth there and changes most near an end. Terms at
// the ends are added singly. The others are summed by three-point Gauss quadrature in stretches that grow with the
// distance from the ends.
template <class F>
double sum_between(double first, double last, bool from_first, bool from_last, const F& f) {
  constexpr double kSingly = 6, kGrowth = 2;
  constexpr std::array<double, 3> kNodes{-0.7745966692414834, 0, 0.7745966692414834}, kParts{5 / 9., 8 / 9., 5 / 9.};
  double sum = 0;
  const auto panel = [&](double low, double high) {  // the whole numbers low … high
    const double middle = (low + high) / 2, half = (high - low + 1) / 2;
    for (std::size_t i = 0; i < 3; ++i) sum += half * kParts[i] * f(middle + half * kNodes[i]);
  };
  double low = first, high = last, step_low = 3, step_high = 3;
  for (int i = 0; i < kSingly && low <= high && from_first; ++i) sum += f(low++);
  for (int i = 0; i < kSingly && low <= high && from_last; ++i) sum += f(high--);
  while (low <= high) {
    if (from_first) {
      const double to =
          std::min(high, from_last ? std::min(low + step_low - 1, std::max(low, std::floor((low + high) / 2)))
                                   : low + step_low - 1);
      panel(low, to);
      low = to + 1;
      step_low *= kGrowth;
    }
    if (from_last && low <= high) {
      const double to = std::max(low, high - step_high + 1);
      panel(to, high);
      high = to - 1;
      step_high *= kGrowth;
    }
  }
  return sum;
}

}  // namespace

std::string_view name_of(ProcessKind kind) {
  switch (kind) {
    case ProcessKind::kQuantisation:
      return "quantisation";
    case ProcessKind::kWhite:
      return "white noise";
    case ProcessKind::kBiasInstability:
      return "bias instability";
    case ProcessKind::kGaussMarkov:
      return "Gauss-Markov";
    case ProcessKind::kRandomWalk:
      return "random walk";
    case ProcessKind::kRamp:
      return "ramp";
  }
  return "";
}

std::string key_of(ProcessKind kind) {
  std::string key(name_of(kind));
  for (char& c : key) c = c == ' ' || c == '-' ? '_' : c == 'G' ? 'g' : c == 'M' ? 'm' : c;
  return key;
}

double allan_variance(const NoiseProcess& process, std::size_t samples, double interval) {
  return LagCovariance(process, interval).allan_variance(static_cast<double>(samples));
}

Eigen::VectorXd allan_variances(const NoiseProcess& process, const AllanCurve& curve, std::size_t count) {
  const LagCovariance covariance(process, curve.interval);
  Eigen::VectorXd out(static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) {
    out(static_cast<Eigen::Index>(i)) = covariance.allan_variance(static_cast<double>(curve.scales[i].samples));
  }
  return out;
}

double allan_variance(std::span<const NoiseProcess> processes, std::size_t m, double interval) {
  double sum = 0;
  for (const NoiseProcess& p : processes) sum += allan_variance(p, m, interval);
  return sum;
}

std::pair<double, double> size_interval(double size, double sigma_log, double probability) {
  constexpr double kLeastFreedom = 0.05, kNormal = 1e6;  // of χ², which is normal beyond
  const double freedom = 1 / (2 * square(sigma_log));
  if (!(sigma_log > 0) || !(freedom > kLeastFreedom)) return {0, std::numeric_limits<double>::infinity()};
  if (freedom > kNormal) {
    const double reach = std::exp(normal_quantile((1 + probability) / 2) * sigma_log);
    return {size / reach, size * reach};
  }
  return {size * std::sqrt(freedom / chi_squared_quantile((1 + probability) / 2, freedom)),
          size * std::sqrt(freedom / chi_squared_quantile((1 - probability) / 2, freedom))};
}

Eigen::MatrixXd allan_covariance(std::span<const NoiseProcess> processes, const AllanCurve& curve) {
  std::vector<LagCovariance> parts;
  parts.reserve(processes.size());
  for (const NoiseProcess& p : processes) parts.emplace_back(p, curve.interval);
  const std::vector<Stretches> groups = grouped(curve.lengths);
  const double longest = groups.empty() ? 0 : groups.back().length;
  const auto size = static_cast<Eigen::Index>(curve.scales.size());
  Eigen::MatrixXd V = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    for (Eigen::Index k = 0; k <= j; ++k) {
      const auto a = static_cast<double>(curve.scales[static_cast<std::size_t>(j)].samples);
      const auto b = static_cast<double>(curve.scales[static_cast<std::size_t>(k)].samples);
      double mean_a = 0, mean_b = 0;
      for (const LagCovariance& p : parts) {
        mean_a += p.mean(a);
        mean_b += p.mean(b);
      }
      const auto term = [&](double d) {
        const double n = pairs(groups, a, b, d);
        if (n == 0) return 0.0;
        double c = 0;
        for (const LagCovariance& p : parts) c += p(a, b, d);
        return n * (2 * c * c + 4 * mean_a * mean_b * c);
      };
      std::vector<double> kinks{0};
      for (int i = 0; i < 3; ++i) {
        for (int l = 0; l < 3; ++l) kinks.push_back(l * b - i * a);
      }
      std::sort(kinks.begin(), kinks.end());
      kinks.erase(std::unique(kinks.begin(), kinks.end()), kinks.end());
      double sum = 0;
      for (std::size_t i = 0; i < kinks.size(); ++i) {
        sum += term(kinks[i]);
        if (i + 1 < kinks.size()) sum += sum_between(kinks[i] + 1, kinks[i + 1] - 1, true, true, term);
      }
      sum += sum_between(kinks.back() + 1, longest, true, false, term);
      sum += sum_between(-longest, kinks.front() - 1, false, true, term);
      const double terms_a = pairs(groups, a, a, 0), terms_b = pairs(groups, b, b, 0);
      V(j, k) = V(k, j) = sum / (terms_a * terms_b * 4 * square(a * b));
    }
  }
  return V;
}

}  // namespace piste
