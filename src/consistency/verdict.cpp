#include "piste/consistency/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "core/time_search.h"
#include "math/words.h"
#include "piste/model/dual_heading.h"
#include "piste/model/gnss.h"
#include "piste/model/height.h"
#include "piste/model/vehicle.h"

namespace piste {
namespace {

constexpr double kSettling = 5;                  // s after the start in which innovations depend on the start
constexpr std::size_t kFewestMeasurements = 30;  // measurements: with fewer there is no verdict on a source
// Beyond chance, and beyond what linearisation and a start from the same data do to true sigmas.
constexpr double kSure = 5;  // standard errors
constexpr Band kNis{0.7, 1.3}, kMedian{0.6, 1.6};
constexpr double kWhite = 0.25, kMostRejected = 0.2;
constexpr double kWellKnown = 0.7;  // of the prior sigma: a constant known less well does not test its prior

// Of as many rows as a measurement has.
double median_of_chi_squared(int rows) {
  static const std::array<double, 3> kMedians{chi_squared_quantile(0.5, 1), chi_squared_quantile(0.5, 2),
                                              chi_squared_quantile(0.5, 3)};
  return kMedians.at(static_cast<std::size_t>(rows - 1));
}

// The series of one source.
struct Series {
  std::vector<double> used, all;            // NIS per row; NIS over the median of χ² of as many rows
  std::array<std::vector<double>, 3> axes;  // normalised innovations that were used
  std::size_t rejected = 0;

  void add(const Innovation& v) {
    const double rows = v.dof;
    all.push_back(v.nis / median_of_chi_squared(v.dof));
    if (!was_used(v.outcome)) {
      ++rejected;
      return;
    }
    used.push_back(v.nis / rows);
    for (int a = 0; a < v.dof; ++a) axes[static_cast<std::size_t>(a)].push_back(v.residual(a) / v.sigma(a));
  }

