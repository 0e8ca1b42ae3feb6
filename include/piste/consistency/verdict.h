#pragma once
/// The verdict on one run without known truth: whether its sigmas hold. It tests the innovations, the estimates against
/// their priors, and the residuals of the smoothed track. docs/verdict.md has the equations.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/core/options.h"
#include "piste/core/solution.h"
#include "piste/math/statistics.h"

namespace piste {

/// Statistics of the innovations of one source under way. Expected if the sigmas are true: `nis` 1, `ratio` 1,
/// `whiteness` 0, `rejected` 1 − gate. NaN where there are too few.
struct SourceVerdict {
  std::string name;
  std::size_t fixes = 0;    ///< measurements under way, whether they were used or not
  double nis = kNaN;        ///< mean over the used ones, per row
  double nis_error = kNaN;  ///< standard error of that mean, by the effective number of independent values
  double ratio = kNaN;      ///< median of all NIS over the median of χ²: outliers do not count
  double whiteness = kNaN;  ///< correlation of successive normalised innovations, of the axis where it is largest
  double band = kNaN;       ///< ±, in which it is if they are white
  double rejected = 0;      ///< share that was rejected
  double smoothed = kNaN;   ///< rms of the residuals of the smoothed track, in sigmas of the fix; of positions
  bool holds = true;        ///< whether all of this is as expected
  /// Why not: a sentence for each figure beyond its bound, with both.
  std::vector<std::string> reasons = {};
};

/// The change of a constant of the run from its prior.
struct PriorJump {
  std::string name;   ///< of the block and its axis, such as "gyro_scale z"
  double sigmas = 0;  ///< (x̂ − x₀) / sqrt(σ₀² − σ̂²), which is normal if the prior is true
};

/// The prior value of a constant of a run, in the form of shown_value().
BlockValues stated_value(const FilterOptions& options, Block block);

/// The verdict. `findings` has the causes as sentences, the most likely first; diagnosis/diagnose.h determines them.
struct Verdict {
  bool consistent = true;
  double factor = 1;  ///< by which the sigmas are too small (above 1) or too large, of the worst source
  std::vector<SourceVerdict> sources;
  std::vector<PriorJump> jumps;  ///< of the estimated constants that the run determines well, the largest first
  std::vector<std::string> findings;
  /// Whether fixes of a receiver differ by less than it states, so that a part of their error may be slow.
  bool slow_part = false;
};

/// The note with a verdict that names a slow part.
inline constexpr std::string_view kInnovationsCannotTell =
    "Innovations do not show an error that moves fixes and track together: they show only the white part of the sigmas "
    "that a receiver states";

/// Whether innovations of `source` smaller than its sigmas are no reason to lower these. True for positions, unless the
/// user states that their errors are white.
bool may_be_slow(const std::vector<GnssOptions>& receivers, std::string_view source);

/// Sigmas from its prior beyond which a constant contradicts it.
inline constexpr double kFarFromPrior = 4.5;

/// The sources whose innovations are tested.
enum class LookedAt : std::uint8_t {
  kFixes,     ///< receivers and attitude logs
  kMeasured,  ///< wheels, barometer and two antennas as well
};

/// Whether an innovation is informative about the run under way. It is a comparison, of a tested source, at least 5 s
/// after the start, and not at rest: there fixes are used with larger sigmas.
class UnderWay {
 public:
  /// `sources`: their names; `start`: time of the start.
  UnderWay(const Log& log, const std::vector<std::string>& sources, double start,
           LookedAt looked_at = LookedAt::kFixes);
  bool contains(const Innovation& innovation) const;

 private:
  const Log& log_;
  std::vector<bool> looked_at_;
  double start_;
};

/// The residuals of a smoothed track at the fixes under way whose positions the filter used, from rows that come in
/// pieces.
class SmoothedResiduals {
 public:
  /// `filtered` has the innovations. All must outlive this.
  SmoothedResiduals(const Log& log, const FilterOptions& options, const Solution& filtered);
  /// @pre the next rows of the run
  void add(const Solution& rows);
  /// Of each receiver: the rms over the axes and the fixes, in sigmas of the fix; NaN where there was none.
  std::vector<double> rms() const;

 private:
  struct Receiver {
    int source = -1;
    std::size_t innovation = 0, fix = 0;  // the next to look at; the fix that waits for its rows
    bool waits = false;
    double delay = 0, sum = 0;
    std::size_t count = 0;
  };
  void begin(const Solution& rows);
  void find_next(std::size_t k);
  double delay_of(std::size_t k, const Solution& rows, std::size_t i) const;
  void compare(std::size_t k, const GnssFix& fix, double before, const Estimate& x_before, const Solution& rows,
               std::size_t after);

  const Log& log_;
  const FilterOptions& options_;
  const Solution& filtered_;
  std::optional<UnderWay> under_way_;
  std::vector<Receiver> receivers_;
  double time_ = 0;  // of the last row so far
  Estimate before_;
};

/// The verdict without findings. `smoothed` may be null. `residuals`: the result of SmoothedResiduals, where `smoothed`
/// has only a part of its rows.
Verdict judge(const Log& log, const FilterOptions& options, const Solution& filtered, const Solution* smoothed,
              const std::vector<double>& residuals = {});

/// Whether the errors are smaller than their sigmas by so much that verdict_line() says so.
bool has_too_large_sigmas(const Verdict& verdict);

/// The verdict in one line: `sigmas hold`, or the fault and the first finding.
std::string verdict_line(const Verdict& verdict);

}  // namespace piste
