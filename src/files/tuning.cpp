#include "piste/files/tuning.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "configuration/replay_keys.h"
#include "io/json.h"
#include "io/path_from.h"
#include "io/triad_units.h"
#include "math/words.h"
#include "piste/configuration/sensor_file.h"
#include "piste/core/version.h"

namespace piste {
namespace {

namespace fs = std::filesystem;

constexpr int kDigits = 3;
constexpr double kAsStated = 1e-6;  // relative: a factor this near 1 is not written
constexpr double kVibrates = 1.5;   // times the noise at rest

/// A section of a configuration, and the folder from which its paths start.
struct Section {
  YAML::Node node;
  fs::path folder;
};

// The section `key` of a configuration, or else of its base.
Section section(const fs::path& file, const std::string& key) {
  const YAML::Node root = YAML::LoadFile(file.string());
  if (root[key] || !root["base"]) return {root[key], file.parent_path()};
  return section(file.parent_path() / root["base"].as<std::string>(), key);
}

// The sources of the section for `replay.yaml`: `change(node, i)` states the noise of the i-th. A single map is
// completed from the base; a list is not.
template <class Change>
void add_sources(YAML::Node& out, const ReplayConfig& config, const fs::path& folder, const std::string& key,
                 const Change& change) {
  Section old = section(config.file, key);
  if (!old.node) return;
  if (old.node.IsMap()) {
    YAML::Node node(YAML::NodeType::Map);  // an untyped node would not be shared with `change`
    change(node, 0);
    if (node.size() > 0) out[key] = node;
    return;
  }
  std::size_t i = 0;
  for (YAML::Node node : old.node) {
    node["file"] = path_from(folder, old.folder / node["file"].as<std::string>());
    change(node, i++);
  }
  out[key] = old.node;
}

std::string replay_yaml(const ReplayConfig& config, const Tuning& tuning, const fs::path& folder) {
  YAML::Node out;
  out["base"] = path_from(folder, config.file);
  out["imu"]["sensor"] = "sensor.yaml";
  add_sources(out, config, folder, "gnss", [&](YAML::Node node, std::size_t i) {
    const ReceiverNoise& noise = tuning.noise.gnss[i];
    const LogFile& log = config.gnss[i];
    const SigmaScales by = noise.scales();
    // The white part is the difference of the squares of `sigma_scale` and of the drift, and sensitive to a third
    // digit.
    const auto scale = [&node](const char* key, double stated, double factor) {
      if (std::abs(factor - 1) > kAsStated) node[key] = fmt::format("{:.5g}", stated * factor);
    };
    scale("sigma_scale", log.sigma_scales.position, by.position);
    scale("sigma_height_scale", log.sigma_scales.height, by.height);
    scale("sigma_velocity_scale", log.sigma_scales.velocity, by.velocity);
    if (const auto drift = noise.process()) {
      YAML::Node slow(YAML::NodeType::Map);  // and no key of the previous drift
      slow[drift->of_stated ? "share" : "sigma"] = size_text(*drift);
      node["drift"] = slow;
      node["drift"]["correlation_time"] = fmt::format("{:.3g} s", drift->correlation_time);
      if (std::isfinite(drift->most_white)) node["drift"]["most_white"] = fmt::format("{:.3g} m", drift->most_white);
    }
  });
  add_sources(out, config, folder, "attitude", [&](YAML::Node node, std::size_t i) {
    if (tuning.noise.attitude_time[i] > 0)
      node["correlation_time"] = fmt::format("{:.3g} s", tuning.noise.attitude_time[i]);
  });
  YAML::Emitter text;
  text << out;
  return fmt::format("# Made by tune: the maximum-likelihood noise in motion. All else is as in the base.\n{}\n",
                     text.c_str());
}

double shown(double noise, const TriadUnits& units) { return noise / unit_factor(units.noise_unit, units.noise); }

std::string at_rest_json(const Tuning& tuning) {
  const auto triad = [](double rest, double motion, const TriadUnits& units) {
    return json::object({{"unit", json::string(units.noise_unit)},
                         {"noise", json::number(shown(rest, units))},
                         {"motion_over_rest", json::number(motion / rest, 4)}});
  };
  return json::object({{"gyro", triad(tuning.at_rest.gyro, tuning.noise.sensor.gyro.noise, kGyroUnits)},
                       {"accel", triad(tuning.at_rest.accel, tuning.noise.sensor.accel.noise, kAccelUnits)}},
                      1);
}

}  // namespace

std::string tune_json(const Tuning& tuning) {
  json::Members noises, nis;
  for (const TunedNoise& n : tuning.numbers) {
    noises.emplace_back(n.name, json::object({{"unit", json::string(n.unit)},
                                              {"value", json::number(n.value, 6)},
                                              {"interval", json::numbers(std::array{n.low, n.high}, 6)},
                                              {"start", json::number(n.start, 6)},
                                              {"determined", json::boolean(n.determined)}}));
  }
  for (const SourceNis& s : tuning.nis) {
    nis.emplace_back(s.source, json::object({{"mean", json::number(s.mean, 4)},
                                             {"error", json::number(s.error, 2)},
                                             {"innovations", fmt::format("{}", s.innovations)}}));
  }
  const auto gain = [](const std::optional<double>& gained, double penalty) {
    if (!gained) return std::string("null");
    return json::object({{"gain", json::number(*gained, 6)},
                         {"penalty", json::number(penalty, 6)},
                         {"kept", json::boolean(*gained > penalty)}});
  };
  return json::object({{"piste", json::string(version())},
                       {"noises", json::object(noises, 1)},
                       {"at_rest", at_rest_json(tuning)},
                       {"log_likelihood", json::object({{"start", json::number(tuning.likelihood_at_start)},
                                                        {"found", json::number(tuning.likelihood)},
                                                        {"rows", fmt::format("{}", tuning.rows)},
                                                        {"filter_runs", fmt::format("{}", tuning.filter_runs)}})},
                       {"coloured_gnss_error", gain(tuning.drift_gain, tuning.drift_penalty)},
                       {"kinds_of_gnss_fixes", gain(tuning.kinds_gain, tuning.kinds_penalty)},
                       {"held_out_s", json::number(tuning.held_out)},
                       {"nis", json::object(nis, 1)}},
                      0) +
         '\n';
}

std::string tuning_text(const Tuning& tuning) {
  std::string text;
  for (const TunedNoise& n : tuning.numbers) {
    text +=
        fmt::format("{:<29} {:>9} {:<17} 95 % {} to {}, before {}{}\n", n.name, plain(n.value), n.unit, plain(n.low),
                    plain(n.high), plain(n.start), n.determined ? "" : "; not determined by the data");
  }
  const auto compare = [&](const char* name, double rest, double motion, const TriadUnits& units) {
    if (!std::isfinite(rest)) return;
    const char* const why = motion > kVibrates * rest ? " as much: vibration" : " as much";
    text += fmt::format("{} at rest: {} {}; in motion {} times{}\n", name, plain(shown(rest, units)), units.noise_unit,
                        plain(motion / rest, 2), why);
  };
  compare("gyroscopes", tuning.at_rest.gyro, tuning.noise.sensor.gyro.noise, kGyroUnits);
  compare("accelerometers", tuning.at_rest.accel, tuning.noise.sensor.accel.noise, kAccelUnits);
  const std::string_view where = tuning.held_out > 0 ? ", held out" : "";
  for (const SourceNis& s : tuning.nis)
    text += fmt::format("mean NIS of {}{}: {:.2f} ± {:.2f}\n", s.source, where, s.mean, s.error);
  return text;
}

std::string tuned_sensor(const ReplayConfig& config, const Tuning& tuning) {
  // The filter has the sensor along the body's axes; the file has it along the sensor's own axes.
  const ImuSensor sensor = turned(tuning.noise.sensor, config.imu.conditioning.R_bs.transpose());
  return sensor_text(rounded(sensor, kDigits));
}

void write_tuning(OutputFolder& output, const ReplayConfig& config, const Tuning& tuning) {
  output.write("sensor.yaml", tuned_sensor(config, tuning));
  output.write("replay.yaml", replay_yaml(config, tuning, output.folder()));
  output.write("tune.json", tune_json(tuning));
}

}  // namespace piste
