#include "clock_match.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "math/fourier.h"
#include "piste/math/interruption.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kGridStep = 0.1, kWidth = 0.6;  // s: of the grid, and of the means on it
constexpr double kMostCells = 60000;
constexpr double kRatesCorrelated = 0.5;  // s: correlation time of the rates of a moving body
constexpr double kHasDirection = 1.5;     // m/s from which a track has a direction
constexpr double kShortestOverlap = 10;   // s that two signals must have in common
constexpr double kCertain = 30, kOverRival = 15;
// A bicycle that leans turns about other axes than the vertical. Its correlation was 0.93 to 0.97, with evidence 236 to
// 317 above any other offset. Without stationary times in the logs these were 0.86 and 80. Skis compared with the track
// of a bicycle reached 0.92 and 115, but no window of their motion fitted that track.
constexpr double kCertainCorrelation = 0.95, kLeastCorrelation = 0.85, kBeyondDoubt = 150;
// A calm hour shakes the IMU more than it turns: the correlation was 0.64, but the evidence 1060 above any other
// offset, and nearly twice that of the best rival. The motion must fit the track in addition.
constexpr double kTimesRival = 1.5;
constexpr double kDetermined = 0.5;  // R² of a turn rate that determines the gyroscopes' unit
constexpr double kAlongDown = 0.5;   // of R² on all three axes: with less, the mean force is not along down

using Series = std::vector<double>;

// Values at equally spaced times, and weights that mark where there are values.
struct Signal {
  Series weight;  // 0 or 1
  std::array<Series, 3> value;
};

// Signals of the track: turn rate, and acceleration along and across, each with its own weight.
struct TrackSignals {
  std::array<Series, 3> weight, value;
};

struct Grid {
  double step, width;
  std::size_t cells(double begin, double end) const { return static_cast<std::size_t>((end - begin) / step) + 1; }
};

Grid grid_of(const ImuIntegral& imu, const Track& track) {
  const double longest = std::max(imu.end() - imu.start(), track.end() - track.start());
  const double step = std::max(kGridStep, longest / kMostCells);
  return {step, std::max({kWidth, 1.2 * track.interval(), step})};
}

// The rate about down, of the mean force over the same time.
double rate_about_down(const Vector3d& rate, const Vector3d& force) { return -rate.dot(force.normalized()); }

// Rates, forces, and the rate about down alone.
std::array<Signal, 3> imu_signals(const ImuIntegral& imu, const Grid& grid) {
  std::array<Signal, 3> out;
  const std::size_t n = grid.cells(imu.start(), imu.end());
  for (Signal& s : out) {
    s.weight.assign(n, 0);
    s.value.fill(Series(n, 0));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double t = imu.start() + static_cast<double>(i) * grid.step;
    const double begin = t - grid.width / 2, end = t + grid.width / 2;
    if (!imu.covers(begin, end)) continue;
    const auto a = imu.at(begin), b = imu.at(end);
    const Vector3d rate = (b.angle - a.angle) / grid.width, force = (b.velocity - a.velocity) / grid.width;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out[0].value[axis][i] = rate(static_cast<Eigen::Index>(axis));
      out[1].value[axis][i] = force(static_cast<Eigen::Index>(axis));
    }
    out[2].value[0][i] = rate_about_down(rate, force);
    for (Signal& s : out) s.weight[i] = 1;
  }
  // Means are subtracted, so that sums of squares do not lose digits.
  for (Signal& s : out) {
    double count = 0;
    for (const double w : s.weight) count += w;
    for (Series& v : s.value) {
      double sum = 0;
      for (const double x : v) sum += x;
      for (std::size_t i = 0; i < n; ++i) v[i] = count > 0 ? (v[i] - sum / count) * s.weight[i] : 0;
    }
  }
  return out;
}

// Clamps outliers: one wrong velocity would outweigh a minute of motion.
void hold_outliers(Series& value, const Series& weight) {
  constexpr double kMost = 3, kTail = 0.95;
  std::vector<double> sizes;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (weight[i] > 0) sizes.push_back(std::abs(value[i]));
  }
  if (sizes.empty()) return;
  const double most = kMost * quantile(std::move(sizes), kTail);
  for (double& v : value) v = std::clamp(v, -most, most);
}

