#include "piste/diagnosis/diagnose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "core/recording.h"
#include "core/time_search.h"
#include "diagnosis/cause_support.h"
#include "diagnosis/causes.h"
#include "diagnosis/doubts.h"
#include "diagnosis/imu_motion.h"
#include "filter/feeder.h"
#include "piste/filter/initial_state.h"
#include "piste/filter/run.h"
#include "piste/tune/standing_heights.h"
#include "tune/held_delays.h"
#include "tune/thinned.h"
#include "tune/white_noise_range.h"

namespace piste {
namespace {

constexpr double kLongest = 150;  // s of motion that are filtered again
constexpr double kLikelier = 15;  // of the log-likelihood, for a cause to be one: by chance it gains a few
constexpr double kFurther = 0.2;  // of the best gain, for a further one to be named
constexpr std::size_t kNamed = 4;

// Where the first rest ends.
double departure(const Log& log, double start) {
  return !log.rest.empty() && log.rest.front().contains(start + 1) ? log.rest.front().end : start;
}

// The log until `end`: hours are not copied to filter minutes.
Log first_part(const Log& log, double end) {
  return with_each_series(log, [end](const auto& series) {
    return std::decay_t<decltype(series)>(series.begin(), first_at_or_after(series, end));
  });
}

// The state from which the causes are tested: the start, or the last minute of a long first rest, which each of them
// would filter again. It holds the navigation states alone, as every cause adds its own blocks.
Start tried_from(const Log& log, const FilterOptions& options, const Start& start, double departs) {
  constexpr double kRest = 60;  // s
  Start from = start;
  if (departs - start.time > 2 * kRest) {
    Filter filter(options, log.world, start);
    Feeder feeder(log, place_at(log, start.time, {.end = departs - kRest}), filter);
    for (; !feeder.done(); filter.clear_innovations()) feeder.step();
    from = {filter.time(), filter.estimate(), filter.covariance()};
  }
  from.covariance = from.covariance.topLeftCorner(9, 9).eval();
  return from;
}

// Holds the delays at the estimates of the run without a cause. A search by likelihoods needs a smooth function.
FilterInput with_held_delays(const FilterInput& input, const Evidence& base) {
  if (!estimates_delays(input.options) || base.rows == 0) return input;
  return {input.log, holding_delays(input.options), with_delays(input.start, base.last)};
}

// What is wrong, in words, where no cause is known for it.
std::string symptoms(const Verdict& verdict, const std::vector<GnssOptions>& receivers) {
  for (const SourceVerdict& s : verdict.sources) {
    if (s.holds) continue;
    bool slow_stated = false;
    for (std::size_t i = 0; i < receivers.size(); ++i) {
      if (s.name != fmt::format("gnss[{}].position", i) || !receivers[i].drift) continue;
      if (is_of_heights_alone(*receivers[i].drift)) {
        return fmt::format("heights of {} stand still, as they are rounded: how wrong they are does not show", s.name);
      }
      slow_stated = receivers[i].drift->of_stated;
    }
    if (s.nis < 1 && !slow_stated && may_be_slow(receivers, s.name)) {
      return fmt::format("slow error of {} (NIS {:.2g}): fixes differ by less than is stated, key `drift`", s.name,
                         s.nis);
    }
    return fmt::format("no single cause explains {} (NIS {:.2g}, correlation {:.2g}, {:.0f} % rejected)", s.name, s.nis,
                       s.whiteness, 100 * s.rejected);
  }
  const PriorJump& jump = verdict.jumps.front();
  return fmt::format("{} is {:.1f} sigmas from its prior", jump.name, jump.sigmas);
}

// The input with which causes are tested, and the end of the first minutes of motion, in which they are. `thin`: with
// sums of samples.
struct Trial {
  FilterInput input;
  double end;
};

Trial trial_of(const Log& log, const FilterOptions& options, const FoundStart& found, bool thin) {
  constexpr double kBeyond = 2;  // s: fixes that come late, and the neighbour of the last step
  const double departs = departure(log, found.start.time), end = departs + kLongest;
  Log part = first_part(log, end + kBeyond);
  return {{thin ? thinned(part) : std::move(part), options, tried_from(log, options, found.start, departs)}, end};
}

// A run before noise was made to fit its innovations: the receiver's sigmas without these factors, the IMU as noisy as
// it is at rest, and a clock that is not known, as wrong noise finds a wrong one.
FilterInput before_fitted_noise(FilterInput input, std::size_t receiver, const SigmaScales& scales) {
  scale_sigmas(input.log.gnss[receiver], {1 / scales.position, 1 / scales.height, 1 / scales.velocity});
  const WhiteNoise rest = white_noise_range(input.log).least;
  ImuSensor& sensor = input.options.sensor;
  if (rest.gyro > 0) sensor.gyro.noise = std::min(sensor.gyro.noise, rest.gyro);
  if (rest.accel > 0) sensor.accel.noise = std::min(sensor.accel.noise, rest.accel);
  if (input.options.estimates(Block::kGnssDelay)) input.options.priors.gnss_delay = kWideClock;
  return input;
}

}  // namespace

std::optional<std::string> find_sway(const Log& log, const FilterOptions& options, const FoundStart& found,
                                     const std::vector<SigmaScales>& scales) {
  // With all samples: a trembling antenna is as fast as they are.
  const auto [input, end] = trial_of(log, options, found, false);
  const FilterInput held = with_held_delays(input, filter_again(input.log, input.options, input.start, end));
  const Evidence base = filter_again(held.log, held.options, held.start, end);
  TestedCause best{};
  for (std::size_t i = 0; i < options.gnss.size(); ++i) {
    if (!may_sway(options, i)) continue;
    for (const FilterInput& from :
         {held, before_fitted_noise(input, i, i < scales.size() ? scales[i] : SigmaScales{})}) {
      if (TestedCause tested = swaying_antenna(i)(from, base, end); tested.gain > best.gain) best = std::move(tested);
    }
  }
  if (best.gain < kLikelier) return std::nullopt;
  for (const Cause& cause : searched_causes(held)) {
    if (cause(held, base, end).gain > best.gain) return std::nullopt;
  }
  return std::move(best.text);
}

Verdict diagnose(const Log& log, const FilterOptions& options, const InitialHeading& heading, const FoundStart& found,
                 const Solution& filtered, const Solution* smoothed, const std::function<void(double)>& progress,
                 const std::vector<double>& residuals) {
  return diagnosed(log, options, heading, found, filtered, smoothed, progress, residuals).verdict;
}

Diagnosis diagnosed(const Log& log, const FilterOptions& options, const InitialHeading& heading,
                    const FoundStart& found, const Solution& filtered, const Solution* smoothed,
                    const std::function<void(double)>& progress, const std::vector<double>& residuals) {
  Diagnosis diagnosis{judge(log, options, filtered, smoothed, residuals), {}};
  Verdict& verdict = diagnosis.verdict;
  if (filtered.empty()) return diagnosis;
  add_heading_jump(heading, filtered, smoothed, verdict);
  if (!doubtful(verdict, log, filtered)) return diagnosis;
  const Trial trial = trial_of(log, options, found, true);
  const FilterInput& input = trial.input;
  const double end = trial.end;
  const Evidence base = filter_again(input.log, input.options, input.start, end);
  const FilterInput held = with_held_delays(input, base);
  const Evidence held_base =
      estimates_delays(input.options) ? filter_again(held.log, held.options, held.start, end) : base;
  const std::vector<Cause> searched = searched_causes(held);
  std::vector<Cause> others = constant_causes(input, heading);
  const auto add = [&](std::vector<Cause> more) { std::ranges::move(more, std::back_inserter(others)); };
  add(clock_causes(input));
  add(heading_causes(input, heading));
  if (far_off(verdict)) add(motion_causes(input, heading));
  const std::size_t all = searched.size() + others.size();
  std::size_t tried = 0;
  std::vector<TestedCause>& likelier = diagnosis.causes;
  const auto attempt = [&](const std::vector<Cause>& causes, const FilterInput& from, const Evidence& without) {
    for (const Cause& cause : causes) {
      if (progress) progress(static_cast<double>(tried++) / static_cast<double>(all));
      TestedCause tested = cause(from, without, end);
      if (tested.gain > kLikelier) likelier.push_back(std::move(tested));
    }
  };
  attempt(searched, held, held_base);
  attempt(others, input, base);
  std::stable_sort(likelier.begin(), likelier.end(),
                   [](const TestedCause& a, const TestedCause& b) { return a.gain > b.gain; });
  if (auto biases = biases_left_out(verdict, options)) verdict.findings.push_back(std::move(*biases));
  for (std::string& line : imu_motion_lines(log, options.imus)) verdict.findings.push_back(std::move(line));
  if (auto magnetometer = iron_that_is_none(verdict)) verdict.findings.push_back(std::move(*magnetometer));
  for (const TestedCause& tested : likelier) {
    if (verdict.findings.size() == kNamed || tested.gain < kFurther * likelier.front().gain) break;
    verdict.findings.push_back(tested.text);
    verdict.slow_part = verdict.slow_part || tested.text.starts_with("slow error of gnss");
  }
  if (!verdict.findings.empty()) {
    verdict.consistent = false;
  } else if (!verdict.consistent) {
    verdict.findings.push_back(symptoms(verdict, options.gnss));
  }
  return diagnosis;
}

}  // namespace piste
