#include "coarse_offset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>

#include "math/fourier.h"
#include "piste/core/error.h"
#include "piste/math/interruption.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kNormCell = 0.05;     // s: of the norms
constexpr double kIndependent = 0.25;  // s: so long the rates of a moving body are correlated

// Sums of the first i values, and of their squares.
struct PrefixSums {
  std::vector<double> sum, square;
  explicit PrefixSums(const std::vector<double>& values) : sum(values.size() + 1), square(values.size() + 1) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      sum[i + 1] = sum[i] + values[i];
      square[i + 1] = square[i] + values[i] * values[i];
    }
  }
};

std::vector<double> without_mean(std::vector<double> values) {
  double mean = 0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (double& v : values) v -= mean;
  return values;
}

// Σ_i x[i + lag] y[i], for all lags; a negative lag stands at size + lag.
std::vector<double> products(std::vector<double> x, std::vector<double> y) {
  std::size_t size = 1;
  while (size < x.size() + y.size()) size *= 2;
  x.resize(size);
  y.resize(size);
  FourierTransform fourier;
  std::vector<std::complex<double>> X = fourier.forward(x);
  const std::vector<std::complex<double>> Y = fourier.forward(y);
  for (std::size_t i = 0; i < X.size(); ++i) X[i] *= std::conj(Y[i]);
  return fourier.inverse(X);
}

}  // namespace

RateNorms rate_norms(const std::vector<ImuSample>& imu, double step) {
  RateNorms norms;
  norms.start = imu.front().time - imu.front().interval;
  norms.step = step;
  const auto cells = static_cast<std::size_t>((imu.back().time - norms.start) / step);
  std::vector<Vector3d> angle(cells, Vector3d::Zero());
  for (const ImuSample& s : imu) {
    // A sample on the border of two cells is shared between them.
    const double from = (s.time - s.interval - norms.start) / step, to = (s.time - norms.start) / step;
    for (auto i = static_cast<std::size_t>(std::max(0.0, from)); i < cells && static_cast<double>(i) < to; ++i) {
      const double part = std::min(to, static_cast<double>(i) + 1) - std::max(from, static_cast<double>(i));
      angle[i] += s.dtheta * (part / (to - from));
    }
  }
  norms.value.reserve(cells);
  for (const Vector3d& a : angle) norms.value.push_back(a.norm() / step);
  return norms;
}

CoarseOffset correlate(const RateNorms& body, const RateNorms& reference, double shortest) {
  constexpr double kNeighbourhood = 0.5;  // s
  const std::vector<double> x = without_mean(body.value), y = without_mean(reference.value);
  const auto nx = static_cast<std::ptrdiff_t>(x.size()), ny = static_cast<std::ptrdiff_t>(y.size());
  CoarseOffset out;
  if (nx < 3 || ny < 3) return out;
  const PrefixSums sx(x), sy(y);
  const std::vector<double> xy = products(x, y);
  const auto least = std::max<std::ptrdiff_t>(3, std::lround(shortest / body.step));
  const double floor_x = 1e-9 * sx.square.back(), floor_y = 1e-9 * sy.square.back();

  std::vector<double> evidence;
  for (std::ptrdiff_t lag = -ny + least; lag <= nx - least; ++lag) {
    // x[i + lag] paired with y[i], i in [from, to).
    const std::ptrdiff_t from = std::max<std::ptrdiff_t>(0, -lag), to = std::min(ny, nx - lag);
    if (to - from < least) continue;
    const auto n = static_cast<double>(to - from);
    const auto part = [](const std::vector<double>& sums, std::ptrdiff_t a, std::ptrdiff_t b) {
      return sums[static_cast<std::size_t>(b)] - sums[static_cast<std::size_t>(a)];
    };
    const double mx = part(sx.sum, from + lag, to + lag), my = part(sy.sum, from, to);
    const double vx = part(sx.square, from + lag, to + lag) - mx * mx / n;
    const double vy = part(sy.square, from, to) - my * my / n;
    const double cross = xy[static_cast<std::size_t>(lag < 0 ? lag + static_cast<std::ptrdiff_t>(xy.size()) : lag)];
    const double r = vx > floor_x && vy > floor_y ? (cross - mx * my / n) / std::sqrt(vx * vy) : 0;
    out.peak.offset.push_back(body.start - reference.start + static_cast<double>(lag) * body.step);
    out.peak.correlation.push_back(r);
    evidence.push_back(evidence_over(r, 0, n * body.step));
  }
  if (evidence.empty()) return out;
  const auto best = std::max_element(evidence.begin(), evidence.end()) - evidence.begin();
  const auto at = [&](std::ptrdiff_t i) { return out.peak.correlation[static_cast<std::size_t>(i)]; };
  out.evidence = evidence[static_cast<std::size_t>(best)];
  out.peak.peak = at(best);
  out.peak.peak_offset = out.peak.offset[static_cast<std::size_t>(best)];
  const auto last = static_cast<std::ptrdiff_t>(evidence.size()) - 1;
  if (best > 0 && best < last) {
    const double before = at(best - 1), after = at(best + 1), bend = before - 2 * at(best) + after;
    if (bend < 0) out.peak.peak_offset += 0.5 * body.step * (before - after) / bend;
  }
  // The rival: the most likely offset outside the peak itself.
  std::ptrdiff_t left = best, right = best;
  const auto apart = static_cast<std::ptrdiff_t>(std::lround(kNeighbourhood / body.step));
  while (left > 0 && (at(left - 1) <= at(left) || best - left < apart)) --left;
  while (right < last && (at(right + 1) <= at(right) || right - best < apart)) ++right;
  out.over_rival = out.evidence;
  for (std::ptrdiff_t i = 0; i <= last; ++i) {
    if (i >= left && i <= right) continue;
    if (out.evidence - evidence[static_cast<std::size_t>(i)] < out.over_rival) {
      out.over_rival = out.evidence - evidence[static_cast<std::size_t>(i)];
    }
    out.peak.rival = std::max(out.peak.rival, at(i));
  }
  return out;
}

