#include "condition/imu_differences.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// Sigmas. A normal variable exceeds it once in 2.6e7: for three axes of two triads of four IMUs below 1e-6 per epoch,
// even if windows are single epochs.
constexpr double kWrong = 5.5;
constexpr double kRight = 3;
constexpr int kPatience = 10;          // windows
constexpr double kMounting = kDegree;  // 1-sigma of the misalignment of IMUs
constexpr std::uint8_t kAllAxes = 7;

bool says(std::uint8_t bits, int axis) { return ((bits >> axis) & 1) == 0; }

// The Kalman filter of one axis of an IMU: β, and g for the three axes of the signal.
struct Difference {
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  Eigen::Matrix4d P = Eigen::Matrix4d::Zero();

  static Eigen::Vector4d row(const Vector3d& signal) { return {1, signal.x(), signal.y(), signal.z()}; }
  double at(const Vector3d& signal) const { return row(signal).dot(x); }
  double variance(const Vector3d& signal) const { return row(signal).dot(P * row(signal)); }
  void update(const Vector3d& signal, double residual, double noise) {
    const Eigen::Vector4d h = row(signal), Ph = P * h;
    const Eigen::Vector4d K = Ph / (h.dot(Ph) + noise);
    x += K * residual;
    P -= K * Ph.transpose();
    P = (0.5 * (P + P.transpose())).eval();
  }
};

class Combiner {
 public:
  Combiner(std::span<const ImuTriad* const> imus, std::span<const ImuSensor> sensors, TriadMember triad,
           const std::vector<double>& intervals, const std::vector<ImuWindow>& windows)
      : imus_(imus),
        intervals_(intervals),
        windows_(windows),
        count_(imus.size()),
        weights_(imu_weights(sensors, triad)),
        noise_(imu_noise(sensors, triad)),
        known_(imus.size()),
        excluded_(imus.size(), false),
        calm_(imus.size(), 0),
        missing_for_(3, 0) {
    for (std::size_t i = 0; i < count_; ++i) {
      const TriadErrors& errors = sensors[i].*triad;
      const DriftProcess& drift = errors.drift;
      const bool returns = drift.kind == DriftProcess::Kind::kGaussMarkov;
      // Squared density of the random walk as which a drift begins.
      growth_.push_back(returns ? 2 * drift.sigma * drift.sigma / drift.correlation_time
                                : drift.density * drift.density);
      const double offset = std::hypot(errors.bias, returns ? drift.sigma : 0);
      for (int axis = 0; axis < 3; ++axis) {
        Eigen::Vector4d sigma(offset, kMounting, kMounting, kMounting);
        sigma(1 + axis) = std::max(errors.scale, kMounting * kMounting);
        known_[i][static_cast<std::size_t>(axis)].P = sigma.cwiseAbs2().asDiagonal();
      }
    }
  }

