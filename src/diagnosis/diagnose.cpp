#include "piste/diagnosis/diagnose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "diagnosis/causes.h"
#include "piste/core/time_search.h"
#include "piste/diagnosis/unit_axes.h"
#include "piste/math/so3.h"
#include "piste/math/statistics.h"
#include "piste/solve/initial_state.h"
#include "piste/solve/run.h"
#include "solve/feeder.h"
#include "tune/held_delays.h"

namespace piste {
namespace {

constexpr double kLongest = 150;      // s of motion that are filtered again
constexpr double kSuspicious = 0.02;  // share of rejected fixes beyond which a cause is looked for
constexpr double kLikelier = 15;      // of the log-likelihood, for a cause to be one: by chance it gains a few
constexpr double kBesides = 0.2;      // of the best gain, for a further one to be named
constexpr std::size_t kNamed = 4;
constexpr double kWrong = 3, kUnused = 0.3;  // factor of the sigmas, share rejected: it may be the axes

// Less than it takes to doubt the sigmas: the likelihood of a cause decides then.
bool suspicious(const Verdict& verdict) {
  constexpr double kUnlikely = 3, kLittle = 0.05, kPartOfBand = 0.8;
  return !verdict.consistent ||
         std::any_of(verdict.sources.begin(), verdict.sources.end(), [=](const SourceVerdict& s) {
           return s.rejected > kSuspicious || std::abs(s.nis - 1) > std::max(kLittle, kUnlikely * s.nis_error) ||
                  std::abs(s.whiteness) > kPartOfBand * s.band;
         });
}

// Whether wheels, barometer or antennas contradict the rest by more than their sigmas say. The verdict does not judge
// them, but their sigmas may be the cause.
bool aids_doubtful(const Log& log, const Solution& filtered) {
  constexpr double kTooFar = 1.5, kTooMany = 0.2;  // NIS of a row; share of what is left out
  constexpr std::size_t kFewest = 30;
  const UnderWay fixes(log, filtered.sources, filtered.time(0)),
      measured(log, filtered.sources, filtered.time(0), LookedAt::kMeasured);
  struct Sum {
    std::size_t used = 0, left_out = 0;
    double nis = 0;
  };
  std::vector<Sum> of(filtered.sources.size());
  for (const Innovation& v : filtered.innovations) {
    if (!measured.contains(v) || fixes.contains(v)) continue;
    Sum& sum = of[static_cast<std::size_t>(v.source)];
    if (was_used(v.outcome)) {
      ++sum.used;
      sum.nis += v.nis / v.dof;
    } else {
      ++sum.left_out;
    }
  }
  return std::ranges::any_of(of, [](const Sum& sum) {
    const auto all = static_cast<double>(sum.used + sum.left_out);
    return sum.used + sum.left_out >= kFewest &&
           (sum.nis > kTooFar * static_cast<double>(sum.used) || static_cast<double>(sum.left_out) > kTooMany * all);
  });
}

bool far_off(const Verdict& verdict) {
  return verdict.factor > kWrong || std::any_of(verdict.sources.begin(), verdict.sources.end(),
                                                [](const SourceVerdict& s) { return s.rejected > kUnused; });
}

// Where the first rest ends.
double departure(const Log& log, double start) {
  return !log.rest.empty() && log.rest.front().contains(start + 1) ? log.rest.front().end : start;
}

// The log until `end`: hours are not copied to filter minutes. A member that is new to Log does not compile here until
// it is cut as well.
Log first_part(const Log& log, double end) {
  const auto cut = [end](const auto& items) {
    return std::decay_t<decltype(items)>(items.begin(), first_at_or_after(items, end));
  };
  const auto cut_each = [&cut](const auto& sensors) {
    std::decay_t<decltype(sensors)> part;
    for (const auto& items : sensors) part.push_back(cut(items));
    return part;
  };
  const auto& [world, imu, gnss, attitude, magnetic, speed, height, heading, parity, rest, counts] = log;
  return {.world = world,
          .imu = cut(imu),
          .gnss = cut_each(gnss),
          .attitude = cut_each(attitude),
          .magnetic = cut(magnetic),
          .speed = cut(speed),
          .height = cut(height),
          .heading = cut(heading),
          .parity = cut_each(parity),
          .rest = rest,
          .counts = counts};
}

// Where the causes are tried from: the start, or the last minute of a long first rest, which each of them would filter
// anew. Of the start the navigation alone: every cause has its own blocks beside.
Start tried_from(const Log& log, const FilterOptions& options, const Start& start, double departs) {
  constexpr double kRest = 60;  // s
  Start from = start;
  if (departs - start.time > 2 * kRest) {
    Filter filter(options, log.world, start);
    LogPlace place = place_at(log, start.time, departs - kRest);
    for (Feeder feeder(log, place, filter); !feeder.done(); filter.clear_innovations()) feeder.step();
    from = {filter.time(), filter.estimate(), filter.covariance()};
  }
  from.covariance = from.covariance.topLeftCorner(9, 9).eval();
  return from;
}

// Values are searched for by likelihoods, which must not leap: with the delays as the run without a cause told them.
Told with_held_delays(const Told& told, const Evidence& base) {
  if (!estimates_delays(told.options) || base.rows == 0) return told;
  return {told.log, holding_delays(told.options), with_delays(told.start, base.last)};
}

// What is wrong, in words, where no cause is known for it.
std::string symptoms(const Verdict& verdict) {
  for (const SourceVerdict& s : verdict.sources) {
    if (s.holds) continue;
    return fmt::format("no single cause explains {} (NIS {:.2g}, correlation {:.2g}, {:.0f} % rejected)", s.name, s.nis,
                       s.whiteness, 100 * s.rejected);
  }
  const PriorJump& jump = verdict.jumps.front();
  return fmt::format("{} is {:.1f} sigmas from its prior", jump.name, jump.sigmas);
}

// By how much the heading that was told for the start leaves what the whole run says of it, in sigmas as for every
// constant. The fixes may follow within seconds, and the verdict does not look at the first of them.
void add_heading_jump(const InitialHeading& heading, const Solution& filtered, const Solution* smoothed,
                      Verdict& verdict) {
  constexpr double kFar = 4.5, kWellKnown = 0.7;  // sigmas; of the sigma that was told
  using Source = InitialHeading::Source;
  if (heading.source != Source::kValue && heading.source != Source::kMagnetometer) return;
  if (smoothed == nullptr || smoothed->empty()) return;
  const double told = filtered.sigmas(0).euler.z(), known = smoothed->sigmas(0).euler.z();
  if (!(known < kWellKnown * told)) return;
  const auto heading_of = [](const Solution& s) {
    const Estimate x = s.estimate(0);
    return to_euler(Matrix3d(s.world().rotation_wn(x.p_wb).transpose() * x.R_wb())).z();
  };
  const double change = std::remainder(heading_of(*smoothed) - heading_of(filtered), 2 * std::numbers::pi);
  const PriorJump jump{"initial heading", change / std::sqrt(square(told) - square(known))};
  const auto smaller = [&](const PriorJump& j) { return std::abs(j.sigmas) < std::abs(jump.sigmas); };
  verdict.jumps.insert(std::ranges::find_if(verdict.jumps, smaller), jump);
  if (std::abs(jump.sigmas) > kFar) verdict.consistent = false;
}

// A magnetometer that shows another field than the Earth's, as one in another unit or one that sticks: the filter
// explains that by iron beyond its prior. What else is then likelier than told only makes up for it.
std::optional<std::string> iron_that_is_none(const Verdict& verdict) {
  constexpr double kFar = 4.5;  // sigmas, as for every jump
  const auto jump = std::ranges::find_if(verdict.jumps, [](const PriorJump& j) {
    return j.name.starts_with("soft_iron") || j.name.starts_with("hard_iron");
  });
  if (jump == verdict.jumps.end() || std::abs(jump->sigmas) < kFar) return std::nullopt;
  return fmt::format(
      "magnetometer ({} is {:.1f} sigmas from its prior; check its unit, its axes, and whether it sticks)", jump->name,
      jump->sigmas);
}

}  // namespace

Verdict diagnose(const Log& log, const FilterOptions& options, const InitialHeading& heading, const FoundStart& found,
                 const Solution& filtered, const Solution* smoothed, const std::function<void(double)>& progress,
                 const std::vector<double>& residuals) {
  Verdict verdict = judge(log, options, filtered, smoothed, residuals);
  if (!filtered.empty()) add_heading_jump(heading, filtered, smoothed, verdict);
  if (filtered.empty() || !(suspicious(verdict) || aids_doubtful(log, filtered))) return verdict;
  constexpr double kBeyond = 2;  // s: fixes that come late, and the neighbour of the last step
  const double departs = departure(log, found.start.time), end = departs + kLongest;
  const Told told{first_part(log, end + kBeyond), options, tried_from(log, options, found.start, departs)};

  const Evidence base = filter_again(told.log, told.options, told.start, end);
  const Told held = with_held_delays(told, base);
  const Evidence held_base =
      estimates_delays(told.options) ? filter_again(held.log, held.options, held.start, end) : base;
  const std::vector<Cause> searched = searched_causes(held);
  std::vector<Cause> others = constant_causes(told, heading);
  const auto add = [&](std::vector<Cause> more) { std::ranges::move(more, std::back_inserter(others)); };
  add(clock_causes(told));
  add(heading_causes(told, heading));
  if (far_off(verdict)) add(axes_causes(told, heading));
  const std::size_t all = searched.size() + others.size();
  std::size_t tried = 0;
  std::vector<Granted> likelier;
  const auto attempt = [&](const std::vector<Cause>& causes, const Told& from, const Evidence& without) {
    for (const Cause& cause : causes) {
      if (progress) progress(static_cast<double>(tried++) / static_cast<double>(all));
      Granted granted = cause(from, without, end);
      if (granted.gain > kLikelier) likelier.push_back(std::move(granted));
    }
  };
  attempt(searched, held, held_base);
  attempt(others, told, base);
  std::stable_sort(likelier.begin(), likelier.end(),
                   [](const Granted& a, const Granted& b) { return a.gain > b.gain; });
  for (std::string& line : unit_axes_lines(log, options.units)) verdict.findings.push_back(std::move(line));
  if (auto magnetometer = iron_that_is_none(verdict)) verdict.findings.push_back(std::move(*magnetometer));
  for (const Granted& granted : likelier) {
    if (verdict.findings.size() == kNamed || granted.gain < kBesides * likelier.front().gain) break;
    verdict.findings.push_back(granted.text);
  }
  if (!verdict.findings.empty()) {
    verdict.consistent = false;
  } else if (!verdict.consistent) {
    verdict.findings.push_back(symptoms(verdict));
  }
  return verdict;
}

}  // namespace piste