  // `slow`: a slow part is stated, so that innovations may well be smaller than the sigmas.
  SourceVerdict verdict(const std::string& name, bool slow) const {
    const auto fits = [slow](const auto& range, double value) { return range.contains(value) || (slow && value < 1); };
    SourceVerdict s{.name = name, .fixes = all.size()};
    if (all.size() < kFewestMeasurements) return s;
    const auto count = static_cast<double>(all.size());
    s.rejected = static_cast<double>(rejected) / count;
    s.ratio = median(all);
    if (s.rejected > kMostRejected) {
      s.reasons.push_back(fmt::format("{:.0f} % of its {} measurements are rejected; up to {:.0f} % may be",
                                      100 * s.rejected, s.fixes, 100 * kMostRejected));
    }
    if (!fits(kMedian, s.ratio)) {
      s.reasons.push_back(
          fmt::format("the median square of its innovations is {} times that of true sigmas; {} to {} times may be",
                      plain(s.ratio, 3), kMedian.low, kMedian.high));
    }
    s.holds = s.reasons.empty();
    if (used.size() < kFewestMeasurements) return s;
    s.nis = mean(used);
    s.nis_error = standard_error_of_series(used);
    s.band = kSure / std::sqrt(static_cast<double>(used.size()));
    s.whiteness = 0;
    for (const std::vector<double>& x : axes) {
      const double power = x.size() < kFewestMeasurements ? 0 : autocovariance(x, 0, 0);
      const double rho = power > 0 ? autocovariance(x, 1, 0) / power : 0;
      if (std::abs(rho) > std::abs(s.whiteness)) s.whiteness = rho;
    }
    if (!fits(kNis, s.nis) && std::abs(s.nis - 1) >= kSure * s.nis_error) {
      s.reasons.push_back(fmt::format("the mean square of its innovations, in sigmas, is {} ± {}; {} to {} may be",
                                      plain(s.nis, 3), plain(s.nis_error, 2), kNis.low, kNis.high));
    }
    if (const double most = std::max(kWhite, s.band); std::abs(s.whiteness) >= most) {
      s.reasons.push_back(
          fmt::format("its innovations follow each other with a correlation of {:.2f}; up to ± {} may be", s.whiteness,
                      plain(most, 2)));
    }
    s.holds = s.reasons.empty();
    return s;
  }
};

std::vector<PriorJump> prior_jumps(const FilterOptions& options, const Solution& solution) {
  std::vector<PriorJump> jumps;
  if (solution.empty()) return jumps;
  const Estimate x = solution.estimate(solution.size() - 1);
  const FullError sigmas = solution.sigmas(solution.size() - 1).blocks;
  for (const BlockInfo& row : kBlocks) {
    if (row.prior == nullptr || is_rotation(row.block) || !solution.layout().has(row.block)) continue;
    const BlockValues change = shown_value(x, row.block) - stated_value(options, row.block), prior = row.prior(options);
    for (int axis = 0; axis < row.size; ++axis) {
      const double sigma = sigmas(full_offset(row.block) + axis);
      if (sigma > kWellKnown * prior(axis)) continue;
      jumps.push_back({fmt::format("{} {}", row.name, row.axes[static_cast<std::size_t>(axis)]),
                       change(axis) / std::sqrt(square(prior(axis)) - square(sigma))});
    }
  }
  std::stable_sort(jumps.begin(), jumps.end(),
                   [](const PriorJump& a, const PriorJump& b) { return std::abs(a.sigmas) > std::abs(b.sigmas); });
  return jumps;
}

// Whether the positions of this source have a slow part that is a share of what they state.
bool states_slow_part(const std::vector<GnssOptions>& receivers, std::string_view source) {
  for (std::size_t k = 0; k < receivers.size(); ++k) {
    const auto& drift = receivers[k].drift;
    if (drift && drift->of_stated && source == fmt::format("gnss[{}].position", k)) return true;
  }
  return false;
}

// Where the estimate expects a fix of the receiver, in w.
Vector3d place_of(const GnssFix& fix, const GnssOptions& receiver, std::size_t index, const World& world,
                  const StateLayout& layout, const Estimate& x) {
  Vector3d arm = layout.has(Block::kLeverArm) ? x.lever_arm : receiver.lever_arm;
  if (receiver.lever_arm_sway) arm += additive(x, lever_arm_sway_block(static_cast<int>(index)));
  const Vector3d p = x.p_wb + x.q_wb * arm;
  return receiver.drift ? p + world.rotation_wn(p) * slow_error(fix, receiver.drift, static_cast<int>(index), x) : p;
}

}  // namespace

UnderWay::UnderWay(const Log& log, const std::vector<std::string>& sources, double start, LookedAt looked_at)
    : log_(log), start_(start + kSettling) {
  for (const std::string& name : sources) {
    const bool fixes = name.starts_with("gnss") || name.starts_with("attitude"),
               aid = name == Odometer::kName || name == Barometer::kName || name == DualHeading::kName;
    looked_at_.push_back(fixes || (aid && looked_at == LookedAt::kMeasured));
  }
}

bool UnderWay::contains(const Innovation& v) const {
  if (!looked_at_[static_cast<std::size_t>(v.source)] || v.outcome == Outcome::kRepeated) return false;
  const double time = v.time + v.late;
  return time >= start_ &&
         std::none_of(log_.rest.begin(), log_.rest.end(), [&](const Interval& rest) { return rest.contains(time); });
}

SmoothedResiduals::SmoothedResiduals(const Log& log, const FilterOptions& options, const Solution& filtered)
    : log_(log), options_(options), filtered_(filtered), receivers_(log.gnss.size()) {
  for (std::size_t k = 0; k < receivers_.size(); ++k) {
    const auto source =
        std::find(filtered.sources.begin(), filtered.sources.end(), fmt::format("gnss[{}].position", k));
    if (source != filtered.sources.end()) receivers_[k].source = static_cast<int>(source - filtered.sources.begin());
  }
}

void SmoothedResiduals::find_next(std::size_t k) {
  constexpr double kSameTime = 1e-6;  // s
  Receiver& r = receivers_[k];
  const std::vector<GnssFix>& fixes = log_.gnss[k];
  const std::vector<Innovation>& innovations = filtered_.innovations;
  for (r.waits = false; !r.waits && r.innovation < innovations.size(); ++r.innovation) {
    const Innovation& v = innovations[r.innovation];
    if (v.source != r.source || !was_used(v.outcome) || !under_way_->contains(v)) continue;
    while (r.fix < fixes.size() && fixes[r.fix].time < v.time + v.late - kSameTime) ++r.fix;
    if (r.fix == fixes.size()) break;
    r.waits = true;
  }
}

void SmoothedResiduals::begin(const Solution& rows) {
  under_way_.emplace(log_, filtered_.sources, rows.time(0));
  for (std::size_t k = 0; k < receivers_.size(); ++k) {
    receivers_[k].delay = delay_of(k, rows, 0);
    if (receivers_[k].source >= 0) find_next(k);
  }
}

// The delay of a receiver's positions, by the estimate of a row.
double SmoothedResiduals::delay_of(std::size_t k, const Solution& rows, std::size_t i) const {
  const double elapsed = rows.time(i) - options_.clock_from.value_or(filtered_.time(0));
  return GnssReceivers::delay(options_, rows.layout(), static_cast<int>(k), 0, rows.estimate(i), elapsed).value;
}

void SmoothedResiduals::add(const Solution& rows) {
  if (rows.empty()) return;
  const bool first = !under_way_;
  if (first) begin(rows);
  for (std::size_t k = 0; k < receivers_.size(); ++k) {
    Receiver& r = receivers_[k];
    for (std::size_t i = 0; i < rows.size() && r.waits; ++i) {
      if (rows.layout().has(Block::kClockDrift)) r.delay = delay_of(k, rows, i);
      for (; r.waits && log_.gnss[k][r.fix].time - r.delay <= rows.time(i); find_next(k)) {
        if (i == 0 && first) continue;
        compare(k, log_.gnss[k][r.fix], i > 0 ? rows.time(i - 1) : time_, i > 0 ? rows.estimate(i - 1) : before_, rows,
                i);
      }
    }
  }
  time_ = rows.time(rows.size() - 1);
  before_ = rows.estimate(rows.size() - 1);
}

void SmoothedResiduals::compare(std::size_t k, const GnssFix& fix, double before, const Estimate& x_before,
                                const Solution& rows, std::size_t after) {
  Receiver& r = receivers_[k];
  const double part = (fix.time - r.delay - before) / (rows.time(after) - before);
  const auto place = [&](const Estimate& x) {
    return place_of(fix, options_.gnss[k], k, rows.world(), rows.layout(), x);
  };
  const Vector3d antenna = (1 - part) * place(x_before) + part * place(rows.estimate(after));
  const Vector3d residual = rows.world().rotation_wn(antenna).transpose() * (fix.position - antenna);
  r.sum += residual.cwiseQuotient(fix.sigma_position).squaredNorm() / 3;
  ++r.count;
}

std::vector<double> SmoothedResiduals::rms() const {
  std::vector<double> all;
  for (const Receiver& r : receivers_)
    all.push_back(r.count > 0 ? std::sqrt(r.sum / static_cast<double>(r.count)) : kNaN);
  return all;
}

BlockValues stated_value(const FilterOptions& options, Block block) {
  Estimate x;
  if (!options.gnss.empty()) {
    x.lever_arm = options.gnss.front().lever_arm;
    x.gnss_delay = options.gnss.front().delay;
    x.velocity_delay = options.gnss.front().delay_of_velocity();
  }
  if (!options.attitude.empty()) x.attitude_delay = options.attitude.front().delay;
  return shown_value(x, block);
}

bool may_be_slow(const std::vector<GnssOptions>& receivers, std::string_view source) {
  for (std::size_t k = 0; k < receivers.size(); ++k) {
    if (source == fmt::format("gnss[{}].position", k)) return !receivers[k].white;
  }
  return false;
}

Verdict judge(const Log& log, const FilterOptions& options, const Solution& filtered, const Solution* smoothed,
              const std::vector<double>& residuals) {
  Verdict verdict;
  if (filtered.empty()) return verdict;
  if (smoothed != nullptr && residuals.empty() && !log.gnss.empty()) {
    SmoothedResiduals of_all(log, options, filtered);
    of_all.add(*smoothed);
    return judge(log, options, filtered, smoothed, of_all.rms());
  }
  const UnderWay under_way(log, filtered.sources, filtered.time(0));
  std::vector<Series> series(filtered.sources.size());
  for (const Innovation& v : filtered.innovations) {
    if (under_way.contains(v)) series[static_cast<std::size_t>(v.source)].add(v);
  }
  for (std::size_t i = 0; i < series.size(); ++i) {
    if (series[i].all.empty()) continue;
    SourceVerdict s = series[i].verdict(filtered.sources[i], states_slow_part(options.gnss, filtered.sources[i]));
    for (std::size_t k = 0; k < residuals.size(); ++k) {
      if (s.name == fmt::format("gnss[{}].position", k)) s.smoothed = residuals[k];
    }
    verdict.consistent = verdict.consistent && s.holds;
    if (!s.holds) {
      const double nis = std::isnan(s.nis) ? s.ratio : s.nis;
      // If values exceed the gate, only the median estimates the factor; otherwise the mean is more accurate.
      const double factor = std::sqrt(nis > 1 ? std::max(nis, s.ratio) : nis);
      // Innovations of positions observe the white part alone, and not that the total is stated too large.
      if (factor < 1 && may_be_slow(options.gnss, s.name)) {
        verdict.slow_part = verdict.slow_part || !states_slow_part(options.gnss, s.name);
      } else if (std::abs(std::log(factor)) > std::abs(std::log(verdict.factor))) {
        verdict.factor = factor;
      }
    }
    verdict.sources.push_back(std::move(s));
  }
  verdict.jumps = prior_jumps(options, smoothed != nullptr && !smoothed->empty() ? *smoothed : filtered);
  if (!verdict.jumps.empty() && std::abs(verdict.jumps.front().sigmas) > kFarFromPrior) verdict.consistent = false;
  return verdict;
}

namespace {

constexpr double kWorthReporting = 1.15;  // a factor of sigmas

}  // namespace

bool has_too_large_sigmas(const Verdict& verdict) {
  return !verdict.consistent && verdict.factor < 1 / kWorthReporting;
}

std::string verdict_line(const Verdict& verdict) {
  if (verdict.consistent) return "sigmas hold";
  std::string line = "sigmas do not hold";
  if (verdict.factor > kWorthReporting) line = "sigmas are too small by " + plain(verdict.factor, 2);
  if (has_too_large_sigmas(verdict)) line = "sigmas are too large by " + plain(1 / verdict.factor, 2);
  if (!verdict.findings.empty()) line += ": " + verdict.findings.front();
  return verdict.slow_part ? fmt::format("{}. {}", line, kInnovationsCannotTell) : line;
}

}  // namespace piste
