#include "piste/files/allan.h"

#include <fmt/format.h>

#include <cmath>

#include "io/json.h"
#include "piste/core/version.h"

namespace piste {
namespace {

bool has_curve(const AllanAxis& axis) { return !axis.curve.scales.empty(); }

std::string measured_json(const Measured& m) {
  return json::object({{"value", json::number(m.value, 6)}, {"interval", json::numbers(std::array{m.low, m.high}, 6)}});
}

std::string process_json(const FittedProcess& p, bool gyro) {
  const NoiseProcess& process = p.process;
  json::Members members{{"process", json::string(key_of(process.kind))},
                        {"size", measured_json({process.size, p.low, p.high})},
                        {"unit", json::string(unit_of(process.kind, gyro).name)},
                        {"in_unit", json::number(process.size / unit_of(process.kind, gyro).factor, 6)}};
  if (process.kind == ProcessKind::kGaussMarkov) {
    members.emplace_back("correlation_time_s", measured_json({process.correlation_time, p.low_time, p.high_time}));
  }
  members.emplace_back("determined", json::boolean(p.determined));
  return json::object(members);
}

std::string fit_json(const AllanAxis& axis) {
  const GmwmFit& fit = *axis.fit;
  std::vector<std::string> parts, unseen, tried;
  for (const FittedProcess& p : fit.parts) parts.push_back(process_json(p, axis.is_gyro));
  for (const UnseenProcess& u : fit.unseen) {
    unseen.push_back(json::object({{"process", json::string(key_of(u.kind))}, {"below", json::number(u.below, 4)}}));
  }
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < std::min(kShown, fit.tried.size()); ++i) {
    const TriedModel& m = fit.tried[i];
    tried.push_back(json::object({{"model", json::string(m.name)},
                                  {"objective", json::number(m.objective, 6)},
                                  {"penalty", json::number(m.penalty, 6)}}));
  }
  return json::object({{"model", json::string(fit.name())},
                       {"processes", json::array(parts)},
                       {"unseen", json::array(unseen)},
                       {"chi_squared", json::number(fit.objective, 6)},
                       {"freedom", json::number(fit.freedom)},
                       {"p_value", json::number(fit.p_value, 4)},
                       {"model_error", json::number(fit.model_error / 2, 4)},
                       {"tried", json::array(tried)}},
                      3);
}

std::string axis_json(const AllanAxis& axis) {
  json::Members members;
  if (!axis.fit) {
    members.emplace_back("not_fitted", json::string(axis.why_not.empty() ? "not recorded" : axis.why_not));
    return json::object(members);
  }
  members.emplace_back("noise", measured_json(axis.noise.noise));
  members.emplace_back("bias_instability", measured_json(axis.noise.instability));
  members.emplace_back("bias_instability_is",
                       json::string(axis.noise.flicker         ? "flicker noise of the model"
                                    : axis.noise.lowest_inside ? "the lowest deviation over 0.664"
                                                               : "an upper bound"));
  members.emplace_back("value_step", json::number(axis.step, 6));
  if (axis.imus.size() > 1) {
    std::vector<std::string> units;
    for (const AllanImu& u : axis.imus) {
      units.push_back(u.fit ? json::object({{"noise", measured_json(u.noise.noise)},
                                            {"bias_instability", measured_json(u.noise.instability)}})
                            : "null");
    }
    members.emplace_back("units", json::array(units));
    members.emplace_back("spread_of_noise", json::number(axis.spread, 4));
    members.emplace_back("spread_of_bias_instability", json::number(axis.spread_instability, 4));
  }
  members.emplace_back("fit", fit_json(axis));
  return json::object(members, 2);
}

std::string recording_json(const AllanRecording& r) {
  std::size_t outliers = 0;
  for (const std::size_t n : r.outliers) outliers += n;
  return json::object({{"file", json::string(r.source.log.file)},
                       {"rows", fmt::format("{}", r.rows)},
                       {"refused", fmt::format("{}", r.refused)},
                       {"interval_s", json::number(r.interval, 8)},
                       {"used_s", json::number(r.used(), 8)},
                       {"moving_s", json::number(r.moving, 6)},
                       {"gaps", fmt::format("{}", r.gaps)},
                       {"missing", fmt::format("{}", r.missing)},
                       {"filled", fmt::format("{}", r.filled)},
                       {"outliers", fmt::format("{}", outliers)}});
}

}  // namespace

std::string allan_csv(const AllanFindings& findings) {
  const AllanCurve* longest = nullptr;
  std::string text = "tau_s";
  for (const AllanAxis& axis : findings.axes) {
    if (!has_curve(axis)) continue;
    if (longest == nullptr || axis.curve.scales.size() > longest->scales.size()) longest = &axis.curve;
    text += fmt::format(",{0}_adev,{0}_lci,{0}_uci,{0}_model,{0}_wv", axis.name);
  }
  text += '\n';
  if (longest == nullptr) return text;
  for (std::size_t i = 0; i < longest->scales.size(); ++i) {
    text += fmt::format("{:.9g}", longest->tau(i));
    for (const AllanAxis& axis : findings.axes) {
      if (!has_curve(axis)) continue;
      if (i >= axis.curve.scales.size()) {
        text += ",,,,,";
        continue;
      }
      const AllanScale& scale = axis.curve.scales[i];
      const bool fitted = axis.fit && i < axis.fit->variance.size();
      text += fmt::format(",{:.8g}", std::sqrt(scale.variance));
      text += fitted ? fmt::format(",{:.8g},{:.8g},{:.8g}", std::sqrt(axis.fit->low[i]), std::sqrt(axis.fit->high[i]),
                                   std::sqrt(axis.fit->variance[i]))
                     : ",,,";
      text += fmt::format(",{:.8g}", scale.wavelet());
    }
    text += '\n';
  }
  return text;
}

std::string allan_json(const AllanFindings& findings) {
  json::Members axes;
  for (const AllanAxis& axis : findings.axes) axes.emplace_back(axis.name, axis_json(axis));
  std::vector<std::string> recordings;
  recordings.reserve(findings.recordings.size());
  for (const AllanRecording& r : findings.recordings) recordings.push_back(recording_json(r));
  return json::object({{"piste", json::string(version())},
                       {"name", json::string(findings.options.name)},
                       {"robust", json::boolean(findings.options.robust)},
                       {"probability", json::number(findings.options.fit.probability)},
                       {"penalty_of_each_number", json::number(kPenalty)},
                       {"recordings", json::array(recordings)},
                       {"axes", json::object(axes, 1)},
                       {"sensor_file", json::strings(findings.sensor_remarks)},
                       {"warnings", json::strings(findings.warnings)},
                       {"undetermined", json::strings(findings.undetermined)}},
                      0) +
         "\n";
}

}  // namespace piste