double evidence_over(double high, double low, double seconds) {
  const auto lost = [](double r) { return std::log1p(-std::clamp(r * std::abs(r), 0.0, 1 - 1e-12)); };
  return 0.5 * seconds / kIndependent * (lost(low) - lost(high));
}

namespace {

RateNorms stretched(RateNorms norms, double ratio) {
  norms.start *= ratio;
  norms.step *= ratio;
  return norms;
}

// The same norms in cells of another length, by linear interpolation between the middles of the old cells.
RateNorms in_cells(const RateNorms& norms, double step) {
  RateNorms out{norms.start, step, {}};
  const auto cells = static_cast<std::size_t>(static_cast<double>(norms.value.size()) * norms.step / step);
  for (std::size_t i = 0; i < cells; ++i) {
    const double at = (static_cast<double>(i) + 0.5) * step / norms.step - 0.5;
    const double bounded = std::clamp(at, 0.0, static_cast<double>(norms.value.size() - 1));
    const auto before = std::min(static_cast<std::size_t>(bounded), norms.value.size() - 2);
    const double part = bounded - static_cast<double>(before);
    out.value.push_back((1 - part) * norms.value[before] + part * norms.value[before + 1]);
  }
  return out;
}

// A wrong rate of the body IMU's clock that fits its signal far better than the right one, if there is any.
std::optional<double> wrong_clock(const RateNorms& body, const RateNorms& reference, const CoarseOffset& honest,
                                  double shortest) {
  constexpr double kStep = 0.0025, kFurthest = 0.25, kClear = 1.3;
  double best_ratio = 1, best = kClear * honest.evidence + kEvident;
  for (int i = -static_cast<int>(kFurthest / kStep); i <= static_cast<int>(kFurthest / kStep); ++i) {
    check_interruption();
    const double ratio = 1 + i * kStep;
    RateNorms slower = stretched(body, 1 / ratio);
    const CoarseOffset found = correlate(in_cells(slower, body.step), reference, shortest);
    if (found.evidence <= best) continue;
    best = found.evidence;
    best_ratio = ratio;
  }
  if (std::abs(best_ratio - 1) < kStep / 2) return std::nullopt;
  return best_ratio;
}

double rms(const std::vector<ImuSample>& imu) {
  Vector3d mean = Vector3d::Zero();
  double square = 0;
  for (const ImuSample& s : imu) mean += s.dtheta / s.interval / static_cast<double>(imu.size());
  for (const ImuSample& s : imu) square += (s.dtheta / s.interval - mean).squaredNorm();
  return std::sqrt(square / static_cast<double>(imu.size()));
}

}  // namespace

CoarseOffset find_offset(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference, double shortest,
                         const std::string& name) {
  const RateNorms b = rate_norms(body, kNormCell), r = rate_norms(reference, kNormCell);
  CoarseOffset found = correlate(b, r, shortest);
  constexpr double kGood = 0.98;
  if (found.peak.peak < kGood) {
    if (const auto ratio = wrong_clock(b, r, found, shortest)) {
      // A jump amid the log looks like a rate that is a little wrong.
      constexpr double kLittle = 0.02;
      const double apart = (*ratio - 1) * (body.back().time - body.front().time);
      const std::string jump =
          std::abs(*ratio - 1) < kLittle ? fmt::format("; or did it jump by some {:.1f} s?", std::abs(apart)) : "";
      throw DataError(name,
                      fmt::format("the clock of the body IMU runs {:+.2f} % against that of the reference; a wrong "
                                  "sample rate or unit of time? Clocks are off by parts in a million{}",
                                  100 * (*ratio - 1), jump));
    }
  }
  if (found.evidence < kEvident) {
    throw DataError(name,
                    fmt::format("the two IMUs have no motion in common that determines the offset of their clocks: "
                                "the norms of their rates (rms {:.3g} and {:.3g} deg/s) correlate by {:.2f} at "
                                "best; are the logs of the same run, and does it hold motion?",
                                kDegreesPerRadian * rms(body), kDegreesPerRadian * rms(reference), found.peak.peak));
  }
  if (found.over_rival < kEvident) {
    throw DataError(name,
                    fmt::format("the motion repeats itself: the offset of the clocks may be {:.3f} s, and others "
                                "are as likely (correlation {:.3f} and {:.3f}); take a longer log, or one with an "
                                "irregular motion",
                                found.peak.peak_offset, found.peak.peak, found.peak.rival));
  }
  return found;
}

}  // namespace piste