TrackSignals track_signals(const Track& track, const Grid& grid) {
  TrackSignals out;
  const std::size_t n = grid.cells(track.start(), track.end());
  out.weight.fill(Series(n, 0));
  out.value.fill(Series(n, 0));
  for (std::size_t i = 0; i < n; ++i) {
    const double t = track.start() + static_cast<double>(i) * grid.step;
    const auto before = track.velocity(t - grid.width / 2), now = track.velocity(t),
               after = track.velocity(t + grid.width / 2);
    if (!before || !now || !after) continue;
    const Eigen::Vector2d a = (*after - *before).head<2>() / grid.width, v = now->head<2>();
    const double speed = v.norm();
    const Eigen::Vector2d e = v / std::max(speed, kHasDirection);
    const double across = e.x() * a.y() - e.y() * a.x();
    if (speed > kHasDirection) {
      out.value[0][i] = across / speed;
      out.weight[0][i] = 1;
    }
    out.value[1][i] = e.dot(a);
    out.value[2][i] = across;
    out.weight[1][i] = out.weight[2][i] = 1;
  }
  for (std::size_t c = 0; c < 3; ++c) hold_outliers(out.value[c], out.weight[c]);
  return out;
}

// All sums that a regression of one series on three needs, at every lag, by the Fourier transform.
class Correlator {
 public:
  Correlator(std::size_t nx, std::size_t ny) {
    while (size_ < nx + ny) size_ *= 2;
  }
  std::vector<std::complex<double>> transform(Series x) {
    x.resize(size_);
    return fourier_.forward(x);
  }
  // Σ_j x[j + lag] y[j]; a negative lag stands at size + lag.
  Series correlate(const std::vector<std::complex<double>>& X, const std::vector<std::complex<double>>& Y) {
    std::vector<std::complex<double>> product(X.size());
    for (std::size_t i = 0; i < X.size(); ++i) product[i] = X[i] * std::conj(Y[i]);
    return fourier_.inverse(product);
  }
  std::size_t size() const { return size_; }

 private:
  FourierTransform fourier_;
  std::size_t size_ = 1;
};

Series times(const Series& a, const Series& b) {
  Series out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] * b[i];
  return out;
}

// The sums of one lag, and the regression from them.
struct Regression {
  double n = 0, y = 0, yy = 0;
  Vector3d x = Vector3d::Zero(), xy = Vector3d::Zero();
  Matrix3d xx = Matrix3d::Zero();

  // R² of y on x, and the coefficients. Variances below the floors count as zero.
  double fit(double floor_x, double floor_y, Vector3d& b) const {
    b.setZero();
    const double variance = yy / n - y / n * y / n;
    if (!(variance > floor_y)) return 0;
    const Matrix3d C = xx / n - x / n * (x / n).transpose() + floor_x * Matrix3d::Identity();
    const Vector3d c = xy / n - x / n * (y / n);
    b = C.llt().solve(c);
    return std::clamp(c.dot(b) / variance, 0.0, 1 - 1e-9);
  }
};

double variance(const Series& value, const Series& weight) {
  double n = 0, sum = 0, square = 0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    n += weight[i];
    sum += weight[i] * value[i];
    square += weight[i] * value[i] * value[i];
  }
  return n > 0 ? square / n - sum / n * sum / n : 0;
}

// R² and seconds in common of one pair of signals, at every lag from −(ny − 1) to nx − 1.
struct Channel {
  Series r2, seconds;

  double evidence(std::size_t lag) const {
    return seconds[lag] > 0 ? -0.5 * seconds[lag] / kRatesCorrelated * std::log1p(-r2[lag]) - 3 : 0;
  }
};

