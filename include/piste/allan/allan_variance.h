#pragma once
/// Overlapping Allan variance and Haar wavelet variance of even samples, in one pass.
///
/// With S the sums of the samples x, and for clusters of m of them
///
///     Y(k) = S(k + 2m) − 2 S(k + m) + S(k),      AVAR(m) = mean of Y² / (2 m²)      (Riley 2008, NIST SP 1065, eq. 11)
///
/// the maximal-overlap Haar wavelet variance of the scale 2m is AVAR(m) / 2 (Percival and Guttorp 1994): one
/// computation gives both.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace piste {

/// One scale.
struct AllanScale {
  std::size_t samples = 1;                         ///< of a cluster, m
  std::size_t terms = 0;                           ///< differences Y that were averaged
  double variance = 0;                             ///< Allan variance, in the square of the samples' unit
  double robust = 0;                               ///< its bounded-influence estimate; NaN if it was not asked for
  double wavelet() const { return variance / 2; }  ///< Haar wavelet variance of the scale 2m
};

/// The variance over scales, from stretches without a gap.
struct AllanCurve {
  double interval = 0;               ///< of the samples [s]
  std::vector<std::size_t> lengths;  ///< of the stretches, in samples
  std::vector<AllanScale> scales;    ///< octaves, ascending
  double tau(std::size_t scale) const { return static_cast<double>(scales[scale].samples) * interval; }
  std::size_t samples() const;     ///< of all stretches
  double longest_stretch() const;  ///< [s]
};

/// The bounded-influence variance (Guerrier, Molinari and Victoria-Feser 2014, Austrian J. Statistics 43): the solution
/// s² of mean ρ(Y / s) = E ρ(z), z standard normal, with Tukey's ρ(r) = r² (1 − (r/c)²)⁴ for |r| < c, and 0 beyond.
namespace robust {
inline constexpr double kTuning = 5.5;  ///< c
/// The variance of the classical estimate over that of this one, for normal samples: some 0.8.
double efficiency();
}  // namespace robust

/// Adds up the variance as samples come: no sample is kept longer than the largest cluster needs. Clusters of up to
/// 2^octaves samples use every Y. Larger ones use only every second, fourth … Y, so that memory is bounded (8 bytes
/// times four such clusters). As neighbouring Y of such clusters hardly differ, nothing is lost.
class AllanSums {
 public:
  static constexpr int kOctaves = 20;  ///< 33 MB at most; every Y of logs of up to four million samples
  explicit AllanSums(bool with_robust = false, int octaves = kOctaves);

  /// The next samples of a stretch.
  void add(std::span<const double> samples);
  /// Ends a stretch: the next sample is not the neighbour of the last one.
  void end_stretch();
  /// The curve of the samples so far. Only scales with at least one Y. `interval`: of the samples [s].
  AllanCurve curve(double interval);

 private:
  struct Bin {
    std::uint64_t count = 0;
    double squares = 0;
  };
  struct Scale {
    std::size_t samples = 0, terms = 0;
    double squares = 0;
    std::vector<Bin> bins;  // of |Y|, for the robust variance
  };
  // Sums of the samples at every 2^level-th of them, the last ones in a ring, and the scales that are made of them.
  struct Level {
    std::vector<double> ring;
    std::size_t count = 0, used = 0;
    std::vector<Scale> scales;
  };
  void push(Level& level, double sum) const;
  void use(Level& level, std::size_t stride) const;
  void use_all();
  double robust_variance(const Scale& scale) const;

  bool robust_;
  int octaves_;
  std::vector<Level> levels_;
  std::vector<std::size_t> lengths_;
  std::size_t length_ = 0, pending_ = 0;
  double sum_ = 0, offset_ = 0;
};

/// The curve of several recordings together, each term counting once. @pre equal intervals, at least one curve
AllanCurve pooled(std::span<const AllanCurve> curves);

/// The curve of one stretch of samples.
AllanCurve allan_curve(std::span<const double> samples, double interval, bool with_robust = false);

}  // namespace piste
