#include "piste/allan/allan_variance.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

#include "piste/math/interruption.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr std::size_t kChunk = 4096;  // sums that wait to be used together, so that memory is read in order
constexpr int kBinBits = 6;           // bins an octave, as bits: a bin keeps its squares, so its width matters little
constexpr int kLeastExponent = -160;  // of |Y| in bins: smaller ones are counted as zero
constexpr int kExponents = 320;

std::size_t bin_of(double y) {
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(y) & ~(1ULL << 63);
  const auto place = static_cast<std::int64_t>(bits >> (52 - kBinBits)) -
                     (static_cast<std::int64_t>(1023 + kLeastExponent) << kBinBits);
  return static_cast<std::size_t>(std::clamp<std::int64_t>(place, 0, (kExponents << kBinBits) - 1));
}

// Tukey's ρ of a squared ratio.
double rho(double r2) {
  const double u = 1 - r2 / (robust::kTuning * robust::kTuning);
  return u > 0 ? r2 * u * u * u * u : 0;
}

// E ρ(z), E ρ(z)² and E z ρ'(z) of a standard normal z, by Simpson's rule on [0, c].
struct RhoMoments {
  double mean = 0, square = 0, slope = 0;
};

RhoMoments rho_moments() {
  constexpr int kSteps = 2000;
  RhoMoments moments;
  const double step = robust::kTuning / kSteps;
  for (int i = 0; i <= kSteps; ++i) {
    const double z = i * step, u = 1 - square(z / robust::kTuning);
    const double weight = (i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2) * step / 3;
    const double density = weight * std::sqrt(2 / std::numbers::pi) * std::exp(-z * z / 2);
    moments.mean += density * rho(z * z);
    moments.square += density * square(rho(z * z));
    moments.slope += density * 2 * z * z * u * u * u * (u - 4 * square(z / robust::kTuning));
  }
  return moments;
}

}  // namespace

double robust::efficiency() {
  static const double kEfficiency = [] {
    const RhoMoments m = rho_moments();
    return 2 / ((m.square - m.mean * m.mean) / square(m.slope / 2));  // classical: var of log s² is 2 / n
  }();
  return kEfficiency;
}

std::size_t AllanCurve::samples() const { return std::accumulate(lengths.begin(), lengths.end(), std::size_t{0}); }

double AllanCurve::longest_stretch() const {
  return lengths.empty() ? 0 : interval * static_cast<double>(*std::max_element(lengths.begin(), lengths.end()));
}

AllanSums::AllanSums(bool with_robust, int octaves) : robust_(with_robust), octaves_(octaves) {}

void AllanSums::push(Level& level, double sum) const {
  const std::size_t most = (std::size_t{2} << octaves_) + 2 * kChunk;
  // A ring of a power of two; until it is full it grows, and no index changes.
  const std::size_t full = std::bit_ceil(most);
  if (level.count == level.ring.size() && level.ring.size() < full)
    level.ring.resize(std::min(full, std::max(2 * kChunk, 2 * level.ring.size())));
  level.ring[level.count++ & (level.ring.size() - 1)] = sum;
}

// Adds the terms of the sums since the last call. `stride`: samples between two sums of the level.
void AllanSums::use(Level& level, std::size_t stride) const {
  const std::size_t mask = level.ring.size() - 1;
  const bool first = stride == 1;
  const auto most = static_cast<std::size_t>(octaves_);
  for (std::size_t i = 0; first ? i <= most : i == 0; ++i) {
    const std::size_t m = std::size_t{1} << (first ? i : most);  // in sums of this level
    if (2 * m >= level.count) break;
    if (i == level.scales.size()) {
      level.scales.emplace_back().samples = m * stride;
      if (robust_) level.scales.back().bins.resize(static_cast<std::size_t>(kExponents) << kBinBits);
    }
    Scale& scale = level.scales[i];
    double squares = 0;
    const std::size_t begin = std::max(level.used, 2 * m);
    for (std::size_t k = begin; k < level.count;) {
      const std::size_t last = k & mask, middle = (k - m) & mask, earliest = (k - 2 * m) & mask;
      const std::size_t run = std::min(level.count - k, level.ring.size() - std::max({last, middle, earliest}));
      const double *c = &level.ring[last], *b = &level.ring[middle], *a = &level.ring[earliest];
      if (robust_) {
        for (std::size_t n = 0; n < run; ++n) {
          const double y = c[n] - 2 * b[n] + a[n];
          Bin& bin = scale.bins[bin_of(y)];
          ++bin.count;
          bin.squares += y * y;
          squares += y * y;
        }
      } else {
        double part[4] = {};
        std::size_t n = 0;
        for (; n + 4 <= run; n += 4) {
          for (std::size_t lane = 0; lane < 4; ++lane) {
            const double y = c[n + lane] - 2 * b[n + lane] + a[n + lane];
            part[lane] += y * y;
          }
        }
        for (; n < run; ++n) part[0] += square(c[n] - 2 * b[n] + a[n]);
        squares += (part[0] + part[1]) + (part[2] + part[3]);
      }
      k += run;
    }
    scale.squares += squares;
    scale.terms += level.count - begin;
  }
  level.used = level.count;
}

