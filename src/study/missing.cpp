#include "piste/study/missing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "piste/study/ranking.h"

namespace piste {
namespace {

std::string name_of(const Study& study, const SensorRun& r) {
  return fmt::format("{} in {}", study.sensors[r.sensor], study.runs[r.run].name);
}

// Reports where a method has no estimate although the result is otherwise complete: for a whole run of an IMU, or for
// some of its axes.
std::vector<std::string> silent(const Study& study, Method method) {
  std::vector<std::string> out;
  for (const SensorRun& r : study.results) {
    if (!r.failure.empty()) continue;
    std::vector<std::string_view> axes;
    for (int axis = 0; axis < kSignals; ++axis) {
      if (!r.estimate(method, axis)) axes.push_back(signal_info(axis).name);
    }
    if (axes.empty()) continue;
    const bool whole = axes.size() == kSignals;
    out.push_back(whole ? name_of(study, r) : fmt::format("{} of {}", fmt::join(axes, " "), name_of(study, r)));
  }
  return out;
}

bool answers(const Study& study, Method method) {
  return std::ranges::any_of(study.results, [method](const SensorRun& r) {
    return std::ranges::any_of(r.estimates, [method](const MethodEstimate& e) { return e.method == method; });
  });
}

void add_failures(const Study& study, std::vector<std::string>& out) {
  for (std::size_t run = 0; run < study.runs.size(); ++run) {
    const StudyRun& r = study.runs[run];
    if (!r.failure.empty()) {
      out.push_back(fmt::format("{} failed: {}", r.name, r.failure));
      continue;
    }
    for (std::size_t sensor = 0; sensor < study.sensors.size(); ++sensor) {
      const auto found =
          std::ranges::find_if(study.results, [&](const SensorRun& s) { return s.run == run && s.sensor == sensor; });
      if (found == study.results.end()) {
        out.push_back(fmt::format("{} has no {}.", r.name, study.sensors[sensor]));
      } else if (!found->failure.empty()) {
        out.push_back(fmt::format("{} failed: {}", name_of(study, *found), found->failure));
      }
    }
  }
}

// Of the fused IMU.
void add_apart(const Study& study, std::vector<std::string>& out) {
  for (const SensorRun& r : study.as_one) {
    if (r.failure.empty()) continue;
    out.push_back(fmt::format("{} failed in {}: {}", kAsOne, study.runs[r.run].name, r.failure));
  }
}

void add_silence(const Study& study, std::vector<std::string>& out) {
  for (const MethodInfo& m : kMethods) {
    if (m.estimates.empty() || m.method == Method::kTruth) continue;
    if (!answers(study, m.method)) {
      out.push_back(fmt::format("No run has an answer by {}.", m.name));
    } else if (const auto where = silent(study, m.method); !where.empty()) {
      out.push_back(fmt::format("There is no answer by {} for {}.", m.name, fmt::join(where, ", ")));
    }
  }
}

void add_unranked(const Study& study, std::vector<std::string>& out) {
  const auto at = scored(study);
  if (at.empty()) {
    out.emplace_back("No replay was scored, so that the methods are not ranked.");
    return;
  }
  for (const SensorRun& r : study.results) {
    if (!r.scores.empty() && !log_score(r, Method::kNothing)) {
      out.push_back(
          fmt::format("{} is not in the ranking: its replay that knows nothing has no score.", name_of(study, r)));
    }
  }
  for (const MethodInfo& m : kMethods) {
    std::vector<std::string> without;
    for (const SensorRun* r : at) {
      if (!log_score(*r, m.method)) without.push_back(name_of(study, *r));
    }
    if (without.empty() || without.size() == at.size()) continue;
    out.push_back(fmt::format("{} is not ranked: it has no score for {}.", m.name, fmt::join(without, ", ")));
  }
  for (const StudyRun& r : study.runs) {
    if (r.failure.empty() && r.outages == 0) {
      out.push_back(fmt::format("{} has no outage: it is scored without the drift in one.", r.name));
    }
  }
}

}  // namespace

std::vector<std::string> missing(const Study& study) {
  std::vector<std::string> out;
  add_failures(study, out);
  add_apart(study, out);
  if (study.runs.size() == 1) out.emplace_back("One run: nothing can be said of the spread between runs.");
  add_silence(study, out);
  add_unranked(study, out);
  return out;
}

}  // namespace piste