  CombinedTriad run() {
    CombinedTriad out;
    out.mean.resize(intervals_.size());
    out.out.assign(count_, std::vector<std::uint8_t>(intervals_.size(), 0));
    out.why.assign(count_, std::vector<ImuFault>(intervals_.size(), ImuFault::kBiased));
    measure_noise();
    const auto nothing_known = known_;
    const std::size_t late = begin_late();
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      // The estimation restarts here: the estimate for the time before has used these windows already.
      if (w == late && late > 0) known_ = nothing_known;
      look_at(w);
      emit(windows_[w], out);
      out.whole.push_back(whole_[w] && std::ranges::none_of(excluded_, [](bool left) { return left; }));
      take_back();
    }
    return out;
  }

 private:
  // If an IMU begins late, the mean of the others before it is corrected by their later differences: a drift is as slow
  // backwards as forwards. Returns the first window with all IMUs, or 0 if none is late.
  std::size_t begin_late() {
    constexpr std::size_t kSoon = 10, kLearned = 3000;  // windows: a second; five minutes, longer than drifts last
    const auto first = static_cast<std::size_t>(std::ranges::find(whole_, true) - whole_.begin());
    if (first < kSoon || first == whole_.size()) return 0;
    for (std::size_t w = std::min(first + kLearned, whole_.size()); w-- > first;) {
      look_at(w);
      take_back();
    }
    double before = 0;
    for (std::size_t w = 0; w < first; ++w) before += windows_[w].duration;
    for (std::size_t i = 0; i < count_; ++i) {
      for (Difference& d : known_[i]) d.P(0, 0) += growth_[i] * before;
    }
    excluded_.assign(count_, false);
    calm_.assign(count_, 0);
    return first;
  }

  // The means over all windows, whether all IMUs measured all of them, and the noise of each IMU's difference.
  void measure_noise() {
    means_.resize(count_);
    bad_.resize(count_);
    std::vector<std::vector<Vector3d>> differences(count_);
    std::vector<Vector3d> signal;
    for (const ImuWindow& window : windows_) {
      Vector3d mean = Vector3d::Zero();
      std::uint8_t bad = 0;
      for (std::size_t i = 0; i < count_; ++i) {
        means_[i].push_back(mean_over(*imus_[i], window, intervals_));
        std::uint8_t bits = 0;
        for (std::size_t k = window.begin; k < window.end; ++k) bits = bits | imus_[i]->bad[k];
        bad_[i].push_back(bits);
        bad = bad | bits;
        mean += weight(i) * means_[i].back();
      }
      whole_.push_back(bad == 0);
      for (std::size_t i = 0; bad == 0 && i < count_; ++i) differences[i].push_back(means_[i].back() - mean);
      if (bad == 0) signal.push_back(mean);
    }
    const double of_mean = weights_.cwiseProduct(noise_).squaredNorm();
    for (std::size_t i = 0; i < count_; ++i) {
      const double own = noise(i) * noise(i);
      density_.push_back(own * (1 - 2 * weight(i)) + of_mean);
      shown_.emplace_back(noise_of(differences[i], signal).cwiseAbs2());
    }
  }

  double weight(std::size_t i) const { return weights_(static_cast<Eigen::Index>(i)); }
  double noise(std::size_t i) const { return noise_(static_cast<Eigen::Index>(i)); }
  double noise_variance(std::size_t i, int axis, const ImuWindow& window) const {
    return std::max(density_[i] / window.duration, shown_[i](axis));
  }
  bool informs(std::size_t i, std::size_t w, int axis) const { return !excluded_[i] && says(bad_[i][w], axis); }

  std::size_t informative_imus(std::size_t w, int axis) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < count_; ++i) count += informs(i, w, axis) ? 1 : 0;
    return count;
  }

  // The weighted mean of `value(i)` over the IMUs for which `use(i)` holds, and the sum of their weights.
  template <class Use, class Value>
  std::pair<double, double> weighted(Use&& use, Value&& value) const {
    double sum = 0, all = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (!use(i)) continue;
      sum += weight(i) * value(i);
      all += weight(i);
    }
    return {all > 0 ? sum / all : 0, all};
  }

  // The signal in a window, without excluded IMUs.
  Vector3d signal_in(std::size_t w) const {
    Vector3d out;
    for (int axis = 0; axis < 3; ++axis) {
      const auto [mean, all] = weighted([&](std::size_t i) { return informs(i, w, axis); },
                                        [&](std::size_t i) { return means_[i][w](axis); });
      out(axis) =
          all > 0 ? mean
                  : weighted([](std::size_t) { return true; }, [&](std::size_t i) { return means_[i][w](axis); }).first;
    }
    return out;
  }

  // Compares the IMUs in a window, excludes faulty ones, and updates the differences of the others.
  void look_at(std::size_t w) {
    const ImuWindow& window = windows_[w];
    for (std::size_t i = 0; i < count_; ++i) {
      for (Difference& d : known_[i]) d.P(0, 0) += growth_[i] * window.duration;
    }
    for (std::size_t wrong = count_; (wrong = wrong_unit(w)) < count_;) {
      excluded_[wrong] = true;
      calm_[wrong] = 0;
    }
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t informative = informative_imus(w, axis);
      if (informative < 2) continue;
      const std::vector<double> r = residuals(w, axis);
      for (std::size_t i = 0; i < count_; ++i) {
        if (!informs(i, w, axis)) continue;
        Difference& d = difference(i, axis);
        const double variance = noise_variance(i, axis, window);
        const double predicted = d.variance(signal_) + variance;
        if (r[i] * r[i] > kWrong * kWrong * predicted) d.P(0, 0) += r[i] * r[i];  // two IMUs diverged
        d.update(signal_, r[i], variance);
      }
      if (informative == count_) centre(axis);
    }
    judge_returns(w);
  }

  Difference& difference(std::size_t i, int axis) { return known_[i][static_cast<std::size_t>(axis)]; }
  const Difference& difference(std::size_t i, int axis) const { return known_[i][static_cast<std::size_t>(axis)]; }

  // The residual of each IMU: its difference from the mean, less the predicted one.
  std::vector<double> residuals(std::size_t w, int axis) const {
    const auto corrected = [&](std::size_t i) { return means_[i][w](axis) - difference(i, axis).at(signal_); };
    const double mean = weighted([&](std::size_t i) { return informs(i, w, axis); }, corrected).first;
    std::vector<double> out;
    for (std::size_t i = 0; i < count_; ++i) out.push_back(corrected(i) - mean);
    return out;
  }

  // The faulty IMU in the window, or the number of IMUs if there is none. It is the one whose exclusion lowers the sum
  // of squared normalised residuals most, and by more than kWrong² (a likelihood ratio: chi-squared with one degree of
  // freedom).
  std::size_t wrong_unit(std::size_t w) {
    signal_ = signal_in(w);
    std::size_t worst = count_;
    double largest = kWrong * kWrong;
    for (int axis = 0; axis < 3; ++axis) {
      if (informative_imus(w, axis) < 3) continue;
      const double all = disagreement(w, axis, count_);
      for (std::size_t i = 0; i < count_; ++i) {
        if (!informs(i, w, axis)) continue;
        const double less = all - disagreement(w, axis, i);
        if (less <= largest) continue;
        largest = less;
        worst = i;
      }
    }
    return worst;
  }

  // The sum of squared differences of the IMUs, without one, from their mean, normalised by their sigmas.
  double disagreement(std::size_t w, int axis, std::size_t without) const {
    double weights = 0, first = 0, second = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (i == without || !informs(i, w, axis)) continue;
      const Difference& d = difference(i, axis);
      const double of_own = noise(i) * noise(i) / density_[i];  // the IMU's own share of the noise of a difference
      const double part = 1 / (d.variance(signal_) + of_own * noise_variance(i, axis, windows_[w]));
      const double value = means_[i][w](axis) - means_[0][w](axis) - d.at(signal_);  // a difference keeps digits
      weights += part;
      first += part * value;
      second += part * value * value;
    }
    return second - first * first / weights;
  }

  // Differences are from the mean of all: their weighted mean is zero.
  void centre(int axis) {
    Eigen::Vector4d mean = Eigen::Vector4d::Zero();
    for (std::size_t i = 0; i < count_; ++i) mean += weight(i) * difference(i, axis).x;
    for (std::size_t i = 0; i < count_; ++i) difference(i, axis).x -= mean;
  }

  // Counts the windows in which an excluded IMU agrees with the others.
  void judge_returns(std::size_t w) {
    for (std::size_t i = 0; i < count_; ++i) {
      if (!excluded_[i]) continue;
      bool agrees = bad_[i][w] == 0;
      for (int axis = 0; agrees && axis < 3; ++axis) {
        const double r = residuals(w, axis)[i];
        const double variance = difference(i, axis).variance(signal_) + noise_variance(i, axis, windows_[w]);
        agrees = r * r <= kRight * kRight * variance;
      }
      calm_[i] = agrees ? calm_[i] + 1 : 0;
    }
  }

  void take_back() {
    for (std::size_t i = 0; i < count_; ++i) {
      if (excluded_[i] && calm_[i] >= kPatience) excluded_[i] = false;
    }
  }

  void emit(const ImuWindow& window, CombinedTriad& out) {
    for (std::size_t k = window.begin; k < window.end; ++k) {
      for (std::size_t i = 0; i < count_; ++i) {
        out.out[i][k] = excluded_[i] ? kAllAxes : imus_[i]->bad[k];
        if (imus_[i]->bad[k] != 0) out.why[i][k] = imus_[i]->why[k];
      }
      TriadMean& mean = out.mean[k];
      for (int axis = 0; axis < 3; ++axis) emit(k, axis, out, mean);
    }
  }

  void emit(std::size_t k, int axis, const CombinedTriad& out, TriadMean& mean) {
    int& missing_for = missing_for_[static_cast<std::size_t>(axis)];
    const auto used = [&](std::size_t i) { return says(out.out[i][k], axis); };
    const auto measured = [&](std::size_t i) { return imus_[i]->value[k](axis); };
    const auto [value, all] = weighted(used, measured);
    std::size_t informative = 0;
    for (std::size_t i = 0; i < count_; ++i) informative += used(i) ? 1 : 0;
    if (informative == count_) {
      missing_for = 0;
      mean.value(axis) = value;
      return;
    }
    if (informative == 0) {  // the best available value: that of the clipped IMUs, as the others measured nothing
      mean.missing = static_cast<std::uint8_t>(mean.missing | 1U << static_cast<unsigned>(axis));
      const auto spoke = [&](std::size_t i) { return out.why[i][k] == ImuFault::kClipped; };
      mean.value(axis) = weighted(spoke, measured).first;
      return;
    }
    ++missing_for;
    double variance = 0, unsure = 0, offset = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (!used(i)) continue;
      const double part = weight(i) / all;
      const Difference& d = difference(i, axis);
      offset += part * d.at(signal_);
      variance += part * part * noise(i) * noise(i);
      unsure += part * part * d.variance(signal_);
    }
    mean.value(axis) = value - offset;
    // The error of the offset is constant while the IMUs are missing: the n-th sample adds 2n − 1 times its variance.
    mean.added(axis) = std::max(0.0, variance - weights_.cwiseProduct(noise_).squaredNorm()) +
                       unsure * intervals_[k] * (2 * missing_for - 1);
  }

  std::span<const ImuTriad* const> imus_;
  const std::vector<double>& intervals_;
  const std::vector<ImuWindow>& windows_;
  std::size_t count_;
  ImuVector weights_, noise_;
  std::vector<double> growth_;                    // of each IMU
  std::vector<std::vector<Vector3d>> means_;      // of each IMU and window
  std::vector<std::vector<std::uint8_t>> bad_;    // likewise
  std::vector<bool> whole_;                       // of each window
  std::vector<double> density_;                   // of each IMU: squared, of its difference from the mean
  std::vector<Vector3d> shown_;                   // and the variance that the windows show
  std::vector<std::array<Difference, 3>> known_;  // of each IMU and axis
  std::vector<bool> excluded_;
  std::vector<int> calm_, missing_for_;
  Vector3d signal_ = Vector3d::Zero();  // of the present window
};

}  // namespace

