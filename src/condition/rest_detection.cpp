#include "piste/condition/rest_detection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "core/time_search.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

// Root-mean-square deviations of rate and force from their means over a window, and the means.
struct Quietness {
  double gyro = 0, force = 0;
  Vector3d mean_gyro = Vector3d::Zero(), mean_force = Vector3d::Zero();
};

struct CellSums {
  double n = 0, gyro2 = 0, force2 = 0;
  Vector3d gyro = Vector3d::Zero(), force = Vector3d::Zero();
  bool gap = false;
};

struct Cells {
  double begin = 0, length = 0;
  std::vector<CellSums> sums;
  double time(std::size_t i) const { return begin + length * static_cast<double>(i); }
};

Cells cells_of(const std::vector<ImuSample>& imu, double length) {
  Cells cells;
  cells.length = length;
  cells.begin = imu.front().time - imu.front().interval;
  cells.sums.resize(static_cast<std::size_t>((imu.back().time - cells.begin) / length) + 1);
  for (const ImuSample& s : imu) {
    CellSums& c = cells.sums[static_cast<std::size_t>((s.time - 0.5 * s.interval - cells.begin) / length)];
    const Vector3d w = s.dtheta / s.interval, f = s.dvel / s.interval;
    c.n += 1;
    c.gyro += w;
    c.force += f;
    c.gyro2 += w.squaredNorm();
    c.force2 += f.squaredNorm();
    c.gap = c.gap || s.gap;
  }
  return cells;
}

// Of the window [first, last) of cells.
std::optional<Quietness> quietness(const Cells& cells, std::size_t first, std::size_t last) {
  CellSums total;
  for (std::size_t i = first; i < last; ++i) {
    const CellSums& c = cells.sums[i];
    if (c.gap || c.n < 1) return std::nullopt;
    total.n += c.n;
    total.gyro += c.gyro;
    total.force += c.force;
    total.gyro2 += c.gyro2;
    total.force2 += c.force2;
  }
  Quietness q;
  q.mean_gyro = total.gyro / total.n;
  q.mean_force = total.force / total.n;
  q.gyro = std::sqrt(std::max(0.0, total.gyro2 / total.n - q.mean_gyro.squaredNorm()));
  q.force = std::sqrt(std::max(0.0, total.force2 / total.n - q.mean_force.squaredNorm()));
  return q;
}

enum class Verdict { kUnknown, kRest, kBetween, kMoving };

// The speed that a receiver shows, and its noise.
struct Speed {
  double value = 0, noise = std::numeric_limits<double>::infinity();
};

Speed from_velocities(std::span<const GnssFix> fixes) {
  Vector3d mean = Vector3d::Zero(), variance = Vector3d::Zero();
  double n = 0;
  for (const GnssFix& fix : fixes) {
    if (!fix.velocity) continue;
    mean += fix.velocity->value;
    variance.head<2>() += fix.velocity->sigma.head<2>().cwiseAbs2();
    if (fix.velocity->has_down()) variance.z() += square(fix.velocity->sigma.z());
    n += 1;
  }
  if (n == 0) return {};
  return {(mean / n).norm(), std::sqrt(variance.sum()) / n};
}

// The horizontal distance of two positions, and its noise [m].
struct Horizontal {
  double distance, noise;
};

Horizontal horizontal(const World& world, const GnssFix& first, const GnssFix& last) {
  const Matrix3d R_nw = world.rotation_wn(first.position).transpose();
  return {(R_nw * (last.position - first.position)).head<2>().norm(),
          std::sqrt((first.sigma_position.cwiseAbs2() + last.sigma_position.cwiseAbs2()).head<2>().sum())};
}

// From the first to the last position. Errors of a receiver last, so that those between them do not lower the noise.
Speed from_positions(const World& world, std::span<const GnssFix> fixes, double least_time) {
  if (fixes.size() < 2) return {};
  const GnssFix &first = fixes.front(), &last = fixes.back();
  const double dt = last.time - first.time;
  if (dt < least_time) return {};
  const Horizontal apart = horizontal(world, first, last);
  return {apart.distance / dt, apart.noise / dt};
}