Channel channel(Correlator& fft, const Signal& x, const Series& y, const Series& weight, double step) {
  check_interruption();
  const std::size_t nx = x.weight.size(), ny = y.size();
  const auto M = fft.transform(weight), Y = fft.transform(times(weight, y)),
             YY = fft.transform(times(weight, times(y, y)));
  const auto U = fft.transform(x.weight);
  const Series n = fft.correlate(U, M), sy = fft.correlate(U, Y), syy = fft.correlate(U, YY);
  std::array<Series, 3> sx, sxy;
  std::array<std::array<Series, 3>, 3> sxx;
  for (std::size_t i = 0; i < 3; ++i) {
    check_interruption();
    const auto X = fft.transform(x.value[i]);
    sx[i] = fft.correlate(X, M);
    sxy[i] = fft.correlate(X, Y);
    for (std::size_t j = 0; j <= i; ++j) sxx[i][j] = fft.correlate(fft.transform(times(x.value[i], x.value[j])), M);
  }
  double floor_x = 0;
  for (const Series& v : x.value) floor_x += 1e-4 * variance(v, x.weight);
  const double floor_y = 1e-2 * variance(y, weight);
  Channel out{Series(nx + ny - 1, 0), Series(nx + ny - 1, 0)};
  for (std::size_t k = 0; k < nx + ny - 1; ++k) {
    const std::size_t at = k + 1 >= ny ? k + 1 - ny : fft.size() + k + 1 - ny;
    Regression r{.n = n[at], .y = sy[at], .yy = syy[at]};
    if (r.n * step < kShortestOverlap) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = static_cast<Eigen::Index>(i);
      r.x(a) = sx[i][at];
      r.xy(a) = sxy[i][at];
      for (std::size_t j = 0; j <= i; ++j) {
        const auto b = static_cast<Eigen::Index>(j);
        r.xx(a, b) = r.xx(b, a) = sxx[i][j][at];
      }
    }
    Vector3d coefficients;
    out.r2[k] = r.fit(floor_x, floor_y, coefficients);
    out.seconds[k] = r.n * step;
  }
  return out;
}

}  // namespace

std::optional<ClockMatch> match_clocks(const ImuIntegral& imu, const Track& track,
                                       const std::optional<Interval>& within) {
  if (track.empty()) return std::nullopt;
  const Grid grid = grid_of(imu, track);
  const auto sensors = imu_signals(imu, grid);
  const TrackSignals motion = track_signals(track, grid);
  const std::size_t nx = sensors[0].weight.size(), ny = motion.value[0].size(), lags = nx + ny - 1;
  Correlator fft(nx, ny);
  Series evidence(lags, 0), correlation(lags, 0);
  const auto compared = [&](std::size_t sensor, std::size_t c) {
    return channel(fft, sensors[sensor], motion.value[c], motion.weight[c], grid.step);
  };
  const std::array channels{compared(0, 0), compared(1, 1), compared(1, 2)};
  for (const Channel& one : channels) {
    for (std::size_t k = 0; k < lags; ++k) {
      evidence[k] += one.evidence(k);
      correlation[k] = std::max(correlation[k], one.r2[k]);
    }
  }
  const auto offset_at = [&](double lag) {
    return imu.start() - track.start() + (lag - static_cast<double>(ny - 1)) * grid.step;
  };
  for (std::size_t k = 0; within && k < lags; ++k) {
    if (!within->contains(offset_at(static_cast<double>(k)))) evidence[k] = 0;
  }
  const auto best = static_cast<std::size_t>(std::max_element(evidence.begin(), evidence.end()) - evidence.begin());
  // The rival: the most likely offset outside the peak itself.
  const auto apart = static_cast<std::size_t>(std::ceil(1 / grid.step));
  std::size_t left = best, right = best;
  while (left > 0 && (evidence[left - 1] <= evidence[left] || best - left < apart)) --left;
  while (right + 1 < lags && (evidence[right + 1] <= evidence[right] || right - best < apart)) ++right;
  double rival = 0;
  for (std::size_t k = 0; k < lags; ++k) {
    if (k < left || k > right) rival = std::max(rival, evidence[k]);
  }
  ClockMatch match;
  match.correlation = std::sqrt(correlation[best]);
  match.evidence = evidence[best];
  match.over_rival = evidence[best] - rival;
  const bool alike = match.correlation >= kLeastCorrelation, beyond_doubt = match.over_rival > kBeyondDoubt;
  match.certain = !within && (match.correlation >= kCertainCorrelation || (alike && beyond_doubt));
  if (!within && !alike && !(beyond_doubt && match.evidence > kTimesRival * rival)) return std::nullopt;
  if (match.evidence < kCertain || match.over_rival < kOverRival || best == 0 || best + 1 == lags) return std::nullopt;
  // A body that leans into its turns rolls as the derivative of the turn rate: a regression on all axes fits a lag as
  // well as it fits none. Near the peak the rate about down takes their place.
  const Channel down = compared(2, 0);
  std::size_t at = best;
  if (down.r2[best] > kAlongDown * channels[0].r2[best]) {
    for (std::size_t k = left; k <= right; ++k) {
      evidence[k] += down.evidence(k) - channels[0].evidence(k);
      if (evidence[k] > evidence[at]) at = k;
    }
    if (at == left || at == right) return std::nullopt;
  }
  const double before = evidence[at - 1], after = evidence[at + 1], bend = before - 2 * evidence[at] + after;
  if (!(bend < 0)) return std::nullopt;
  match.offset = offset_at(static_cast<double>(at) + 0.5 * (before - after) / bend);
  match.sigma = grid.step / std::sqrt(-bend);
  return match;
}

