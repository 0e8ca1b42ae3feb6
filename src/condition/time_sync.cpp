#include "piste/condition/time_sync.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "alignment_problem.h"
#include "coarse_offset.h"
#include "condition/boresight.h"
#include "determination.h"
#include "paired_signals.h"
#include "piste/condition/signal.h"
#include "piste/core/error.h"
#include "piste/core/state_table.h"
#include "piste/math/statistics.h"
#include "whitening.h"

namespace piste {
namespace {

using Layout = AlignmentLayout;

constexpr double kUsualLowPass = 12;         // Hz
constexpr double kShortest = 5;              // s: overlap without which nothing is said
constexpr double kLargestClockDrift = 0.01;  // as in the clock of a configuration
constexpr double kKnots = 5;                 // s between the knots of in-run drifts
constexpr double kWindow = 10;               // s: of local offsets
constexpr double kSmear = 2;                 // periods of the cut-off that a zero-phase low-pass smears

TriadFilters low_pass(double cutoff, double rate) {
  const LowPass filter(cutoff, rate);
  const LinearFilter both = [filter](std::span<const Vector3d> signal) { return zero_phase(filter, signal); };
  return {both, both, kSmear / cutoff, kSmear / cutoff};
}

class Aligner {
 public:
  Aligner(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference, const AlignmentOptions& options)
      : options_(options), body_(body), integrals_(reference), grid_(integrals_, body_.step) {
    // The slower of the two must still carry what passes.
    constexpr double kOfRate = 0.4;
    const double slower = std::max(body_.step, BodySignals(reference).step);
    if (2 * options.low_pass * slower >= 1) {
      throw ConfigError(options.name,
                        fmt::format("low_pass: {} Hz is not below half of the rate of both IMUs, {:.4g} Hz",
                                    options.low_pass, 1 / slower));
    }
    low_pass_ = options.low_pass > 0 ? options.low_pass : std::min(kUsualLowPass, kOfRate / slower);
  }

  Alignment run(const CoarseOffset& coarse) {
    result_.correlation = coarse.peak;
    // At the first sample; the peak is that of the clocks' zeros.
    x_.clock = {coarse.peak.peak_offset, 0};
    start_knots();
    constexpr std::array kStages{1.0, 4.0};
    start_boresight(std::min(kStages.back(), low_pass_));
    check_jumps();
    for (const double cutoff : kStages) stage(std::min(cutoff, low_pass_), 2);
    stage(low_pass_, 2);
    check_agreement();
    whitened();
    check_clock();
    conclude();
    return std::move(result_);
  }

 private:
  struct Stage {
    BodySignals body;
    ReferenceGrid grid;
    double gyro_gain = 1, accel_gain = 1;
    double margin = 0;       // s at the ends of the reference that filters spoil
    std::size_t stride = 1;  // of the samples that are used
    FilteredPair pair() const { return {body, grid, gyro_gain, accel_gain}; }
  };

  Stage filtered(double cutoff) const {
    const double rate = 1 / body_.step;
    const TriadFilters filters = low_pass(cutoff, rate);
    return {body_.filtered(filters),
            grid_.filtered(filters),
            1,
            1,
            filters.after,
            std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(rate / (2 * cutoff))))};
  }

  double reference_time(double m) const { return m - x_.clock(0) - x_.clock(1) * (m - body_.time.front()); }

  // Samples that both IMUs have something to say of, the filters being settled.
  std::vector<AlignmentEpoch> epochs(const Stage& s, std::size_t offset = 0) const {
    std::vector<AlignmentEpoch> out;
    const double margin = s.margin + 2 * body_.step;
    for (std::size_t k = offset; k < s.body.time.size(); k += s.stride) {
      const double m = s.body.time[k], t = reference_time(m);
      if (m - margin < s.body.time.front() || m + margin > s.body.time.back()) continue;
      if (t - margin < integrals_.start() || t + margin > integrals_.end()) continue;
      if (integrals_.silent(t - margin, t + s.margin)) continue;
      out.push_back({k, s.body.usable[k], gyro_sigma_[0], accel_sigma_[0]});
    }
    return out;
  }