Verdict verdict(const Speed& speed, const RestOptions& options) {
  if (speed.value > options.moving + options.moving_sigmas * speed.noise) return Verdict::kMoving;
  if (speed.noise > options.resolved) return Verdict::kUnknown;
  return speed.value < options.sway + options.rest_sigmas * speed.noise ? Verdict::kRest : Verdict::kBetween;
}

// Whether one receiver shows rest or motion in [begin, end]: by its velocities and, where these do not decide, by
// positions. The coarser the positions, the longer their span may be.
Verdict verdict(const World& world, const std::vector<GnssFix>& fixes, double begin, double end,
                const RestOptions& options) {
  const auto within = [&](double reach) { return range(fixes, begin - reach, end + reach + 1e-9); };
  const Verdict by_velocity = verdict(from_velocities(within(0)), options);
  if (by_velocity != Verdict::kUnknown) return by_velocity;
  Verdict by_position = Verdict::kUnknown;
  for (double reach = 0; reach <= options.farthest && by_position == Verdict::kUnknown;
       reach = std::max(0.5, 2 * reach)) {
    by_position = verdict(from_positions(world, within(reach), 0.5 * (end - begin) + reach), options);
  }
  return by_position;
}

// Bounds below which rate and force count as at rest: where GNSS says so too, and where there is no GNSS.
struct Bounds {
  double gyro = 0, force = 0;
  double gyro_alone = 0, force_alone = 0;
};

constexpr double kQuietest = 0.05;  // of the windows that a receiver takes for rest

Bounds learn(const std::vector<std::optional<Quietness>>& quiet, const std::vector<Verdict>& verdicts,
             const RestOptions& options) {
  std::vector<double> rest_gyro, rest_force, moving_gyro, moving_force;
  for (std::size_t i = 0; i < quiet.size(); ++i) {
    if (!quiet[i]) continue;
    if (verdicts[i] == Verdict::kRest) {
      rest_gyro.push_back(quiet[i]->gyro);
      rest_force.push_back(quiet[i]->force);
    } else if (verdicts[i] == Verdict::kMoving) {
      moving_gyro.push_back(quiet[i]->gyro);
      moving_force.push_back(quiet[i]->force);
    }
  }
  Bounds b{.gyro = options.gyro_quiet, .force = options.force_quiet};
  if (rest_gyro.size() < 2 * options.window) {
    return b;  // the level of rest is unknown: without GNSS no rest is reported
  }
  const bool some_motion = moving_gyro.size() >= 2 * options.window;
  // Coarse fixes take what is slow, or stops every few seconds, for rest. Where half of that is as loud as motion, or,
  // as nothing certainly moves, far louder than its quietest windows, these show the level of rest.
  const auto is_of_rest = [&](const std::vector<double>& at_rest, const std::vector<double>& moving) {
    return quantile(at_rest, 0.5) < (some_motion ? quantile(moving, options.moving_quantile)
                                                 : square(options.as_quiet) * quantile(at_rest, kQuietest));
  };
  const bool separate = is_of_rest(rest_gyro, moving_gyro) || is_of_rest(rest_force, moving_force);
  const double middle = separate ? 0.5 : kQuietest;
  b.gyro = options.as_quiet * quantile(rest_gyro, middle);
  b.force = options.as_quiet * quantile(rest_force, middle);
  b.gyro_alone = options.alone_factor * quantile(rest_gyro, separate ? options.alone_quantile : middle);
  b.force_alone = options.alone_factor * quantile(rest_force, separate ? options.alone_quantile : middle);
  if (some_motion) {
    b.gyro_alone = std::min(b.gyro_alone, quantile(moving_gyro, options.moving_quantile));
    b.force_alone = std::min(b.force_alone, quantile(moving_force, options.moving_quantile));
  }
  return b;
}

