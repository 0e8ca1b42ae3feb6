#include "piste/diagnosis/diagnose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <type_traits>
#include <utility>

#include "diagnosis/causes.h"
#include "piste/core/time_search.h"
#include "piste/solve/initial_state.h"
#include "piste/solve/run.h"
#include "solve/feeder.h"

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

bool far_off(const Verdict& verdict) {
  return verdict.factor > kWrong || std::any_of(verdict.sources.begin(), verdict.sources.end(),
                                                [](const SourceVerdict& s) { return s.rejected > kUnused; });
}

// Where the first rest ends.
double departure(const Log& log, double start) {
  return !log.rest.empty() && log.rest.front().contains(start + 1) ? log.rest.front().end : start;
}

// The log until `end`: hours are not copied to filter minutes.
Log first_part(const Log& log, double end) {
  const auto cut = [end](const auto& items) {
    return std::decay_t<decltype(items)>(items.begin(), first_at_or_after(items, end));
  };
  Log part;
  part.world = log.world;
  part.imu = cut(log.imu);
  part.magnetic = cut(log.magnetic);
  part.rest = log.rest;
  for (const auto& fixes : log.gnss) part.gnss.push_back(cut(fixes));
  for (const auto& fixes : log.attitude) part.attitude.push_back(cut(fixes));
  return part;
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

}  // namespace

Verdict diagnose(const Log& log, const FilterOptions& options, const InitialHeading& heading, const FoundStart& found,
                 const Solution& filtered, const Solution* smoothed, const std::function<void(double)>& progress,
                 const std::vector<double>& residuals) {
  Verdict verdict = judge(log, options, filtered, smoothed, residuals);
  if (!suspicious(verdict) || filtered.empty()) return verdict;
  constexpr double kBeyond = 2;  // s: fixes that come late, and the neighbour of the last step
  const double departs = departure(log, found.start.time), end = departs + kLongest;
  const Told told{first_part(log, end + kBeyond), options, tried_from(log, options, found.start, departs)};

  const Evidence base = filter_again(told.log, told.options, told.start, end);
  std::vector<Cause> causes = searched_causes(told);
  const auto add = [&](std::vector<Cause> more) { std::move(more.begin(), more.end(), std::back_inserter(causes)); };
  add(constant_causes(told, heading));
  if (far_off(verdict)) add(axes_causes(told, heading));
  std::vector<Granted> likelier;
  for (std::size_t i = 0; i < causes.size(); ++i) {
    if (progress) progress(static_cast<double>(i) / static_cast<double>(causes.size()));
    Granted granted = causes[i](told, base, end);
    if (granted.gain > kLikelier) likelier.push_back(std::move(granted));
  }
  std::stable_sort(likelier.begin(), likelier.end(),
                   [](const Granted& a, const Granted& b) { return a.gain > b.gain; });
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