  void start_knots() {
    const double first = body_.time.front(), length = body_.time.back() - first;
    const auto pieces = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(length / kKnots)));
    x_.first_knot = first;
    x_.knot_spacing = length / static_cast<double>(pieces);
    x_.gyro_drift.assign(pieces + 1, Vector3d::Zero());
    x_.accel_drift.assign(pieces + 1, Vector3d::Zero());
  }

  // Boresight and rough noise from the rates alone.
  void start_boresight(double cutoff) {
    stage_ = filtered(cutoff);
    std::vector<Vector3d> rate_r, rate_b;
    for (const AlignmentEpoch& e : epochs(*stage_)) {
      if (e.usable.gyro != 7) continue;
      rate_r.push_back(stage_->grid.at(reference_time(stage_->body.time[e.sample])).signal.gyro);
      rate_b.push_back(stage_->body.gyro[e.sample]);
    }
    constexpr std::size_t kFewest = 20;
    if (rate_r.size() < kFewest) {
      throw DataError(options_.name,
                      "the two IMUs have hardly any time in common once gaps and clipped samples are left out");
    }
    const BoresightFromRates found = boresight_from_rates(rate_r, rate_b);
    constexpr double kMirrored = 0.6;
    if (found.residual_mirrored < kMirrored * found.residual) {
      throw DataError(options_.name,
                      fmt::format("the axes of one of the two IMUs are left-handed: mirrored, their rates "
                                  "differ by {:.3g} deg/s rms, as they are by {:.3g}; one axis points "
                                  "the other way, or two are swapped",
                                  kDegreesPerRadian * found.residual_mirrored, kDegreesPerRadian * found.residual));
    }
    x_.q_rb = found.q_rb;
    x_.gyro_bias = found.gyro_bias;
    gyro_sigma_.fill(std::max(found.residual, 1e-6));
    accel_sigma_.fill(1);
  }

  void stage(double cutoff, int rounds) {
    stage_ = filtered(cutoff);
    std::vector<AlignmentEpoch> used = epochs(*stage_);
    classify(*stage_, used);
    for (int round = 0; round < rounds; ++round) {
      weigh(used);
      information_ = solve_alignment(stage_->pair(), used, options_.sensor, x_);
      judge(used);
    }
    used_ = std::move(used);
  }

  // Which epochs are of the liveliest part: what is left there, where models fail, is judged by itself.
  void classify(const Stage& s, const std::vector<AlignmentEpoch>& used) {
    constexpr double kAround = 1, kLively = 0.2;
    std::vector<double> squares{0};
    for (const AlignmentEpoch& e : used) {
      squares.push_back(squares.back() + s.grid.at(reference_time(s.body.time[e.sample])).signal.gyro.squaredNorm());
    }
    const auto around = static_cast<std::size_t>(kAround / (body_.step * static_cast<double>(s.stride))) + 1;
    std::vector<double> energy;
    for (std::size_t i = 0; i < used.size(); ++i) {
      const std::size_t from = i > around ? i - around : 0, to = std::min(used.size(), i + around + 1);
      energy.push_back(std::sqrt((squares[to] - squares[from]) / static_cast<double>(to - from)));
    }
    std::vector<double> sorted = energy;
    std::sort(sorted.begin(), sorted.end());
    const double limit = kLively * sorted[static_cast<std::size_t>(0.95 * static_cast<double>(sorted.size() - 1))];
    moving_.clear();
    for (const double e : energy) moving_.push_back(e > limit);
  }

  void weigh(std::vector<AlignmentEpoch>& used) const {
    for (std::size_t i = 0; i < used.size(); ++i) {
      used[i].gyro_sigma = gyro_sigma_[moving_[i]];
      used[i].accel_sigma = accel_sigma_[moving_[i]];
    }
  }

  // What is left of rates and forces; of the moving epochs or of the others.
  std::pair<std::vector<Left>, std::vector<Left>> left_over(const std::vector<AlignmentEpoch>& used,
                                                            bool moving) const {
    std::pair<std::vector<Left>, std::vector<Left>> left;
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (moving_[i] != moving) {
        left.first.push_back({Vector3d::Zero(), 0});
        left.second.push_back({Vector3d::Zero(), 0});
        continue;
      }
      const AlignmentResidual r = residual(stage_->pair(), x_, used[i].sample);
      left.first.push_back({r.gyro, used[i].usable.gyro});
      left.second.push_back({r.accel, used[i].usable.accel});
    }
    return left;
  }

  // Noise from what is left.
  void judge(const std::vector<AlignmentEpoch>& used) {
    for (const bool moving : {true, false}) {
      const auto [gyro, accel] = left_over(used, moving);
      const double g = robust_sigma(gyro), a = robust_sigma(accel);
      // Below these, [rad/s] and [m/s²], is rounding: no sensor is so quiet.
      constexpr double kQuietestGyro = 1e-7, kQuietestAccel = 1e-6;
      if (g > 0) gyro_sigma_[moving] = std::max(g, kQuietestGyro);
      if (a > 0) accel_sigma_[moving] = std::max(a, kQuietestAccel);
    }
  }

  // Fits the noise's spectrum and solves once more on whitened signals.
  void whitened() {
    result_.gyro_residual = gyro_sigma_[1];
    result_.accel_residual = accel_sigma_[1];
    const auto [gyro_left, accel_left] = left_over(used_, true);
    const Whitening gyro = autoregression(gyro_left, gyro_sigma_[1]),
                    accel = autoregression(accel_left, accel_sigma_[1]);
    const Stage& flat = *stage_;
    const double reach = kWhiteningOrder * static_cast<double>(flat.stride) * body_.step;
    const TriadFilters filters{gyro.filter(flat.stride), accel.filter(flat.stride), reach, 0};
    stage_ = Stage{flat.body.filtered(filters),
                   flat.grid.filtered(filters),
                   gyro.gain(),
                   accel.gain(),
                   flat.margin + reach,
                   flat.stride};
    std::vector<AlignmentEpoch> used = epochs(*stage_);
    classify(*stage_, used);
    judge(used);
    for (int round = 0; round < 2; ++round) {
      weigh(used);
      information_ = solve_alignment(stage_->pair(), used, options_.sensor, x_);
      judge(used);
    }
    used_ = std::move(used);
  }

  // Refuses a clock that jumps: stretches of motion that fit far better elsewhere than where the whole puts them.
  void check_jumps() const {
    constexpr double kStep = 0.05, kFurthest = 20, kJump = 0.3;
    const auto stride = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(kStep / body_.step)));
    const double step = static_cast<double>(stride) * body_.step;
    const Stage& s = *stage_;
    std::vector<Vector3d> measured, predicted;
    std::vector<double> time;
    for (std::size_t k = 0; k < s.body.time.size(); k += stride) {
      const double t = reference_time(s.body.time[k]);
      time.push_back(t);
      const bool inside = s.grid.contains(t) && !integrals_.silent(t - s.margin, t + s.margin);
      predicted.emplace_back(inside ? Vector3d(x_.q_rb.conjugate() * s.grid.at(t).signal.gyro) : Vector3d::Zero());
      measured.emplace_back(s.body.usable[k].gyro == 7 ? Vector3d(s.body.gyro[k] - x_.gyro_bias) : Vector3d::Zero());
    }
    const auto window = static_cast<std::size_t>(kWindow / step);
    const auto furthest = static_cast<std::ptrdiff_t>(kFurthest / step);
    const auto count = static_cast<std::ptrdiff_t>(time.size());
    for (std::size_t begin = 0; begin + window <= time.size(); begin += window) {
      double power = 0;
      for (std::size_t i = begin; i < begin + window; ++i) power += measured[i].squaredNorm();
      double here = 0, best = 0;
      std::ptrdiff_t best_shift = 0;
      for (std::ptrdiff_t shift = -furthest; shift <= furthest; ++shift) {
        double cross = 0, other = 0;
        for (std::size_t i = begin; i < begin + window; ++i) {
          const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + shift;
          if (j < 0 || j >= count) continue;
          cross += measured[i].dot(predicted[static_cast<std::size_t>(j)]);
          other += predicted[static_cast<std::size_t>(j)].squaredNorm();
        }
        const double r = cross > 0 ? cross / std::sqrt(power * other) : 0;
        if (shift == 0) here = r;
        if (r > best) {
          best = r;
          best_shift = shift;
        }
      }
      constexpr double kSurely = 0.9, kHardly = 0.8;
      const double jump = static_cast<double>(best_shift) * step;
      if (std::abs(jump) < kJump || best < kSurely || here > kHardly) continue;
      if (evidence_over(best, here, kWindow) < kCertain) continue;
      throw DataError(
          options_.name,
          fmt::format("the clock of the body IMU jumps: between {:.1f} and {:.1f} s its rates fit those "
                      "of the reference {:.2f} s {} than elsewhere in the log; samples are missing, or "
                      "time stamps are wrong. Align the parts one by one with `span`",
                      time[begin], time[begin + window - 1], std::abs(jump), jump > 0 ? "later" : "earlier"));
    }
  }

  // Refuses two IMUs that are not on one plate.
  void check_agreement() const {
    constexpr double kUnexplained = 0.5;
    double signal = 0, left = 0;
    const FilteredPair pair = stage_->pair();
    for (std::size_t i = 0; i < used_.size(); ++i) {
      const AlignmentEpoch& e = used_[i];
      if (!moving_[i] || e.usable.gyro != 7) continue;
      signal += (pair.body.gyro[e.sample] - x_.gyro_bias).squaredNorm();
      left += residual(pair, x_, e.sample).gyro.squaredNorm();
    }
    if (left <= kUnexplained * signal) return;
    throw DataError(options_.name,
                    fmt::format("the rates of the reference explain but {:.0f} % of those of the body IMU at the best "
                                "offset, {:.3f} s; are the two of the same run, and on one plate?",
                                100 * std::max(0.0, 1 - left / signal), x_.clock(0)));
  }

  // Offsets stretch by stretch, beside the solution.
  void check_clock() {
    struct Sums {
      double time = 0, count = 0, information = 0, pull = 0;
    };
    std::vector<Sums> sums;
    const FilteredPair pair = stage_->pair();
    const Matrix3d R_br = x_.q_rb.toRotationMatrix().transpose();
    for (const AlignmentEpoch& e : used_) {
      const double m = pair.body.time[e.sample], t = reference_time(m);
      const auto window = static_cast<std::size_t>((m - body_.time.front()) / kWindow);
      if (sums.size() <= window) sums.resize(window + 1);
      const AlignmentResidual r = residual(pair, x_, e.sample);
      const ReferenceGrid::Value value = pair.reference.at(t);
      const Vector3d w = R_br * value.slope.gyro, f = R_br * (value.slope.accel + value.slope.lever * x_.p_rb_r);
      Sums& s = sums[window];
      s.time += t;
      s.count += 1;
      const auto take = [&s](double slope, double rest, double sigma, bool usable) {
        // Without what robust loss would not believe either.
        if (!usable || std::abs(rest) > 4 * sigma) return;
        s.information += slope * slope / (sigma * sigma);
        s.pull -= slope * rest / (sigma * sigma);  // the offset that the residual asks for
      };
      for (int axis = 0; axis < 3; ++axis) {
        take(w(axis), r.gyro(axis), e.gyro_sigma, e.usable.gyro >> axis & 1);
        take(f(axis), r.accel(axis), e.accel_sigma, e.usable.accel >> axis & 1);
      }
    }
    constexpr double kCoarse = 3e-3, kJump = 20e-3, kSurely = 6;
    double q = 0, weights = 0, squared = 0, stretches = 0;
    std::optional<LocalOffset> worst;
    for (const Sums& s : sums) {
      if (!(s.information > 0)) continue;
      const LocalOffset local{s.time / s.count, s.pull / s.information, 1 / std::sqrt(s.information)};
      if (local.sigma > kCoarse) continue;
      result_.local.push_back(local);
      if (std::abs(local.offset) > std::max(kJump, kSurely * local.sigma)) refuse_clock(local);
      if (!worst || std::abs(local.offset) > std::abs(worst->offset)) worst = local;
      q += local.offset * local.offset * s.information;
      weights += s.information;
      squared += s.information * s.information;
      stretches += 1;
    }
    // What local offsets scatter beyond their noise is the clock's own (variance component of DerSimonian and Laird).
    constexpr double kAccident = 1e-4;
    if (stretches < 3 || q < chi_squared_quantile(1 - kAccident, stretches)) return;
    const double wander = std::sqrt((q - (stretches - 1)) / (weights - squared / weights));
    constexpr double kUneven = 5e-3;
    if (wander > kUneven) refuse_clock(*worst);
    wander_ = wander;
    result_.warnings.push_back(
        fmt::format("the clock of the body IMU wanders by {:.2f} ms (rms) beside offset and "
                    "drift, which the sigma of the offset includes",
                    1e3 * wander));
  }

  [[noreturn]] void refuse_clock(const LocalOffset& local) const {
    throw DataError(options_.name,
                    fmt::format("the clock of the body IMU does not run evenly: about {:.1f} s it is {:.1f} "
                                "ms beside offset and drift; samples or time stamps are wrong there. Align "
                                "the parts one by one with `span`",
                                local.time, 1e3 * local.offset));
  }

  void conclude() {
    Alignment& a = result_;
    a.low_pass = low_pass_;
    a.clock_offset = x_.clock(0);
    a.clock_drift = x_.clock(1);
    a.q_rb = x_.q_rb;
    a.p_rb_r = x_.p_rb_r;
    a.gyro_bias = x_.gyro_bias;
    a.accel_bias = x_.accel_bias;
    a.gyro_scale = x_.gyro_scale;
    a.accel_scale = x_.accel_scale;

    determine(a, information_, apparent_boresight(), options_.sensor);
    const double offset_variance = a.variance(Layout::kClockOffset);
    if (!std::isfinite(offset_variance)) {
      throw DataError(options_.name,
                      "the motion does not tell the offset of the clocks to 5 ms; take a log with livelier "
                      "motion");
    }
    a.covariance(Layout::kClockOffset, Layout::kClockOffset) += wander_ * wander_;

    if (std::abs(a.clock_drift) > kLargestClockDrift) {
      throw DataError(options_.name,
                      fmt::format("the clock of the body IMU runs {:+.2f} % against that of the reference; a wrong "
                                  "sample rate or unit of time?",
                                  100 * a.clock_drift));
    }
  }

  // Noise of the reference makes an information about angles of its own, 2 σ_r² / σ_b² a sample and triad.
  double apparent_boresight() const {
    const auto share = [](double reference, double body) { return body > 0 ? std::pow(reference / body, 2) : 0; };
    const ImuSensor &r = options_.reference, &b = options_.sensor;
    double sum = 0;
    for (const AlignmentEpoch& e : used_) {
      if (e.usable.gyro != 0) sum += 2 * std::min(1.0, share(r.gyro.noise, b.gyro.noise));
      if (e.usable.accel != 0) sum += 2 * std::min(1.0, share(r.accel.noise, b.accel.noise));
    }
    return sum;
  }

  const AlignmentOptions& options_;
  BodySignals body_;
  ReferenceIntegrals integrals_;
  ReferenceGrid grid_;
  AlignmentState x_;
  double low_pass_ = 0;
  std::optional<Stage> stage_;
  std::vector<AlignmentEpoch> used_;
  std::vector<bool> moving_;
  std::array<double, 2> gyro_sigma_{1, 1}, accel_sigma_{1, 1};  // at rest, under way
  AlignmentInformation information_;
  double wander_ = 0;
  Alignment result_;
};

}  // namespace