// The intervals of consecutive cells at rest, in a log that ends at `end`.
std::vector<Interval> intervals_of(const std::vector<bool>& rest, const Cells& cells, double end,
                                   const RestOptions& options) {
  std::vector<Interval> intervals;
  for (std::size_t i = 0; i < rest.size();) {
    std::size_t j = i;
    while (j < rest.size() && rest[j]) ++j;
    if (j > i) {
      const Interval drawn{cells.time(i) + (i ? options.drawn_in : 0),
                           std::min(cells.time(j) - (j < rest.size() ? options.drawn_in : 0), end)};
      if (drawn.end - drawn.start >= options.shortest) intervals.push_back(drawn);
    }
    i = std::max(j, i + 1);
  }
  return intervals;
}

void mark(std::vector<bool>& rest, std::size_t first, std::size_t count) {
  std::fill_n(rest.begin() + static_cast<std::ptrdiff_t>(first), count, true);
}

// The mean force of a standstill, and how far that of a window may be from it along each axis.
struct StandingForce {
  Vector3d middle, bound;

  StandingForce(const std::vector<Vector3d>& forces, const RestOptions& options) : middle(median_by_axis(forces)) {
    std::vector<Vector3d> off;
    off.reserve(forces.size());
    for (const Vector3d& force : forces) off.emplace_back((force - middle).cwiseAbs());
    bound = Vector3d::Constant(options.force_quiet) + options.as_quiet * kSigmaOverMedian * median_by_axis(off);
  }
  bool holds(const Vector3d& force) const { return ((force - middle).cwiseAbs().array() <= bound.array()).all(); }
};

// Cuts from the ends of each run of cells at rest what no receiver has confirmed and where the mean force of a window
// is not that of the rest. A car that rolls off at a constant thrust is as quiet as before: only its mean force shows
// it. No more than `halved` is cut: who stands for longer with another force has leant.
void cut_departures(std::vector<bool>& rest, const std::vector<std::optional<Quietness>>& quiet,
                    const std::vector<Verdict>& verdicts, const RestOptions& options) {
  const std::size_t window = options.window, most = static_cast<std::size_t>(options.halved / options.cell);
  for (std::size_t i = 0, j = 0; i < rest.size(); i = std::max(j, i + 1)) {
    for (j = i; j < rest.size() && rest[j];) ++j;
    if (j < i + 2 * window) continue;  // both ends of so short a rest are all of it
    std::vector<Vector3d> forces;      // of its windows, which begin at i to j − window
    for (std::size_t k = i; k + window <= j; ++k) {
      if (quiet[k]) forces.push_back(quiet[k]->mean_force);
    }
    const StandingForce standing(forces, options);
    const auto departs = [&](std::size_t k) {
      return verdicts[k] == Verdict::kUnknown && quiet[k] && !standing.holds(quiet[k]->mean_force);
    };
    std::size_t first = i, last = j;
    while (first < i + most && first + window < last && departs(first)) rest[first++] = false;
    while (last + most > j && first + window < last && departs(last - window)) rest[--last] = false;
  }
}

// Whether a receiver shows that the body left its place within a claimed rest: its last positions there are further
// from the first than their sigmas and a sway allow.
bool leaves_its_place(const Log& log, const Interval& rest, const RestOptions& options) {
  return std::any_of(log.gnss.begin(), log.gnss.end(), [&](const std::vector<GnssFix>& receiver) {
    const auto fixes = range(receiver, rest.start, rest.end);
    if (fixes.size() < 2) return false;
    const Horizontal apart = horizontal(log.world, fixes.front(), fixes.back());
    return apart.distance > options.sway_distance + 3 * apart.noise;
  });
}

// Whether the body turns within a claimed rest: the rate leaves its own mean, which is the bias, by some degrees.
bool turns(const Log& log, const Interval& rest, const RestOptions& options) {
  const auto samples = range(log.imu, rest.start, rest.end);
  Vector3d all = Vector3d::Zero(), turn = Vector3d::Zero();
  double time = 0, largest = 0;
  for (const ImuSample& s : samples) {
    all += s.dtheta;
    time += s.interval;
  }
  if (time <= 0) return true;
  for (const ImuSample& s : samples) {
    turn += s.dtheta - s.interval / time * all;
    largest = std::max(largest, turn.norm());
  }
  return largest > options.turn;
}

