#include "piste/report/allan_text.h"

#include <fmt/format.h>

#include "math/words.h"

namespace piste {
namespace {

// The quantization steps, and the noise of rounding.
std::string steps(const AllanFindings& f) {
  std::string text;
  for (const AllanAxis& axis : f.axes) {
    if (!axis.fit || !(axis.step > 0)) continue;
    const ProcessUnit value = unit_of(ProcessKind::kBiasInstability, axis.is_gyro),
                      noise = unit_of(ProcessKind::kWhite, axis.is_gyro);
    text += fmt::format("{:8} comes in steps of {:.4g} {}, of which rounding makes {:.3g} {} of the white noise\n",
                        axis.name, axis.step / value.factor, value.name, axis.rounding / noise.factor, noise.name);
  }
  return text.empty() ? text : '\n' + text;
}

std::string noise_in_motion(const AllanFindings& f) {
  if (!f.options.tuned) return {};
  std::string text;
  const auto add = [&](const char* name, const std::optional<Measured>& motion, bool gyro) {
    if (!motion) return;
    double squares = 0;
    int count = 0;
    for (const AllanAxis& axis : f.axes) {
      if (axis.is_gyro != gyro || !axis.fit) continue;
      squares += axis.noise.noise.value * axis.noise.noise.value;
      ++count;
    }
    if (count == 0) return;
    const ProcessUnit unit = unit_of(ProcessKind::kWhite, gyro);
    const double rest = std::sqrt(squares / count);
    text += fmt::format("{} noise: {:.3g} {} at rest, {} in motion ({:.1f} times; {})\n", name, rest / unit.factor,
                        unit.name, interval_text(*motion, unit.factor, unit.name), motion->value / rest,
                        f.options.tuned->file);
  };
  add("gyro", f.options.tuned->gyro, true);
  add("accel", f.options.tuned->accel, false);
  return text;
}

}  // namespace

std::string interval_text(const Measured& m, double factor, const std::string& unit) {
  return fmt::format("{:.3g} ({:.3g} to {:.3g}) {}", m.value / factor, m.low / factor, m.high / factor, unit);
}

std::string allan_text(const AllanFindings& f) {
  std::string text;
  for (const AllanRecording& r : f.recordings) {
    text += fmt::format("{}: {} at rest, {:.4g} Hz ({})\n", r.source.log.file, time_text(r.used()), 1 / r.interval,
                        r.source.why);
  }
  text +=
      fmt::format("\n{:8} {:42} {:38} {}\n", "axis", "white noise that a filter meets", "bias instability", "model");
  for (const AllanAxis& axis : f.axes) {
    if (!axis.fit) {
      text += fmt::format("{:8} not fitted: {}\n", axis.name, axis.why_not.empty() ? "not recorded" : axis.why_not);
      continue;
    }
    const ProcessUnit noise = unit_of(ProcessKind::kWhite, axis.is_gyro),
                      value = unit_of(ProcessKind::kBiasInstability, axis.is_gyro);
    text += fmt::format("{:8} {:42} {:38} {}\n", axis.name, interval_text(axis.noise.noise, noise.factor, noise.name),
                        interval_text(axis.noise.instability, value.factor, value.name), axis.fit->name());
  }
  text += steps(f);
  const std::string motion = noise_in_motion(f);
  if (!motion.empty()) text += '\n' + motion;
  const auto list = [&](const char* heading, const std::vector<std::string>& items) {
    if (items.empty()) return;
    text += fmt::format("\n{}\n", heading);
    for (const std::string& item : items) text += fmt::format("  {}\n", item);
  };
  list("warnings", f.warnings);
  list("what recordings of this length do not determine", f.undetermined);
  list("sensor.yaml", f.sensor_remarks);
  return text;
}

}  // namespace piste