void AllanSums::use_all() {
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    if (levels_[i].used < levels_[i].count) use(levels_[i], std::size_t{1} << i);
  }
  pending_ = 0;
}

void AllanSums::add(std::span<const double> samples) {
  if (samples.empty()) return;
  if (length_ == 0) {
    // Sums stay small, and exact, if a common constant is subtracted from all samples; differences do not depend on it.
    const std::size_t looked = std::min(samples.size(), kChunk);
    offset_ = std::accumulate(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(looked), 0.0) /
              static_cast<double>(looked);
    sum_ = 0;
    if (levels_.empty()) levels_.emplace_back();
    for (Level& level : levels_) push(level, 0);
  }
  for (const double x : samples) {
    sum_ += x - offset_;
    ++length_;
    push(levels_[0], sum_);
    const auto zeros = static_cast<std::size_t>(std::countr_zero(length_));
    for (std::size_t i = 1; i <= zeros && (length_ >> i >= (std::size_t{1} << octaves_) || i < levels_.size()); ++i) {
      if (i == levels_.size()) {  // made when its first cluster can be filled, from what the level below still has
        Level level;
        const Level& below = levels_[i - 1];
        for (std::size_t k = 0; k + 1 < below.count; k += 2) push(level, below.ring[k & (below.ring.size() - 1)]);
        levels_.push_back(std::move(level));
      }
      push(levels_[i], sum_);
    }
    if (++pending_ == kChunk) {
      check_interruption();
      use_all();
    }
  }
}

void AllanSums::end_stretch() {
  if (length_ == 0) return;
  use_all();
  lengths_.push_back(length_);
  length_ = 0;
  for (Level& level : levels_) level.count = level.used = 0;
}

double AllanSums::robust_variance(const Scale& scale) const {
  static const double kMean = rho_moments().mean;
  const auto n = static_cast<double>(scale.terms);
  // From the median on: the root of mean ρ(Y / s) = E ρ, which falls with s near it.
  std::uint64_t below = 0;
  double s2 = scale.squares / n;
  for (const Bin& bin : scale.bins) {
    below += bin.count;
    if (2 * below < scale.terms) continue;
    if (bin.squares > 0) s2 = square(kSigmaOverMedian) * bin.squares / static_cast<double>(bin.count);
    break;
  }
  if (!(s2 > 0)) return 0;
  constexpr int kMost = 200;
  constexpr double kClose = 1e-12;
  for (int i = 0; i < kMost; ++i) {
    double sum = 0;
    for (const Bin& bin : scale.bins) {
      if (bin.count == 0) continue;
      const auto count = static_cast<double>(bin.count);
      sum += count * rho(bin.squares / count / s2);
    }
    const double ratio = sum / n / kMean;
    s2 *= ratio;
    if (std::abs(ratio - 1) < kClose) break;
  }
  return s2;
}

AllanCurve AllanSums::curve(double interval) {
  end_stretch();
  AllanCurve curve;
  curve.interval = interval;
  curve.lengths = lengths_;
  for (const Level& level : levels_) {
    for (const Scale& scale : level.scales) {
      if (scale.terms == 0) continue;
      const double per = 2 * square(static_cast<double>(scale.samples));
      curve.scales.push_back({scale.samples, scale.terms, scale.squares / static_cast<double>(scale.terms) / per,
                              robust_ ? robust_variance(scale) / per : kNaN});
    }
  }
  return curve;
}

AllanCurve pooled(std::span<const AllanCurve> curves) {
  AllanCurve all;
  all.interval = curves.front().interval;
  for (const AllanCurve& c : curves) {
    all.lengths.insert(all.lengths.end(), c.lengths.begin(), c.lengths.end());
    for (std::size_t i = 0; i < c.scales.size(); ++i) {
      if (i == all.scales.size()) all.scales.push_back({c.scales[i].samples, 0, 0, 0});
      AllanScale& scale = all.scales[i];
      scale.variance += static_cast<double>(c.scales[i].terms) * c.scales[i].variance;
      scale.robust += static_cast<double>(c.scales[i].terms) * c.scales[i].robust;
      scale.terms += c.scales[i].terms;
    }
  }
  for (AllanScale& scale : all.scales) {
    scale.variance /= static_cast<double>(scale.terms);
    scale.robust /= static_cast<double>(scale.terms);
  }
  return all;
}

AllanCurve allan_curve(std::span<const double> samples, double interval, bool with_robust) {
  AllanSums sums(with_robust);
  sums.add(samples);
  return sums.curve(interval);
}

}  // namespace piste
