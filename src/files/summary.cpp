#include "piste/files/summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "io/json.h"
#include "io/quantity.h"
#include "piste/consistency/warnings.h"
#include "piste/math/units.h"

namespace piste {
namespace {

std::string list(const Eigen::Ref<const Eigen::VectorXd>& values, int size) { return json::numbers(values.head(size)); }

std::string entry(const Quantity& q, const Eigen::Ref<const Eigen::VectorXd>& value,
                  const Eigen::Ref<const Eigen::VectorXd>& sigma) {
  return fmt::format(R"({{"unit": "{}", "value": {}, "sigma": {}}})", info(q.block).unit, list(value, q.size()),
                     list(sigma, q.size()));
}

std::string mean_entry(const Quantity& q, const RowMeans& means) {
  const bool gyro = q.block == Block::kGyroBias;
  const double factor = info(q.block).factor;
  return entry(q, factor * means.total_bias(gyro), factor * means.total_bias_sigma(gyro));
}

// Root mean square of the angles' sigmas, and the correlation time of their errors.
std::string attitude_error(double tau, const RowMeans& means) {
  return fmt::format(R"({{"correlation_time_s": {}, "sigma_deg": {}}})", tau > 0 ? fmt::format("{:.1f}", tau) : "null",
                     list(kDegreesPerRadian * means.euler_sigma(), 3));
}

// Number of measurements by outcome. "rejected" counts all that were not used.
struct Counts {
  std::array<std::size_t, kOutcomes.size()> of{};
  void add(Outcome outcome) { ++of[static_cast<std::size_t>(outcome)]; }
  std::size_t operator[](Outcome outcome) const { return of[static_cast<std::size_t>(outcome)]; }
  std::string text() const {
    std::size_t used = 0, rejected = 0;
    for (const Outcome outcome : kOutcomes) (was_used(outcome) ? used : rejected) += (*this)[outcome];
    return fmt::format(R"("used": {}, "rejected": {}, "readmitted": {}, "disputed": {}, "repeated": {})", used,
                       rejected, (*this)[Outcome::kReadmitted], (*this)[Outcome::kDisputed],
                       (*this)[Outcome::kRepeated]);
  }
};

// Fixes of the sensors "KIND[i]". A fix is rejected if any part of it is.
Counts count_fixes(const Solution& solution, std::string_view kind) {
  // By the time of the fix in the source: its parts may apply at other times.
  std::map<std::pair<std::string, long long>, Outcome> fixes;
  const auto worse = [](Outcome a, Outcome b) {
    for (const Outcome o : {Outcome::kRejected, Outcome::kDisputed, Outcome::kRepeated, Outcome::kReadmitted}) {
      if (a == o || b == o) return o;
    }
    return Outcome::kUsed;
  };
  for (const Innovation& v : solution.innovations) {
    const std::string& source = solution.sources[static_cast<std::size_t>(v.source)];
    if (!source.starts_with(kind)) continue;
    const long long microseconds = std::llround(1e6 * (v.time + v.late));
    const auto [place, fresh] = fixes.try_emplace({source.substr(0, source.find('.')), microseconds}, v.outcome);
    if (!fresh) place->second = worse(place->second, v.outcome);
  }
  Counts counts;
  for (const auto& [fix, outcome] : fixes) counts.add(outcome);
  return counts;
}

std::string source_counts(const Solution& solution) {
  std::vector<Counts> counts(solution.sources.size());
  for (const Innovation& v : solution.innovations) counts[static_cast<std::size_t>(v.source)].add(v.outcome);
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    lines.push_back(fmt::format("\n    \"{}\": {{{}}}", solution.sources[i], counts[i].text()));
  }
  return fmt::format("{{{}\n  }}", fmt::join(lines, ","));
}

std::string repaired(const RepairedRows& rows) {
  return fmt::format(R"({{"sorted": {}, "dropped": {}, "unreadable": {}}})", rows.sorted, rows.dropped,
                     rows.unreadable);
}

// The fixes of an optional sensor; nothing without this sensor. `of_file`: repairs of its file.
std::string sensor_entry(std::string_view name, const Solution& solution, std::size_t inside, std::size_t outside,
                         const RepairedRows* of_file = nullptr) {
  if (inside + outside == 0) return {};
  return fmt::format("  \"{}\": {{{}, \"outside\": {}{}}},\n", name, count_fixes(solution, name).text(), outside,
                     of_file != nullptr ? ", \"repaired\": " + repaired(*of_file) : "");
}

std::size_t sum(const std::vector<std::size_t>& counts) {
  std::size_t total = 0;
  for (const std::size_t n : counts) total += n;
  return total;
}

RepairedRows sum(const std::vector<RepairedRows>& sources) {
  RepairedRows total;
  for (const RepairedRows& r : sources) total += r;
  return total;
}

constexpr std::size_t kJumps = 5;  // that are listed

std::string verdict_entry(const Verdict& verdict) {
  constexpr int kDigits = 4;
  std::vector<std::string> sources, jumps;
  for (const SourceVerdict& s : verdict.sources) {
    const auto n = [](double value) { return json::number(value, kDigits); };
    std::string known;
    if (!std::isnan(s.whiteness)) known += fmt::format("\"whiteness\": {}, ", n(s.whiteness));
    if (!std::isnan(s.smoothed)) known += fmt::format("\"smoothed_residual\": {}, ", n(s.smoothed));
    sources.push_back(fmt::format("\n      {}: {{\"nis\": {}, \"rejected\": {}, {}\"fixes\": {}, \"consistent\": {}}}",
                                  json::string(s.name), n(s.nis), n(s.rejected), known, s.fixes, s.holds));
  }
  for (const PriorJump& jump : verdict.jumps) {
    if (jumps.size() == kJumps) break;
    jumps.push_back(fmt::format("{}: {}", json::string(jump.name), json::number(jump.sigmas, kDigits)));
  }
  return fmt::format(
      "{{\n    \"consistent\": {}, \"factor\": {},\n    \"sources\": {{{}\n    }},\n    \"jumps\": {{{}}},\n    "
      "\"findings\": {}\n  }}",
      verdict.consistent, json::number(verdict.factor, kDigits), fmt::join(sources, ","), fmt::join(jumps, ", "),
      json::strings(verdict.findings));
}

// The noise that an adapting filter estimated, as factors of the stated sigmas; nothing if it did not adapt.
std::string adapted_entry(const AdaptedNoise& adapted) {
  if (adapted.names.empty()) return {};
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < adapted.names.size(); ++k) {
    const AdaptedNoise::Range range = adapted.range(k);
    lines.push_back(fmt::format("\n    {}: {{\"mean\": {:.4g}, \"least\": {:.4g}, \"most\": {:.4g}, \"last\": {:.4g}}}",
                                json::string(adapted.names[k]), range.mean, range.least, range.most, range.last));
  }
  return fmt::format("  \"adapted\": {{{}\n  }},\n", fmt::join(lines, ","));
}

