#include "piste/search/rounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/time_search.h"
#include "math/words.h"
#include "model/gnss_white.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "piste/replay/replay.h"
#include "search/contradiction.h"
#include "search/judged.h"

namespace piste {
namespace {

constexpr std::size_t kReplays = 5, kMostTried = 3;  // of the causes of a round

// ---- What fixes show that a run does not use ----

constexpr double kSettled = 20, kWindow = 10, kEvery = 20;  // s: after the start; windows, and from one to the next
constexpr double kUnfelt = 1e3;                             // m: 1-sigma of a fix that a run does not feel
constexpr std::size_t kFewestWindows = 3;

// Variances of the white error of a position, north, east, down.
Vector3d white_variance(const GnssFix& fix, const std::optional<PositionDrift>& slow) {
  return white_factor(fix, slow).rowwise().squaredNorm();
}

// The errors at the ends of windows without fixes of the first receiver, by their sigmas.
struct Withheld {
  std::size_t windows = 0;
  double mean_square = 0;  // of an axis

  // What chance lets it be in one of a thousand logs.
  double most() const {
    const double rows = 3 * static_cast<double>(windows);
    return chi_squared_quantile(0.999, rows) / rows;
  }
  bool too_sure() const { return windows >= kFewestWindows && mean_square > most(); }
};

Withheld withheld(ReplayConfig config) {
  Ready r = ready(std::move(config));
  std::vector<GnssFix>& fixes = r.log.gnss.front();
  const std::optional<PositionDrift> slow = r.options.filter.gnss.front().drift;
  const Replay used = replay(r.log, r.options);
  const double first = used.found.start.time + kSettled, last = used.log.imu.back().time;
  std::map<double, Vector3d> ends;  // the last fix in each window that a run would use: by how much its variance grew
  std::vector<Interval> windows;
  for (double start = first; start + kWindow < last; start += kEvery) {
    const Interval window{start, start + kWindow};
    const bool still = std::ranges::any_of(r.log.rest, [&](const Interval& rest) { return overlap(rest, window) > 0; });
    const Innovation* end = nullptr;
    for (const Innovation& v : used.filtered.solution.innovations) {
      if (used.filtered.solution.sources[static_cast<std::size_t>(v.source)] == "gnss[0].position" &&
          v.outcome == Outcome::kUsed && window.contains(v.time + v.late))
        end = &v;
    }
    if (still || end == nullptr || end->time + end->late < window.end - kWindow / 4) continue;
    const auto fix = first_at_or_after(fixes, end->time + end->late - kSameInstant);
    ends[fix->time] = -white_variance(*fix, slow);
    windows.push_back(window);
  }
  for (const Interval& window : windows) {
    for (std::vector<GnssFix>& receiver : r.log.gnss) {
      for (GnssFix& fix : receiver) {
        if (!window.contains(fix.time)) continue;
        fix.slow_level = fix.slow_level.cwiseProduct(fix.sigma_position) / kUnfelt;
        fix.sigma_position.setConstant(kUnfelt);
        fix.correlation.setZero();
        fix.velocity.reset();
        if (&receiver == &fixes && ends.contains(fix.time)) ends[fix.time] += white_variance(fix, slow);
      }
    }
  }
  const Replay run = replay(std::move(r.log), r.options);
  Withheld found;
  double sum = 0;
  for (const Innovation& v : run.filtered.solution.innovations) {
    if (run.filtered.solution.sources[static_cast<std::size_t>(v.source)] != "gnss[0].position") continue;
    const auto end = ends.lower_bound(v.time + v.late - kSameInstant);
    if (end == ends.end() || end->first > v.time + v.late + kSameInstant) continue;
    const Vector3d variance = v.sigma.cwiseAbs2() - end->second;
    sum += v.residual.cwiseAbs2().cwiseQuotient(variance).sum();
    ++found.windows;
  }
  if (found.windows > 0) found.mean_square = sum / (3 * static_cast<double>(found.windows));
  return found;
}

using Calibrations = std::vector<std::optional<Calibration>>;

Calibrations calibrations_of(const Inspection& found) {
  Calibrations all;
  for (const InspectedLog& log : found.logs) all.push_back(log.calibration);
  return all;
}

void set_calibrations(Inspection& found, const Calibrations& all) {
  for (std::size_t i = 0; i < all.size(); ++i) found.logs[i].calibration = all[i];
}

// The logs of the receivers that a configuration uses, in its order.
std::vector<InspectedLog*> receivers_of(Inspection& found) {
  std::vector<InspectedLog*> all;
  for (InspectedLog& log : found.logs) {
    if (log.is(LogKind::kGnss) && log.gnss_health && log.left_out.empty()) all.push_back(&log);
  }
  return all;
}

bool same(const std::optional<PositionDrift>& a, const std::optional<PositionDrift>& b) {
  return a.has_value() == b.has_value() &&
         (!a || (a->sigma == b->sigma && a->of_stated == b->of_stated && a->correlation_time == b->correlation_time &&
                 a->most_white == b->most_white));
}

// Makes the calibrations state what a cause changes. Returns false where they cannot.
bool apply(const LikelierCause& cause, const ReplayConfig& config, Inspection& found) {
  if (!cause.change || found.calibration() == nullptr) return false;
  StatedModel model{.options = config.filter, .scales = {}};
  for (const LogFile& file : config.gnss) model.scales.push_back(file.sigma_scales);
  const FilterOptions before = model.options;
  cause.change(model);
  const std::vector<InspectedLog*> receivers = receivers_of(found);
  if (receivers.size() != model.scales.size()) return false;
  if (model.clock_drift != 0) {
    Calibration drifting = *found.calibration();
    drifting.clock_drift += model.clock_drift;
    if (!drifts_plausibly(drifting)) return false;  // it stands for another cause
  }
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    std::optional<Calibration>& calibration = receivers[i]->calibration;
    if (!calibration || !calibration->fits()) continue;
    const GnssOptions &now = model.options.gnss[i], &old = before.gnss[i];
    calibration->sigma_scales = model.scales[i];
    if (!same(now.drift, old.drift)) {
      calibration->drift = now.drift;
      calibration->drift_by = DriftBy::kMotion;
    }
    calibration->sway = now.lever_arm_sway;
    calibration->velocity_averaging = now.velocity_averaging;
    if (now.lever_arm != old.lever_arm) calibration->lever_arm = now.lever_arm;
    if (now.velocity_delay && now.velocity_delay != old.velocity_delay && calibration->velocity_delay_sigma > 0)
      calibration->velocity_delay += *now.velocity_delay - old.delay_of_velocity();
    calibration->sensor = model.options.sensor;
    calibration->clock_offset += model.clock_offset;
    calibration->clock_drift += model.clock_drift;
  }
  return true;
}

void widen(TriadErrors& triad, double factor) {
  triad.noise *= factor;
  triad.drift.sigma *= factor;
  triad.drift.density *= factor;
}

}  // namespace