double clock_sigma(double of_match, const GnssHealth& health) {
  constexpr double kTurnsEarly = 0.01, kBetweenFixes = 0.06;  // s; parts of the interval between fixes
  return std::hypot(of_match, kTurnsEarly, kBetweenFixes * health.sampling.interval);
}

namespace {

// Regresses the turn rates of the track on what `value` makes of the IMU's integrals over the same time.
template <class Value>
Regression turns_on(const ImuIntegral& imu, const Track& track, double offset, const Grid& grid, const Value& value) {
  const TrackSignals motion = track_signals(track, grid);
  Regression r;
  for (std::size_t i = 0; i < motion.value[0].size(); ++i) {
    const double t = track.start() + static_cast<double>(i) * grid.step + offset;
    const double begin = t - grid.width / 2, end = t + grid.width / 2;
    if (motion.weight[0][i] == 0 || !imu.covers(begin, end)) continue;
    const ImuIntegral::Value a = imu.at(begin), b = imu.at(end);
    const Vector3d x = value(Vector3d((b.angle - a.angle) / grid.width), Vector3d(b.velocity - a.velocity));
    const double y = motion.value[0][i];
    r.n += 1;
    r.y += y;
    r.yy += y * y;
    r.x += x;
    r.xy += x * y;
    r.xx += x * x.transpose();
  }
  return r;
}

// R² of the turns on the rates, and the coefficients.
double explained_part(const Regression& r, Vector3d& b) {
  const double floor = 1e-4 * (r.xx / r.n - r.x / r.n * (r.x / r.n).transpose()).trace();
  return r.fit(floor, 0, b);
}

}  // namespace

double turn_ratio(const ImuIntegral& imu, const Track& track, double offset) {
  if (track.empty()) return 0;
  const Grid grid = grid_of(imu, track);
  const Regression r = turns_on(imu, track, offset, grid, [](const Vector3d& rate, const Vector3d&) { return rate; });
  if (r.n * grid.step < kShortestOverlap) return 0;
  Vector3d b;
  const bool determined = explained_part(r, b) > kDetermined && b.norm() > 0;
  return determined ? 1 / b.norm() : 0;
}

double turn_correlation(const ImuIntegral& imu, const Track& track, double offset) {
  if (track.empty()) return 0;
  const Grid grid = grid_of(imu, track);
  const auto about_down = [](const Vector3d& rate, const Vector3d& force) {
    return Vector3d(rate_about_down(rate, force), 0, 0);
  };
  const Regression all = turns_on(imu, track, offset, grid, [](const Vector3d&rate, const Vector3d&) { return rate; }),
                   down = turns_on(imu, track, offset, grid, about_down);
  if (all.n * grid.step < kShortestOverlap) return 0;
  Vector3d b;
  const double of_all = explained_part(all, b), of_down = explained_part(down, b);
  if (!(of_all > kDetermined) || of_down < kAlongDown * of_all) return 0;
  return std::copysign(std::sqrt(of_down), b.x());
}

}  // namespace piste
