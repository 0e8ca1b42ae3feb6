#include "piste/files/study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <utility>

#include "io/json.h"
#include "piste/math/units.h"
#include "piste/study/missing.h"
#include "piste/study/ranking.h"
#include "piste/study/study_tables.h"

namespace piste {
namespace {

constexpr std::array kQuantities{StudyQuantity::kBias, StudyQuantity::kScale};

std::string_view name_of(StudyQuantity quantity) { return quantity == StudyQuantity::kBias ? "bias" : "scale"; }
std::string_view unit_of(StudyQuantity quantity, int axis) {
  return quantity == StudyQuantity::kBias ? signal_info(axis).unit : "1";
}

struct NamedPhase {
  std::string_view name;
  std::optional<Interval> Phases::*phase;
};
constexpr std::array<NamedPhase, 3> kPhases{
    {{"before", &Phases::before}, {"run", &Phases::run}, {"after", &Phases::after}}};

// ---- CSV ----

std::string text(std::string_view value) {
  if (value.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(value);
  std::string out = "\"";
  for (const char c : value) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + '"';
}

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.9g}", value) : ""; }
std::string number(std::optional<double> value) { return value ? number(*value) : ""; }
std::string count(std::size_t value) { return fmt::format("{}", value); }

void add(std::string& csv, std::initializer_list<std::string> cells) {
  csv += fmt::format("{}\n", fmt::join(cells, ","));
}

std::string name_of(int axis) { return std::string(signal_info(axis).name); }
std::string unit_text(StudyQuantity quantity, int axis) { return std::string(unit_of(quantity, axis)); }

std::string bias_csv(const Study& study, Method method) {
  std::string out = "sensor,axis,unit,bias,std,standard_error,p_value,significant\n";
  for (const AcrossRow& r : table_of(study, method, StudyQuantity::kBias)) {
    const Across& v = r.value;
    add(out, {text(study.sensors[r.sensor]), name_of(r.axis), unit_text(StudyQuantity::kBias, r.axis), number(v.mean),
              number(v.std), number(v.standard_error), number(v.p_value), v.significant ? "1" : "0"});
  }
  return out;
}

std::string before_after_csv(const Study& study) {
  std::string out = "sensor,axis,unit,before,after,difference,p_value\n";
  for (const BeforeAfterRow& r : before_after(study)) {
    add(out, {text(study.sensors[r.sensor]), name_of(r.axis), unit_text(StudyQuantity::kBias, r.axis), number(r.before),
              number(r.after), number(r.difference.mean), number(r.difference.p_value)});
  }
  return out;
}

std::string joint_csv(const Study& study, StudyQuantity quantity) {
  std::string out = "sensor,axis,unit,value,std,standard_error,p_value,reverse_value\n";
  for (const AcrossRow& r : table_of(study, Method::kJoint, quantity)) {
    const Across& v = r.value;
    add(out, {text(study.sensors[r.sensor]), name_of(r.axis), unit_text(quantity, r.axis), number(v.mean),
              number(v.std), number(v.standard_error), number(v.p_value), number(r.reverse)});
  }
  return out;
}

std::string cross_axis_csv(const Study& study) {
  std::string out = "sensor,axis,element,value,std,standard_error,p_value\n";
  for (const CrossAxisRow& r : cross_axis(study)) {
    const Across& v = r.value;
    add(out, {text(study.sensors[r.sensor]), name_of(r.axis), std::string(r.element), number(v.mean), number(v.std),
              number(v.standard_error), number(v.p_value)});
  }
  return out;
}

std::string scale_scatter_csv(const Study& study) {
  std::string out = "sensor,axis,runs,std_alone,std_with_cross_axis,explained\n";
  for (const ScaleScatter& r : scale_scatter(study)) {
    add(out, {text(study.sensors[r.sensor]), name_of(r.axis), count(r.runs), number(r.alone), number(r.with_cross_axis),
              number(r.explained)});
  }
  return out;
}

std::string correlation_csv(const Study& study) {
  std::string out = "sensor,axis,correlation\n";
  for (const CorrelationRow& r : correlations(study)) {
    add(out, {text(study.sensors[r.sensor]), name_of(r.axis), number(r.correlation)});
  }
  return out;
}

std::string ranking_csv(const Study& study) {
  std::string out = "method,estimates,position_rmse_m,velocity_rmse_m_s,attitude_rmse_deg,outage_drift_m,remark\n";
  const Ranking found = ranking(study);
  const std::vector<std::string> said = remarks(study, found);
  for (std::size_t i = 0; i < found.rows.size(); ++i) {
    const RankingRow& r = found.rows[i];
    const MethodInfo& m = info(r.method);
    add(out, {text(m.name), text(m.estimates), number(r.position_rmse), number(r.velocity_rmse),
              number(kDegreesPerRadian * r.attitude_rmse), number(r.outage_drift), text(said[i])});
  }
  return out;
}

std::string imus_csv(const Study& study) {
  std::string out =
      "sensor,runs,position_rmse_m,velocity_rmse_m_s,attitude_rmse_deg,outage_drift_m,attitude_over_single,"
      "outage_drift_over_single\n";
  for (const ImuCompared& r : imus_compared(study)) {
    add(out, {text(r.name), count(r.runs), number(r.position_rmse), number(r.velocity_rmse),
              number(kDegreesPerRadian * r.attitude_rmse), number(r.outage_drift), number(r.attitude_over_single),
              number(r.drift_over_single)});
  }
  return out;
}

std::string estimates_csv(const Study& study) {
  std::string out = "run,sensor,axis,unit,method,quantity,value,sigma,standard_error,systematic,half_width_95,truth\n";
  for (const SensorRun& r : study.results) {
    for (const MethodEstimate& e : r.estimates) {
      for (int axis = 0; axis < kSignals; ++axis) {
        const AxisEstimate& at = e.axes[static_cast<std::size_t>(axis)];
        for (const StudyQuantity quantity : kQuantities) {
          const auto t = shown(at, quantity, axis);
          if (!t) continue;
          add(out, {text(study.runs[r.run].name), text(study.sensors[r.sensor]), name_of(axis),
                    unit_text(quantity, axis), text(info(e.method).name), std::string(name_of(quantity)),
                    number(t->value), number(t->sigma), number(t->standard_error), number(t->systematic),
                    number(t->half_width(1 - kSignificance)), number(shown_truth(at, quantity, axis))});
        }
      }
    }
  }
  return out;
}

std::string comparisons_csv(const Study& study) {
  std::string out = "sensor,axis,quantity,unit,method,against,runs,difference,std,standard_error,p_value,p_holm\n";
  for (const StudyQuantity quantity : kQuantities) {
    for (const Comparison& c : comparisons(study, quantity)) {
      const Across& d = c.difference;
      add(out, {text(study.sensors[c.sensor]), name_of(c.axis), std::string(name_of(quantity)),
                unit_text(quantity, c.axis), text(info(c.a).name), text(info(c.b).name), count(d.runs), number(d.mean),
                number(d.std), number(d.standard_error), number(d.p_value), number(d.p_holm)});
    }
  }
  return out;
}

std::string_view triad(const Coverage& c) { return c.gyro ? "gyro" : "accel"; }

std::string coverage_csv(const Study& study) {
  std::string out = "method,quantity,triad,inside,all,rate,worst\n";
  for (const Coverage& c : coverage(study)) {
    add(out, {text(info(c.method).name), std::string(name_of(c.quantity)), std::string(triad(c)), count(c.inside),
              count(c.all), number(c.rate()), number(c.worst)});
  }
  return out;
}

std::string timing_csv(const Study& study) {
  std::string out = "delay_ms,axis,forward,forward_standard_error,reverse,reverse_standard_error\n";
  for (const TimingRow& r : timing(study)) {
    for (int axis = 0; axis < kSignals; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      add(out, {number(1e3 * r.delay), name_of(axis), number(r.forward[at]), number(r.forward_error[at]),
                number(r.reverse[at]), number(r.reverse_error[at])});
    }
  }
  return out;
}

std::string phases_csv(const Study& study) {
  std::string out = "run,activity,phase,start_s,end_s\n";
  for (const StudyRun& r : study.runs) {
    for (const NamedPhase& p : kPhases) {
      const auto& phase = r.phases.*p.phase;
      if (!phase) continue;
      add(out, {text(r.name), text(r.activity), std::string(p.name), fmt::format("{:.3f}", phase->start),
                fmt::format("{:.3f}", phase->end)});
    }
  }
  return out;
}

// ---- summary.json ----

// An array with one line for each item, at the indentation of `depth`.
std::string lines(const std::vector<std::string>& items, int depth) {
  if (items.empty()) return "[]";
  const std::string indent(static_cast<std::size_t>(2 * depth), ' ');
  return fmt::format("[\n{}  {}\n{}]", indent, fmt::join(items, ",\n  " + indent), indent);
}

std::string failure_json(const std::string& failure) { return failure.empty() ? "null" : json::string(failure); }

json::Members sensor_members(std::string_view name, const SensorRun& r) {
  return {{"name", json::string(name)},
          {"failure", failure_json(r.failure)},
          {"warnings", json::strings(r.warnings)},
          {"clock_offset_s", json::number(r.clock_offset)},
          {"clock_drift_ppm", json::number(1e6 * r.clock_drift)},
          {"boresight_deg", json::numbers(kDegreesPerRadian * r.boresight)},
          {"sigma_boresight_deg", json::numbers(kDegreesPerRadian * r.sigma_boresight)},
          {"lever_arm_m", json::numbers(r.lever_arm)}};
}

// The fused IMU of a run: where the first IMU is, and which IMUs it fuses.
std::string as_one_json(const Study& study, std::size_t run) {
  const auto found = std::ranges::find(study.as_one, run, &SensorRun::run);
  if (found == study.as_one.end()) return "null";
  json::Members members = sensor_members(kAsOne, *found);
  members.emplace_back("imus", json::strings(found->imus));
  return json::object(members);
}

std::string run_json(const Study& study, std::size_t run) {
  const StudyRun& r = study.runs[run];
  json::Members phases;
  for (const NamedPhase& p : kPhases) {
    const auto& phase = r.phases.*p.phase;
    phases.emplace_back(p.name, phase ? json::numbers(std::array{phase->start, phase->end}, 12) : "null");
  }
  std::vector<std::string> sensors;
  for (const SensorRun& s : study.results) {
    if (s.run == run) sensors.push_back(json::object(sensor_members(study.sensors[s.sensor], s)));
  }
  return json::object({{"name", json::string(r.name)},
                       {"activity", json::string(r.activity)},
                       {"failure", failure_json(r.failure)},
                       {"warnings", json::strings(r.warnings)},
                       {"phases", json::object(phases)},
                       {"sigma_attitude_deg", json::numbers(kDegreesPerRadian * r.sigma_attitude)},
                       {"sigma_position_m", json::number(r.sigma_position)},
                       {"outages", count(r.outages)},
                       {"sensors", lines(sensors, 3)},
                       {"as_one", as_one_json(study, run)}},
                      2);
}

std::string row_json(const RankingRow& r, const std::string& remark) {
  return json::object({{"method", json::string(info(r.method).name)},
                       {"competes", json::boolean(info(r.method).competes)},
                       {"count", count(r.count)},
                       {"score", json::number(r.score)},
                       {"versus_winner", json::number(r.versus_winner)},
                       {"interval_95", json::numbers(std::array{r.low, r.high})},
                       {"p_holm", json::number(r.p_holm)},
                       {"remark", json::string(remark)}});
}

const RankingRow* row_of(const Ranking& ranking, Method method) {
  const auto found = std::ranges::find(ranking.rows, method, &RankingRow::method);
  return found == ranking.rows.end() ? nullptr : &*found;
}

std::string ranking_json(const Study& study) {
  const Ranking found = ranking(study);
  if (!found.winner) return "null";
  const std::vector<std::string> said = remarks(study, found);
  std::vector<std::string> rows;
  for (std::size_t i = 0; i < found.rows.size(); ++i) rows.push_back(row_json(found.rows[i], said[i]));
  const RankingRow *next = second(found), *nothing = row_of(found, Method::kNothing);
  std::vector<std::string> best;
  for (const RankingRow& row : leaders(found)) best.emplace_back(info(row.method).name);
  const auto ratio = [](const RankingRow* r) { return r ? json::number(1 / r->versus_winner) : "null"; };
  return json::object({{"winner", json::string(info(*found.winner).name)},
                       {"leaders", json::strings(best)},
                       {"second", next ? json::string(info(next->method).name) : "null"},
                       {"score_over_second", ratio(next)},
                       {"score_over_nothing", ratio(nothing)},
                       {"confidence", json::number(found.confidence)},
                       {"methods", lines(rows, 2)}},
                      1);
}

std::string imus_json(const Study& study) {
  std::vector<std::string> rows;
  for (const ImuCompared& r : imus_compared(study)) {
    rows.push_back(json::object({{"name", json::string(r.name)},
                                 {"runs", count(r.runs)},
                                 {"position_rmse_m", json::number(r.position_rmse)},
                                 {"velocity_rmse_m_s", json::number(r.velocity_rmse)},
                                 {"attitude_rmse_deg", json::number(kDegreesPerRadian * r.attitude_rmse)},
                                 {"outage_drift_m", json::number(r.outage_drift)},
                                 {"attitude_over_single", json::number(r.attitude_over_single)},
                                 {"outage_drift_over_single", json::number(r.drift_over_single)}}));
  }
  return lines(rows, 1);
}

std::string coverage_json(const Study& study) {
  std::vector<std::string> rows;
  for (const Coverage& c : coverage(study)) {
    rows.push_back(json::object({{"method", json::string(info(c.method).name)},
                                 {"quantity", json::string(name_of(c.quantity))},
                                 {"triad", json::string(triad(c))},
                                 {"inside", count(c.inside)},
                                 {"all", count(c.all)},
                                 {"rate", json::number(c.rate())},
                                 {"worst", json::number(c.worst)}}));
  }
  return lines(rows, 1);
}

}  // namespace

std::vector<StudyFile> study_csv(const Study& study) {
  std::vector<StudyFile> out{{"table_1.csv", bias_csv(study, Method::kRest)},
                             {"table_2.csv", before_after_csv(study)},
                             {"table_3.csv", joint_csv(study, StudyQuantity::kBias)},
                             {"table_4.csv", joint_csv(study, StudyQuantity::kScale)},
                             {"table_5.csv", correlation_csv(study)},
                             {"table_6.csv", bias_csv(study, Method::kBiasOnly)},
                             {"table_7.csv", ranking_csv(study)},
                             {"filter_bias.csv", bias_csv(study, Method::kMarkovSmoothed)},
                             {"cross_axis.csv", cross_axis_csv(study)},
                             {"scale_scatter.csv", scale_scatter_csv(study)},
                             {"estimates.csv", estimates_csv(study)},
                             {"comparisons.csv", comparisons_csv(study)},
                             {"coverage.csv", coverage_csv(study)},
                             {"timing.csv", timing_csv(study)},
                             {"phases.csv", phases_csv(study)}};
  if (study.as_one.empty()) return out;
  out.push_back({"imus.csv", imus_csv(study)});
  out.push_back({"as_one.csv", estimates_csv(of_all_as_one(study))});
  return out;
}

std::string study_json(const Study& study) {
  std::vector<std::string> runs, lacking;
  for (std::size_t run = 0; run < study.runs.size(); ++run) runs.push_back(run_json(study, run));
  for (const std::string& m : missing(study)) lacking.push_back(json::string(m));
  return json::object({{"name", json::string(study.name)},
                       {"low_pass_hz", json::number(study.low_pass)},
                       {"simulated", json::boolean(study.simulated)},
                       {"sensors", json::strings(study.sensors)},
                       {"missing", lines(lacking, 1)},
                       {"ranking", ranking_json(study)},
                       {"imus", imus_json(study)},
                       {"coverage", coverage_json(study)},
                       {"runs", lines(runs, 1)}},
                      0) +
         "\n";
}

}  // namespace piste
