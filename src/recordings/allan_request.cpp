#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "configuration/column_keys.h"
#include "io/text_reader.h"
#include "io/triad_units.h"
#include "piste/configuration/imu_source.h"
#include "piste/configuration/sensor_file.h"
#include "piste/core/error.h"
#include "piste/io/columns.h"
#include "piste/recordings/allan.h"
#include "piste/search/inspect.h"

namespace piste {
namespace {

namespace fs = std::filesystem;

ProcessKind kind_of(const Config& config, const std::string& word) {
  std::vector<std::string> keys;
  for (const ProcessKind kind : kProcessKinds) {
    keys.push_back(key_of(kind));
    if (keys.back() == word) return kind;
  }
  config.fail("model", fmt::format("`{}` is none of: {}", word, fmt::join(keys, ", ")));
}

// One file as a source, also if it has gyroscopes or accelerometers alone. Throws DataError.
AllanSource guessed_alone(const std::string& file) {
  const MappedFile mapped(file);
  LogGuess guess = guess_log(file, mapped.text());
  if (guess.kind != LogKind::kImu) {
    throw DataError(file + ":1", fmt::format("is a log of {} ({}); allan needs that of an IMU at rest",
                                             name_of(guess.kind) == "GNSS" ? "a receiver" : "attitudes", guess.why));
  }
  if (guess.part == LogGuess::Part::kNone) throw DataError(file + ":1", "is no log of an IMU: " + guess.aside);
  AllanSource source;
  source.log = {.file = file, .format = guess.format, .columns = guess.columns};
  source.why = guess.why;
  source.doubts = guess.doubts;
  return source;
}

// Among several files, gyroscopes and accelerometers of one phone are joined.
std::vector<AllanSource> guessed_sources(const std::vector<std::string>& files) {
  for (std::size_t i = 1; i < files.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (is_same_log(files[i], files[k])) {
        throw ConfigError(files[i],
                          fmt::format("is `{}`, or a copy of it, and would count twice; name each log once", files[k]));
      }
    }
  }
  std::vector<Suspicion> found;
  const std::vector<InspectedLog> logs = recognise(files, found);
  std::vector<AllanSource> sources;
  for (const InspectedLog& l : logs) {
    if (!l.guess || l.log.accel_file.empty()) {
      sources.push_back(guessed_alone(l.log.file));
    } else {
      sources.push_back({l.log, l.guess->why, l.guess->doubts});
    }
  }
  return sources;
}

void require_file(const std::string& file) {
  if (!fs::exists(file)) throw ConfigError(file, "there is no such file");
}

AllanSource read_source(const Config& entry) {
  if (!entry.has("format")) {
    AllanSource source = guessed_alone(entry.existing_file("file").string());
    source.log.repair = entry.flag("repair", false);
    return source;
  }
  AllanSource source;
  source.log = read_log_file(entry, {LogFormat::kCsv, LogFormat::kKfGins, LogFormat::kXsensAscii, LogFormat::kImr,
                                     LogFormat::kNovatel, LogFormat::kColumns});
  source.why = "the configuration says so";
  if (source.log.format == LogFormat::kColumns) {
    source.log.columns = read_column_map(entry, imu_quantities());
    if (entry.has("accel_file")) source.log.accel_file = entry.existing_file("accel_file").string();
  }
  return source;
}

}  // namespace

AllanRequest read_allan_config(const Config& config) {
  AllanRequest request;
  AllanOptions& options = request.options;
  for (const Config& entry : config.maps("recordings")) {
    AllanSource source = read_source(entry);
    for (const AllanSource& other : request.sources) refuse_repeated(entry, source.log, other.log);
    request.sources.push_back(std::move(source));
  }
  if (request.sources.empty())
    config.fail("recordings", "is missing: a list of logs of one type of IMU at rest, such as `- file: unit_1.csv`");
  options.name = config.text("name", fs::path(request.sources.front().log.file).stem().string());
  if (config.has("sensor")) {
    options.base_file = config.existing_file("sensor").string();
    options.base = read_sensor(options.base_file);
  }
  if (config.has("tuned")) options.tuned = read_tuned(config.existing_file("tuned").string());
  options.robust = config.flag("robust", false);
  options.at_rest = config.flag("at_rest", false);
  constexpr long kMostProcesses = 3;
  const long processes = config.integer("gauss_markov", kMostProcesses);
  if (processes < 0 || processes > kMostProcesses) config.fail("gauss_markov", "must be 0 to 3 processes");
  options.fit.gauss_markov = static_cast<int>(processes);
  options.fit.probability = config.number("probability", options.fit.probability);
  if (!(options.fit.probability > 0 && options.fit.probability < 1))
    config.fail("probability", "must be between 0 and 1, such as 0.95");
  options.shortest_rest = config.quantity("shortest_rest", dimension::kTime, options.shortest_rest);
  options.longest_disturbance = config.quantity("longest_disturbance", dimension::kTime, options.longest_disturbance);
  for (const std::string& word : config.words("model")) {
    options.fit.model.push_back(kind_of(config, word));
  }
  config.finish();
  return request;
}

AllanRequest read_allan_request(const std::vector<std::string>& files) {
  for (const std::string& file : files) require_file(file);
  const std::string extension = fs::path(files.front()).extension().string();
  if (extension == ".yaml" || extension == ".yml") {
    if (files.size() > 1) throw ConfigError(files.front(), "a configuration stands alone; name the logs in it");
    return read_allan_config(Config::load(files.front()));
  }
  AllanRequest request;
  request.sources = guessed_sources(files);
  request.options.name = fs::path(files.front()).stem().string();
  return request;
}

NoiseInMotion read_tuned(const std::string& file) {
  require_file(file);
  NoiseInMotion tuned;
  tuned.file = file;
  try {
    const YAML::Node root = YAML::LoadFile(file);
    const auto read = [&](const char* name, const TriadUnits& units) -> std::optional<Measured> {
      const YAML::Node noise = root["noises"][name];
      if (!noise) return std::nullopt;
      const double factor = unit_factor(noise["unit"].as<std::string>(), units.noise);
      Measured m{factor * noise["value"].as<double>(), factor * noise["interval"][0].as<double>(),
                 factor * noise["interval"][1].as<double>()};
      m.sigma_log = std::log(m.high / m.low) / 4;
      return m;
    };
    tuned.gyro = read("gyro.noise", kGyroUnits);
    tuned.accel = read("accel.noise", kAccelUnits);
  } catch (const std::exception& e) {
    throw ConfigError(file, fmt::format("is no tune.json ({}); name the one that `tune` wrote", e.what()));
  }
  if (!tuned.gyro && !tuned.accel)
    throw ConfigError(file, "has no gyro.noise and no accel.noise; name the tune.json that `tune` wrote");
  return tuned;
}

}  // namespace piste