// What was left out of each of several IMUs; nothing for a single IMU.
std::string imus_entry(const std::vector<ImuReport>& imus) {
  if (imus.empty()) return {};
  std::vector<std::string> lines;
  for (const ImuReport& unit : imus) {
    std::vector<std::string> absences;
    for (const ImuAbsence& a : unit.absences) {
      absences.push_back(fmt::format(R"({{"fault": "{}", "triad": "{}", "start": {:.3f}, "end": {:.3f}}})",
                                     name_of(a.fault), a.gyro ? "gyro" : "accel", a.time.start, a.time.end));
    }
    lines.push_back(fmt::format("\n    {{\"name\": {}, \"lever_arm_m\": {}, \"left_out\": {}, \"absences\": [{}]}}",
                                json::string(unit.name), list(unit.place, 3), unit.left_out,
                                fmt::join(absences, ", ")));
  }
  return fmt::format("  \"imus\": [{}\n  ],\n", fmt::join(lines, ","));
}

// The result of the batch solver; nothing without a batch.
std::string batch_entry(const std::optional<BatchSummary>& batch) {
  if (!batch) return {};
  return fmt::format(
      "  \"batch\": {{\"converged\": {}, \"nodes\": {}, \"fixes\": {}, \"left_out\": {}, \"taken_back\": {}, "
      "\"rounds\": {}, \"iterations\": {}, \"cost\": {:.6g}}},\n",
      batch->converged, batch->nodes, batch->fixes, batch->left_out, batch->taken_back, batch->rounds,
      batch->iterations, batch->cost);
}

}  // namespace

void RowMeans::add(const Solution& rows) {
  // Positions of the values in a row. A block that is not estimated keeps its value.
  std::array<std::vector<std::size_t>, 2> values;
  std::array<std::size_t, 2> sigmas{};
  std::array<Vector3d, 2> kept{rows.fixed.gyro_bias + rows.fixed.gyro_drift,
                               rows.fixed.accel_bias + rows.fixed.accel_drift};
  for (const StoredColumn& column : rows.columns()) {
    if (column.name == "sigma_gyro_total_bias") sigmas[0] = column.offset;
    if (column.name == "sigma_accel_total_bias") sigmas[1] = column.offset;
    for (const Block block : {Block::kGyroBias, Block::kGyroDrift, Block::kAccelBias, Block::kAccelDrift}) {
      if (column.name != info(block).name) continue;
      const std::size_t triad = block == Block::kGyroBias || block == Block::kGyroDrift ? 0 : 1;
      values[triad].push_back(column.offset);
      kept[triad] -= additive(rows.fixed, block);
    }
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double* row = rows.rows().data() + i * rows.stride();
    for (std::size_t triad = 0; triad < 2; ++triad) {
      Vector3d value = kept[triad];
      for (const std::size_t offset : values[triad]) value += Vector3d(row + offset);
      total_[triad] += value;
      total_sigma_[triad] += Vector3d(row + sigmas[triad]);
    }
    euler_variance_ += rows.navigation_sigmas(i).euler.cwiseAbs2();
  }
  count_ += rows.size();
}

