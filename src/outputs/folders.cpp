#include "piste/outputs/folders.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/json.h"
#include "outputs/own_replay.h"
#include "piste/configuration/replay_config.h"
#include "piste/configuration/sensor_file.h"
#include "piste/core/error.h"
#include "piste/core/version.h"
#include "piste/diagnosis/diagnose.h"
#include "piste/files/consistency.h"
#include "piste/files/tuning.h"
#include "piste/replay/replay.h"
#include "piste/report/consistency_page.h"
#include "piste/report/inspection_page.h"
#include "piste/report/inspection_text.h"
#include "piste/report/tuning_page.h"
#include "piste/search/rounds.h"

namespace piste {
namespace {

constexpr const char *kReplayFile = "replay.yaml", *kSensorFile = "sensor.yaml";

// Makes text fit a one-line comment.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// What a replay of a configuration shows; an empty text means no fault.
struct OwnReplay {
  std::string wrong = {};  // where its sigmas are inconsistent
  std::string sway = {};   // where its antenna seems to move on the body
};

// `text` names its files relative to `folder`.
OwnReplay own_replay(const std::string& text, const std::filesystem::path& folder) {
  constexpr double kLongest = 3600;  // s: an hour suffices to judge
  try {
    const ReplayConfig config = read_replay_config(Config::parse(text, folder / kReplayFile));
    ReplayOptions options = replay_options(config);
    options.longest = kLongest;
    const Replay run = replay(read_recording(config), options);
    const Verdict verdict = diagnose(run.log, run.options, config.initial, run.found, run.filtered.solution,
                                     run.smoothed ? &*run.smoothed : nullptr);
    std::vector<SigmaScales> scales;
    for (const LogFile& file : config.gnss) scales.push_back(file.sigma_scales);
    return {.wrong = verdict.consistent ? "" : one_line(verdict_line(verdict)),
            .sway = find_sway(run.log, run.options, run.found, scales).value_or("")};
  } catch (const Error& e) {
    return {.wrong = one_line(fmt::format("no replay runs with it: {}", e.what()))};
  }
}

std::string inspection_json(const Inspection& found) {
  std::vector<std::string> rounds, suspicions;
  for (const InspectedRound& round : found.rounds) {
    rounds.push_back(json::object({{"verdict", json::string(round.verdict)},
                                   {"taken", json::string(round.taken)},
                                   {"gain", json::number(round.gain, 4)}}));
  }
  for (const Suspicion& s : found.suspicions) {
    suspicions.push_back(json::object(
        {{"file", json::string(s.file)}, {"what", json::string(s.what)}, {"remedy", json::string(s.remedy)}}));
  }
  return json::object({{"suspicions", json::array(suspicions)}, {"rounds", json::array(rounds)}}, 0) + "\n";
}

}  // namespace

std::string write_inspection(OutputFolder& output, Inspection& found, const ProgressCallback& progress) {
  const std::filesystem::path& folder = output.folder();
  auto config = ready_config(found, folder.string(), kSensorFile);
  if (config) {
    output.write(kSensorFile, sensor_text(guess_sensor(found)));
    // Until all is written, the sensor's file has another name.
    const std::string sensor = output.partial(kSensorFile).filename().string();
    const auto configured = [&](const Inspection& now) {
      output.write(kSensorFile, sensor_text(guess_sensor(now)));
      return read_replay_config(Config::parse(*ready_config(now, folder.string(), sensor), folder / kReplayFile));
    };
    constexpr double kCauses = 0.5, kWithheld = 0.7;  // of the work
    take_causes(found, configured, part_of(progress, 0, kCauses));
    if (progress) progress(kCauses);
    widen_by_withheld(found, configured);
    if (progress) progress(kWithheld);
    output.write(kSensorFile, sensor_text(guess_sensor(found)));
    config = ready_config(found, folder.string(), kSensorFile);
    const auto [wrong, sway] = own_replay(*ready_config(found, folder.string(), sensor), folder);
    for (const InspectedLog& log : found.logs) {
      if (!log.calibration || !log.calibration->sway) continue;
      found.suspicions.push_back(
          {LogFault::kAntennaSways, log.log.file,
           fmt::format("its antenna moves on the body, by some {:.2g} cm", 100 * log.calibration->sway->sigma.x()),
           "`lever_arm_sway` in the configuration states it; check whether it can move"});
    }
    if (!sway.empty()) {
      found.suspicions.push_back(
          {LogFault::kAntennaSways, kReplayFile, sway,
           "if it is on a helmet or a pack, state it under `gnss`: sigmas are narrower with it"});
    }
    if (!wrong.empty()) {
      found.suspicions.insert(found.suspicions.begin(),
                              {LogFault::kDoesNotHold, kReplayFile, wrong,
                               "until that is corrected, do not rely on the sigmas of a replay with it"});
      config = fmt::format("{}{}.\n{}", kOwnReplaySays, wrong, *config);
    }
  }
  output.write("inspection.json", inspection_json(found));
  std::string text = inspection_text(found, config);
  output.write("inspection.txt", text);
  output.write("inspection.html", inspection_page(found, config, version()));
  if (config) {
    output.write(kReplayFile, *config);
  } else {
    output.withdraw(kReplayFile);
    output.withdraw(kSensorFile);
  }
  return text;
}

void write_simulation(OutputFolder& output, const std::string& prefix, const Scenario& scenario,
                      const Simulation& simulation, std::uint64_t seed) {
  for (std::size_t i = 0; i < simulation.imus.size(); ++i) {
    const SimulatedImu& imu = simulation.imus[i];
    output.write(prefix + imu.recording.file, imu_csv(imu.recording));
    const std::string name = i == 0 ? "truth.csv" : "truth_" + imu.recording.file;
    output.write(prefix + name, truth_csv(simulation.bodies[i], imu.gps_time, scenario.truth_every));
  }
  for (const GnssRecording& gnss : simulation.gnss) output.write(prefix + gnss.file, gnss_csv(gnss));
  for (const AttitudeRecording& attitude : simulation.attitude) {
    output.write(prefix + attitude.file, attitude_csv(attitude));
  }
  const SimulatedAids& aids = simulation.aids;
  if (!aids.speed.fixes.empty()) output.write(prefix + aids.speed.file, speed_csv(aids.speed));
  if (!aids.height.fixes.empty()) output.write(prefix + aids.height.file, height_csv(aids.height));
  if (!aids.heading.fixes.empty()) output.write(prefix + aids.heading.file, heading_csv(aids.heading));
  output.write(prefix + "truth.json", truth_json(scenario, simulation, seed));
}

void write_tune(OutputFolder& output, const ReplayConfig& config, const Tuning& tuning) {
  output.write("tune.html", tuning_page(tuning, config.file.stem().string(), tuned_sensor(config, tuning), version()));
  write_tuning(output, config, tuning);  // last, as tune.json says that all is there
}

void write_consistency(OutputFolder& output, const ConsistencyReport& report, const std::string& title,
                       const std::string& scenario) {
  output.write("consistency.json", consistency_json(report, title));
  output.write("consistency.md", consistency_row_head() + consistency_row(report, title));
  output.write("consistency.html", consistency_html(report, title, version(), scenario));
}

}  // namespace piste