// The claimed rests, tested over their whole length. One that fails is halved, and its halves are tested.
std::vector<Interval> confirmed(const Log& log, const std::vector<Interval>& claimed, const RestOptions& options) {
  std::vector<Interval> rests;
  const auto test = [&](const auto& self, const Interval& rest, bool part) -> void {
    if (!leaves_its_place(log, rest, options) && !turns(log, rest, options)) {
      if (!part || rest.end - rest.start >= options.halved) rests.push_back(rest);
    } else if (rest.end - rest.start >= 2 * options.halved) {
      const double middle = 0.5 * (rest.start + rest.end);
      self(self, {rest.start, middle}, true);
      self(self, {middle, rest.end}, true);
    }
  };
  for (const Interval& rest : claimed) test(test, rest, false);
  return rests;
}

}  // namespace

std::vector<Interval> detect_rest(const Log& log, const RestOptions& options) {
  const std::size_t window = options.window;
  if (log.imu.size() < 2 * window) return {};
  const Cells cells = cells_of(log.imu, options.cell);
  if (cells.sums.size() < window) return {};
  const std::size_t windows = cells.sums.size() - window + 1;
  std::vector<std::optional<Quietness>> quiet(windows);
  std::vector<Verdict> verdicts(windows, Verdict::kUnknown);
  for (std::size_t i = 0; i < windows; ++i) {
    quiet[i] = quietness(cells, i, i + window);
    for (const auto& fixes : log.gnss) {
      verdicts[i] = std::max(verdicts[i], verdict(log.world, fixes, cells.time(i), cells.time(i + window), options));
    }
  }
  const Bounds bounds = learn(quiet, verdicts, options);
  std::vector<bool> rest(cells.sums.size(), false);
  for (std::size_t i = 0; i < windows; ++i) {
    if (!quiet[i]) continue;
    const bool alone = verdicts[i] == Verdict::kUnknown;
    const bool still = alone || verdicts[i] == Verdict::kRest;
    if (!still) continue;
    if (quiet[i]->gyro > (alone ? bounds.gyro_alone : bounds.gyro)) continue;
    if (quiet[i]->force > (alone ? bounds.force_alone : bounds.force)) continue;
    mark(rest, i, window);
  }
  cut_departures(rest, quiet, verdicts, options);
  return confirmed(log, intervals_of(rest, cells, log.imu.back().time, options), options);
}

std::vector<Interval> detect_rest(const AlignedImus& imus, const RestOptions& options) {
  const std::size_t window = options.window;
  if (imus.time.size() < 2 * window) return {};
  std::vector<ImuSample> reference(imus.time.size());
  for (std::size_t i = 0; i < reference.size(); ++i) {
    ImuSample& s = reference[i];
    s.time = imus.time[i];
    s.interval = imus.interval;
    s.dtheta = imus.interval * imus.reference_gyro[i];
    s.dvel = imus.interval * imus.reference_accel[i];
    if (!imus.usable[i]) s.gap = GapNoise{};
  }
  const Cells cells = cells_of(reference, options.cell);
  std::vector<bool> rest(cells.sums.size(), false);
  for (std::size_t i = 0; i + window <= cells.sums.size(); ++i) {
    const auto quiet = quietness(cells, i, i + window);
    if (!quiet || quiet->mean_gyro.norm() > options.turning) continue;
    if (quiet->gyro <= options.gyro_quiet && quiet->force <= options.force_quiet) mark(rest, i, window);
  }
  return intervals_of(rest, cells, imus.time.back(), options);
}

Log with_rest(Log log, std::vector<Interval> rest) {
  log.rest = std::move(rest);
  auto interval = log.rest.begin();
  for (ImuSample& s : log.imu) {
    while (interval != log.rest.end() && interval->end < s.time) ++interval;
    s.at_rest = interval != log.rest.end() && interval->start <= s.time - s.interval + 1e-9 && s.time <= interval->end;
  }
  return log;
}

}  // namespace piste