std::string summary_json(const Log& log, const Solution& filtered, const Solution* smoothed, const Verdict& verdict,
                         const RunTimes& times, const RowMeans* all, std::optional<int> week,
                         const std::vector<std::string>& warnings) {
  const Solution& best = smoothed != nullptr && !smoothed->empty() ? *smoothed : filtered;
  RowMeans means;
  if (all != nullptr) {
    means = *all;
  } else {
    means.add(best);
  }
  std::vector<std::string> estimates, totals, rests;
  for (const Quantity& q : quantities_of(best.layout())) {
    if (best.empty()) break;
    if (q.total) {
      totals.push_back(fmt::format("  \"{}\": {},\n", q.name, mean_entry(q, means)));
    } else {
      const auto [value, sigma] = shown(q, best.estimate(best.size() - 1), best.sigmas(best.size() - 1));
      estimates.push_back(fmt::format("\n    \"{}\": {}", q.name, entry(q, value, sigma)));
    }
  }
  for (const Interval& r : log.rest) rests.push_back(fmt::format("[{:.3f}, {:.3f}]", r.start, r.end));

  const LogCounts& c = log.counts;
  std::string text = "{\n";
  text += fmt::format(
      "  \"imu\": {{\"epochs\": {}, \"gaps\": {}, \"rejected\": {}, \"clipped\": {}, \"spikes\": {}, \"unpaired\": {}, "
      "\"stamp_jitter_s\": {:.6g}, \"repaired\": {}}},\n",
      all != nullptr ? all->count() : filtered.size(), c.imu_gaps, c.imu_rejected, c.imu_clipped, c.imu_spikes,
      c.imu_unpaired, c.stamp_jitter, repaired(c.imu_repaired));
  text += imus_entry(c.imus);
  text += fmt::format(
      "  \"gnss\": {{{}, \"withheld\": {}, \"outside\": {}, \"late\": {}, \"without_fix\": {}, "
      "\"not_used\": {}, \"repaired\": {}}},\n",
      count_fixes(filtered, "gnss[").text(), sum(c.gnss_withheld), sum(c.gnss_outside), filtered.gnss_late,
      sum(c.gnss_without_fix), sum(c.gnss_not_used), repaired(sum(c.gnss_repaired)));
  text += fmt::format("  \"attitude\": {{{}, \"outside\": {}, \"not_valid\": {}, \"repaired\": {}}},\n",
                      count_fixes(filtered, "attitude[").text(), sum(c.attitude_outside), sum(c.attitude_not_valid),
                      repaired(sum(c.attitude_repaired)));
  text += sensor_entry("odometer", filtered, log.speed.size(), c.speed_outside, &c.speed_repaired);
  text += sensor_entry("barometer", filtered, log.height.size(), c.height_outside, &c.height_repaired);
  text += sensor_entry("heading", filtered, log.heading.size(), c.heading_outside, &c.heading_repaired);
  text += sensor_entry("magnetometer", filtered, log.magnetic.size(), 0);
  text += fmt::format("  \"sources\": {},\n", source_counts(filtered));
  text += fmt::format("  \"verdict\": {},\n", verdict_entry(verdict));
  text += fmt::format("  \"warnings\": {},\n", json::strings(warnings));
  text += adapted_entry(filtered.adapted);
  text += batch_entry(best.batch);
  text += fmt::format("  \"rest_intervals\": [{}],\n", fmt::join(rests, ", "));
  text += fmt::format("  \"estimates\": {{{}\n  }},\n{}", fmt::join(estimates, ","), fmt::join(totals, ""));
  text += fmt::format("  \"attitude_error\": {},\n", attitude_error(best.attitude_correlation_time, means));
  if (week) text += fmt::format("  \"gps_week\": {},\n", *week);
  text += fmt::format("  \"cpu_s\": {:.3f},\n  \"wall_s\": {:.3f}\n}}\n", times.cpu, times.wall);
  return text;
}

}  // namespace piste
