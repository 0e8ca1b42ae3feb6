#pragma once
/// The processes of which the noise of a stationary sensor consists, and the Allan variance of each.
///
/// Each is described by the generalised covariance G(h) of the sums S of its samples, at a lag of h samples. Second
/// differences of S depend on nothing else. With Y as in allan_variance.h,
///
///     E Y² = 6 G(0) − 8 G(m) + 2 G(2m),      cov(Y_j(t), Y_k(s)) = Σ w_a w_b G(t + a m_j − s − b m_k),  w = 1, −2, 1
///
/// so one function gives the variance, and the covariance of the variances of any two scales.

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "piste/allan/allan_variance.h"

namespace piste {

/// With the Allan variance of each (IEEE Std 952; Zhang 2008, Metrologia 45), `size` as named, τ = m dt:
enum class ProcessKind {
  kQuantisation,     ///< of the integral, Q [unit·s]: 3 Q²/τ²
  kWhite,            ///< N [unit/√Hz]: N²/τ
  kBiasInstability,  ///< flicker, B [unit]: (2 ln 2/π) B²
  kGaussMarkov,      ///< first order, sampled, σ [unit] and its correlation time [s]
  kRandomWalk,       ///< K [unit/s/√Hz]: K² τ/3, of samples K² dt (2m² + 1)/(6m)
  kRamp,             ///< a straight line, R [unit/s]: R² τ²/2
};

struct NoiseProcess {
  ProcessKind kind = ProcessKind::kWhite;
  double size = 0;
  double correlation_time = 0;  ///< of kGaussMarkov [s]
};

/// All kinds, in the order in which models name them.
inline constexpr std::array kProcessKinds{ProcessKind::kQuantisation,    ProcessKind::kWhite,
                                          ProcessKind::kBiasInstability, ProcessKind::kGaussMarkov,
                                          ProcessKind::kRandomWalk,      ProcessKind::kRamp};

/// Such as `bias instability`, and for keys `bias_instability`.
std::string_view name_of(ProcessKind kind);
std::string key_of(ProcessKind kind);

/// Allan variance at clusters of m samples, `interval` seconds apart.
double allan_variance(const NoiseProcess& process, std::size_t m, double interval);
double allan_variance(std::span<const NoiseProcess> processes, std::size_t m, double interval);
/// Of one process, at the first `count` scales of a curve.
Eigen::VectorXd allan_variances(const NoiseProcess& process, const AllanCurve& curve, std::size_t count);

/// Interval of a size whose logarithm has this standard deviation: that of the root of a χ² variable with the same one.
/// It is {0, ∞}, no information, for a size that is not above zero or is hardly determined by the curve.
std::pair<double, double> size_interval(double size, double sigma_log, double probability);

/// Covariance of the estimated Allan variances of all scales of a curve if its samples are the sum of these independent
/// normal processes. From the lag covariances c(d) of Y (Percival 1995, Biometrika 82, for wavelets):
///
///     cov = Σ_d n(d) (2 c(d)² + 4 μ_j μ_k c(d)) / (terms_j terms_k · 4 m_j² m_k²)
///
/// with n(d) the pairs of Y at that lag within the stretches, and μ the mean of Y, which only a ramp has. The sum over
/// lags is taken at nodes that are dense where c has kinks.
Eigen::MatrixXd allan_covariance(std::span<const NoiseProcess> processes, const AllanCurve& curve);

}  // namespace piste