void take_causes(Inspection& found, const std::function<ReplayConfig(const Inspection&)>& configured,
                 const ProgressCallback& progress) {
  found.rounds.clear();
  std::optional<Judged> now = judged(found, configured);
  if (!now) return;
  found.rounds.push_back({.verdict = verdict_line(now->diagnosis.verdict)});
  while (found.rounds.size() < kReplays) {
    const std::vector<LikelierCause> causes = now->diagnosis.causes;
    const double least = std::log(static_cast<double>(std::max<std::size_t>(1, causes.size()))) + 3;
    const Calibrations before = calibrations_of(found);
    std::optional<Judged> better;
    for (std::size_t i = 0; i < std::min(kMostTried, causes.size()) && !better; ++i) {
      if (!apply(causes[i], now->config, found)) continue;
      better = judged(found, configured);
      if (better && better->likelihood - now->likelihood > least) {
        found.rounds.back().taken = causes[i].text;
        found.rounds.back().gain = better->likelihood - now->likelihood;
      } else {
        better.reset();
        set_calibrations(found, before);
      }
    }
    if (progress) progress(static_cast<double>(found.rounds.size()) / static_cast<double>(kReplays));
    if (!better) return;
    now = std::move(better);
    found.rounds.push_back({.verdict = verdict_line(now->diagnosis.verdict)});
  }
}

void widen_by_withheld(Inspection& found, const std::function<ReplayConfig(const Inspection&)>& configured) {
  constexpr int kMost = 3;  // times that it is widened
  if (found.calibration() == nullptr || found.rounds.empty()) return;
  const Calibrations as_found = calibrations_of(found);
  try {
    Withheld now = withheld(configured(found));
    double whole = 1;
    const Withheld at_first = now;
    for (int k = 0; k < kMost && now.too_sure(); ++k) {
      const Calibrations before = calibrations_of(found);
      const double factor = std::sqrt(now.mean_square);
      for (InspectedLog& log : found.logs) {
        if (!log.calibration) continue;
        widen(log.calibration->sensor.gyro, factor);
        widen(log.calibration->sensor.accel, factor);
      }
      const Withheld wider = withheld(configured(found));
      if (!(wider.mean_square < now.mean_square)) {  // it is not the IMU's noise
        set_calibrations(found, before);
        break;
      }
      now = wider;
      whole *= factor;
    }
    if (!at_first.too_sure()) return;
    const std::string shown =
        fmt::format("after {:g} s without fixes, in {} windows, errors are {} of their sigmas (rms)", kWindow,
                    at_first.windows, plain(std::sqrt(at_first.mean_square), 2));
    const std::string left = fmt::format("they are {} now", plain(std::sqrt(now.mean_square), 2));
    found.suspicions.insert(
        found.suspicions.begin(),
        {LogFault::kDoesNotHold, found.logs[*found.first(LogKind::kImu)].log.file, shown,
         whole > 1 ? fmt::format("noise and drift of the IMU are stated {} times as large as the innovations show, "
                                 "and {}; look for the cause: axes, lever arm, clock",
                                 plain(whole, 2), left)
                   : std::string("no noise of the IMU explains that; look for the cause: axes, lever arm, clock")});
    if (whole > 1) {
      found.rounds.back().taken = fmt::format("{}: noise and drift of the IMU times {}", shown, plain(whole, 2));
      if (const auto last = judged(found, configured))
        found.rounds.push_back({.verdict = verdict_line(last->diagnosis.verdict)});
    }
  } catch (const Error&) {  // no replay runs
    set_calibrations(found, as_found);
  }
}

}  // namespace piste
