#include "piste/condition/time_sync.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "alignment_fit.h"
#include "alignment_start.h"
#include "clock_evenness.h"
#include "coarse_offset.h"
#include "determination.h"
#include "paired_signals.h"
#include "piste/core/error.h"
#include "piste/math/interruption.h"
#include "reference_noise.h"

namespace piste {
namespace {

using Layout = AlignmentLayout;

constexpr double kShortest = 5;  // s: least overlap

void require_length(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                    const std::string& name) {
  const auto length = [](const std::vector<ImuSample>& imu) {
    return imu.empty() ? 0 : imu.back().time - imu.front().time;
  };
  if (std::min(length(body), length(reference)) >= kShortest) return;
  throw DataError(name,
                  fmt::format("logs of {:.1f} s and {:.1f} s are too short to be aligned; {} s at least are needed",
                              length(body), length(reference), kShortest));
}

// The cut-off of the options, or else the usual one. It must be below half the rate of the slower IMU.
double common_cutoff(const BodySignals& body, const BodySignals& reference, const AlignmentOptions& options) {
  constexpr double kUsual = 12, kOfRate = 0.4;  // Hz, of the slower rate
  const double slower = std::max(body.step, reference.step);
  if (2 * options.low_pass * slower >= 1) {
    throw ConfigError(options.name, fmt::format("low_pass: {} Hz is not below half of the rate of both IMUs, {:.4g} Hz",
                                                options.low_pass, 1 / slower));
  }
  return options.low_pass > 0 ? options.low_pass : std::min(kUsual, kOfRate / slower);
}

// A fit to slow motion first. Its minimum is broad, so that the fit goes from the coarse offset to the right minimum.
AlignmentFit rough_fit(const SignalPair& signals, double cutoff, double coarse_offset,
                       const AlignmentOptions& options) {
  constexpr double kSlow = 1, kMedium = 4;  // Hz
  const FilteredPair medium = low_passed(signals, std::min(kMedium, cutoff));
  const AlignmentFit start = start_alignment(signals, medium, coarse_offset, options.name);
  refuse_jumps(signals, medium, start.x, options.name);
  const AlignmentFit slow = fit_alignment(signals, low_passed(signals, std::min(kSlow, cutoff)), options.sensor, start);
  return fit_alignment(signals, medium, options.sensor, slow);
}

// Throws if the rates of one are a multiple of the other's that no scale error explains.
void refuse_other_unit(const FilteredPair& pair, const AlignmentFit& fit, const std::string& name) {
  constexpr double kLargestScale = 0.5, kAlike = 0.8;  // least squared correlation: below, no motion in common
  auto plain = fit.x;                                  // by which the residual is body less reference
  plain.gyro_bias.setZero();
  plain.gyro_scale.setZero();
  double together = 0, of_reference = 0, of_body = 0;
  for (const AlignmentEpoch& e : fit.epochs) {
    if (!e.moving || e.usable.gyro != 7) continue;
    const Vector3d& body = pair.body.gyro[e.sample];
    const Vector3d reference = body - residual(pair, plain, e.sample).gyro;
    together += body.dot(reference);
    of_reference += reference.squaredNorm();
    of_body += body.squaredNorm();
  }
  const double ratio = together / of_reference;
  if (!(std::abs(ratio - 1) > kLargestScale) || ratio * together < kAlike * of_body) return;
  throw DataError(name, fmt::format("the rates of the body IMU are {:.3g} times those of the reference; is one of the "
                                    "two in another unit than its columns say, rad/s or deg/s?",
                                    ratio));
}

// Throws if the two IMUs are not on one plate: then the rates of one hardly explain those of the other.
void refuse_strangers(const FilteredPair& pair, const AlignmentFit& fit, const std::string& name) {
  constexpr double kUnexplained = 0.5;
  double signal = 0, left = 0;
  for (const AlignmentEpoch& e : fit.epochs) {
    if (!e.moving || e.usable.gyro != 7) continue;
    signal += (pair.body.gyro[e.sample] - fit.x.gyro_bias).squaredNorm();
    left += residual(pair, fit.x, e.sample).gyro.squaredNorm();
  }
  if (left <= kUnexplained * signal) return;
  throw DataError(name,
                  fmt::format("the rates of the reference explain but {:.0f} % of those of the body IMU at the best "
                              "offset, {:.3f} s; are the two of the same run, and on one plate?",
                              100 * std::max(0.0, 1 - left / signal), fit.x.clock(0)));
}

// Applies the errors-in-variables correction for the noise of the reference, and returns the covariance of the
// alignment.
AlignmentInformation freed_from_reference_noise(const std::vector<ImuSample>& body, double cutoff, WhitenedFit& white,
                                                const AlignmentOptions& options) {
  const NoiseShares shares = noise_shares(options.sensor, options.reference);
  AlignmentFit& fit = white.fit;
  ApparentInformation apparent;
  if (!shares.none()) {
    const SignalPair witness(body, as_reference(body, fit.x));
    apparent = apparent_information(white.pair, whitened(low_passed(witness, cutoff), white.gyro, white.accel),
                                    fit.epochs, fit.x, shares);
  }
  const AlignmentInverse inverse =
      inverted(fit.information, apparent.information, apparent.variance(fit.x), options.sensor);
  take_back(fit.x, apparent, inverse.known);
  return inverse.covariance + of_reference_scales(fit.x, options.reference);
}

// The parameters with their covariance. Those that the motion does not determine are marked.
Alignment judged(const AlignmentFit& fit, const AlignmentInformation& covariance, double wander,
                 const AlignmentOptions& options) {
  Alignment a;
  a.clock_offset = fit.x.clock(0);
  a.clock_drift = fit.x.clock(1);
  a.q_rb = fit.x.q_rb;
  a.p_rb_r = fit.x.p_rb_r;
  a.gyro_bias = fit.x.gyro_bias;
  a.accel_bias = fit.x.accel_bias;
  a.gyro_scale = fit.x.gyro_scale;
  a.accel_scale = fit.x.accel_scale;
  determine(a, covariance, options.sensor);

  if (!std::isfinite(a.variance(Layout::kClockOffset))) {
    throw DataError(options.name,
                    "the motion does not determine the offset of the clocks to 5 ms; take a log with livelier motion");
  }
  constexpr double kLargestClockDrift = 0.01;  // as in the clock of a configuration
  if (std::abs(a.clock_drift) > kLargestClockDrift) {
    throw DataError(options.name,
                    fmt::format("the clock of the body IMU runs {:+.2f} % against that of the reference; a wrong "
                                "sample rate or unit of time?",
                                100 * a.clock_drift));
  }
  a.covariance(Layout::kClockOffset, Layout::kClockOffset) += wander * wander;
  if (wander > 0) {
    a.warnings.push_back(
        fmt::format("the clock of the body IMU wanders by {:.2f} ms (rms) about offset and "
                    "drift, which the sigma of the offset includes",
                    1e3 * wander));
  }
  return a;
}

}  // namespace

Alignment align(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                const AlignmentOptions& options) {
  require_length(body, reference, options.name);
  CoarseOffset coarse = find_offset(body, reference, kShortest, options.name);
  const SignalPair signals(body, reference);
  const double cutoff = common_cutoff(signals.body, BodySignals(reference), options);

  check_interruption();
  const AlignmentFit rough = rough_fit(signals, cutoff, coarse.peak.peak_offset, options);
  const FilteredPair full = low_passed(signals, cutoff);
  check_interruption();
  const AlignmentFit fit = fit_alignment(signals, full, options.sensor, rough);
  refuse_other_unit(full, fit, options.name);
  refuse_strangers(full, fit, options.name);

  check_interruption();
  WhitenedFit white = fit_whitened(signals, full, options.sensor, fit);
  std::vector<LocalOffset> local = local_offsets(white.pair, white.fit);
  const double wander = clock_wander(local, options.name);
  check_interruption();
  const AlignmentInformation covariance = freed_from_reference_noise(body, cutoff, white, options);
  Alignment alignment = judged(white.fit, covariance, wander, options);
  alignment.low_pass = cutoff;
  alignment.gyro_residual = fit.noise.gyro[1];
  alignment.accel_residual = fit.noise.accel[1];
  alignment.correlation = std::move(coarse.peak);
  alignment.local = std::move(local);
  return alignment;
}

AlignedImus bring_together(const std::vector<ImuSample>& body, const std::vector<ImuSample>& reference,
                           const Alignment& alignment) {
  const ReferenceIntegrals integrals(reference);
  const BodySignals signals(body);
  AlignedImus out;
  out.interval = signals.step;
  const double first = body.front().time;
  const Vector3d p_rb_r = alignment.known(alignment.p_rb_r, Layout::kLeverArm);
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