Vector3d mean_over(const ImuTriad& unit, const ImuWindow& window, const std::vector<double>& intervals) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = window.begin; k < window.end; ++k) sum += intervals[k] * unit.value[k];
  return sum / window.duration;
}

Vector3d noise_of(std::span<const Vector3d> series, std::span<const Vector3d> signal) {
  constexpr std::size_t kEnough = 30;
  if (series.size() < kEnough) return Vector3d::Zero();
  // Regression of the steps on the steps of the signal.
  Matrix3d squares = Matrix3d::Identity() * 1e-12, products = Matrix3d::Zero();
  const auto step = [](std::span<const Vector3d> values, std::size_t i) { return Vector3d(values[i + 1] - values[i]); };
  for (std::size_t i = 0; i + 1 < series.size(); ++i) {
    squares += step(signal, i) * step(signal, i).transpose();
    products += step(series, i) * step(signal, i).transpose();
  }
  const Matrix3d gain = products * squares.inverse();
  Vector3d out;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> steps;
    for (std::size_t i = 0; i + 1 < series.size(); ++i) {
      steps.push_back(std::abs(step(series, i)(axis) - gain.row(axis).dot(step(signal, i))));
    }
    out(axis) = kSigmaOverMedian * median(std::move(steps)) / std::sqrt(2.0);
  }
  return out;
}

CombinedTriad combine(std::span<const ImuTriad* const> imus, std::span<const ImuSensor> sensors, TriadMember triad,
                      const std::vector<double>& intervals, const std::vector<ImuWindow>& windows) {
  return Combiner(imus, sensors, triad, intervals, windows).run();
}

}  // namespace piste