Alignment align(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                const AlignmentOptions& options) {
  const auto length = [](const std::vector<ImuSample>& imu) {
    return imu.empty() ? 0 : imu.back().time - imu.front().time;
  };
  if (std::min(length(body), length(reference)) < kShortest) {
    throw DataError(options.name,
                    fmt::format("logs of {:.1f} s and {:.1f} s are too short to be aligned; {} s at least are needed",
                                length(body), length(reference), kShortest));
  }
  const CoarseOffset coarse = find_offset(body, reference, kShortest, options.name);
  return Aligner(body, reference, options).run(coarse);
}

AlignedImus bring_together(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                           const Alignment& alignment) {
  const ReferenceIntegrals integrals(reference);
  const BodySignals signals(body);
  AlignedImus out;
  out.interval = signals.step;
  const double first = body.front().time;
  const Vector3d p_rb_r = alignment.known_lever_arm();
  const Matrix3d R_br = alignment.q_rb.toRotationMatrix().transpose();
  for (std::size_t k = 0; k < body.size(); ++k) {
    const double t = alignment.reference_time(body[k].time, first);
    const double interval = body[k].interval * (1 - alignment.clock_drift);
    if (t - interval < integrals.start() || t > integrals.end()) continue;
    const MeanSignal r = integrals.mean(t, interval);
    out.time.push_back(t);
    out.gyro.push_back(signals.gyro[k]);
    out.accel.push_back(signals.accel[k]);
    out.reference_gyro.emplace_back(R_br * r.gyro);
    out.reference_accel.emplace_back(R_br * (r.accel + r.lever * p_rb_r));
    const bool whole = signals.usable[k].gyro == 7 && signals.usable[k].accel == 7;
    out.usable.push_back(whole && !integrals.silent(t - interval, t) ? 1 : 0);
  }
  return out;
}

}  // namespace piste
