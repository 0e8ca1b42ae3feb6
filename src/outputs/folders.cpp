#include "piste/outputs/folders.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/json.h"
#include "math/words.h"
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
#include "piste/search/readings.h"
#include "piste/search/rounds.h"
#include "search/judged.h"

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
  bool ran = true;
  Likelihoods likelihoods = {};
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
            .sway = find_sway(run.log, run.options, run.found, scales).value_or(""),
            .likelihoods = likelihoods(run.filtered.solution.innovations, run.filtered.solution.sources)};
  } catch (const Error& e) {
    return {.wrong = one_line(fmt::format("no replay runs with it: {}", e.what())), .ran = false};
  }
}

std::string inspection_json(const Inspection& found) {
  std::vector<std::string> rounds, suspicions, doubts;
  for (const InspectedDoubt& doubt : found.doubts) {
    std::vector<std::string> readings;
    for (const InspectedReading& reading : doubt.readings) {
      readings.push_back(json::object({{"keys", json::string(reading.keys)}, {"ln_p", json::number(reading.ln_p, 6)}}));
    }
    doubts.push_back(json::object({{"what", json::string(doubt.what)}, {"readings", json::array(readings)}}));
  }
  for (const InspectedRound& round : found.rounds) {
    rounds.push_back(json::object({{"verdict", json::string(round.verdict)},
                                   {"taken", json::string(round.taken)},
                                   {"gain", json::number(round.gain, 4)}}));
  }
  for (const Suspicion& s : found.suspicions) {
    suspicions.push_back(json::object(
        {{"file", json::string(s.file)}, {"what", json::string(s.what)}, {"remedy", json::string(s.remedy)}}));
  }
  return json::object({{"suspicions", json::array(suspicions)},
                       {"doubts", json::array(doubts)},
                       {"rounds", json::array(rounds)}},
                      0) +
         "\n";
}

// The configuration of an inspection until all is written: its sensor file, and logs that were given as text, have the
// names of partial files.
class Draft {
 public:
  explicit Draft(OutputFolder& output) : output_(output) {}

  // Writes the sensor file, too.
  std::string text(const Inspection& found) const {
    output_.write(kSensorFile, sensor_text(guess_sensor(found)));
    const bool on_disk =
        std::ranges::none_of(found.logs, [](const InspectedLog& log) { return log.log.content.has_value(); });
    return *ready_config(on_disk ? found : with_partial_names(found), output_.folder().string(),
                         partial_name(kSensorFile));
  }
  ReplayConfig read(const Inspection& found) const {
    return read_replay_config(Config::parse(text(found), output_.folder() / kReplayFile));
  }
  OwnReplay replayed(const Inspection& found) const { return own_replay(text(found), output_.folder()); }

 private:
  std::string partial_name(const std::string& name) const { return output_.partial(name).filename().string(); }
  Inspection with_partial_names(Inspection found) const {
    for (InspectedLog& log : found.logs) {
      if (log.log.content) log.log.file = partial_name(log.log.file);
    }
    return found;
  }

  OutputFolder& output_;
};

// A body that does not leave its place shows no heading: a replay then begins with any.
void try_any_heading(Inspection& found, const Draft& draft, OwnReplay& own) {
  found.any_heading = true;
  OwnReplay standing = draft.replayed(found);
  found.any_heading = standing.ran;
  if (!standing.ran) return;
  found.suspicions.push_back({LogFault::kNoMotion, kReplayFile, own.wrong,
                              "the configuration begins with any heading, whose sigma says that it is not known"});
  own = std::move(standing);
}

// Rows are means over their intervals, or instants. If the sigmas do not hold with means, the run is repeated with
// instants: on a body that vibrates the two differ. Instants are taken if the sigmas hold then, and the innovations
// gain more than ln(number of readings) + 3. Sums of samples, as in the rounds before, have no vibration.
void try_instants(Inspection& found, const Draft& draft, OwnReplay& own) {
  constexpr double kReadings = 2;
  InspectedLog& body = found.logs[*found.first(LogKind::kImu)];
  if (found.calibration() == nullptr || body.imu.increments) return;
  Calibration& calibration = *found.logs[*found.first(LogKind::kGnss)].calibration;
  calibration.instantaneous = true;
  OwnReplay instants = draft.replayed(found);
  const double more = gain(instants.likelihoods, own.likelihoods);
  calibration.instantaneous = instants.ran && instants.wrong.empty() && more > std::log(kReadings) + 3;
  if (!calibration.instantaneous) return;
  found.suspicions.push_back(
      {LogFault::kDoubt, body.log.file,
       fmt::format("its rows are instants, by {} of ln p likelier than means over their intervals", plain(more, 3)),
       "`sampling: instant`, as the configuration has it"});
  own = std::move(instants);
}

void list_swaying_antennas(Inspection& found, const OwnReplay& own) {
  for (const InspectedLog& log : found.logs) {
    if (!log.calibration || !log.calibration->sway) continue;
    found.suspicions.push_back(
        {LogFault::kAntennaSways, log.log.file,
         fmt::format("its antenna moves on the body, by some {:.2g} cm", 100 * log.calibration->sway->sigma.x()),
         "`lever_arm_sway` in the configuration states it; check whether it can move"});
  }
  if (own.sway.empty()) return;
  found.suspicions.push_back({LogFault::kAntennaSways, kReplayFile, own.sway,
                              "if it is on a helmet or a pack, state it under `gnss`: sigmas are narrower with it"});
}

// Makes what is written hold by its own verdict, or the first line of the list say why not. Returns that verdict.
OwnReplay close_loop(OutputFolder& output, Inspection& found, const ProgressCallback& progress) {
  constexpr double kCauses = 0.5, kWithheld = 0.7;  // of the work
  const Draft draft(output);
  const auto configured = [&](const Inspection& now) { return draft.read(now); };
  weigh_readings(found, configured);
  take_causes(found, configured, part_of(progress, 0, kCauses));
  if (progress) progress(kCauses);
  widen_by_withheld(found, configured);
  if (progress) progress(kWithheld);
  OwnReplay own = draft.replayed(found);
  if (!own.ran) {
    try_any_heading(found, draft, own);
  } else if (!own.wrong.empty()) {
    try_instants(found, draft, own);
  }
  list_swaying_antennas(found, own);
  if (own.wrong.empty()) return own;
  found.suspicions.insert(found.suspicions.begin(),
                          {LogFault::kDoesNotHold, kReplayFile, own.wrong,
                           "until that is corrected, do not rely on the sigmas of a replay with it"});
  return own;
}

}  // namespace

std::string write_inspection(OutputFolder& output, Inspection& found, const ProgressCallback& progress) {
  const auto written = [&] { return ready_config(found, output.folder().string(), kSensorFile); };
  auto config = written();
  if (config) {
    const OwnReplay own = close_loop(output, found, progress);
    output.write(kSensorFile, sensor_text(guess_sensor(found)));
    config = written();
    if (!own.wrong.empty()) config = fmt::format("{}{}.\n{}", kOwnReplaySays, own.wrong, *config);
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
  if (scenario.motion.course) output.write(prefix + "gates.csv", gates_csv(simulation.trunk));
  output.write(prefix + "truth.json", truth_json(scenario, simulation, seed));
}

std::string tune_page(const ReplayConfig& config, const Tuning& tuning) {
  return tuning_page(tuning, config.file.stem().string(), tuned_sensor(config, tuning), version());
}

void write_tune(OutputFolder& output, const ReplayConfig& config, const Tuning& tuning) {
  output.write("tune.html", tune_page(config, tuning));
  write_tuning(output, config, tuning);  // last, as tune.json says that all is there
}

void write_consistency(OutputFolder& output, const ConsistencyReport& report, const std::string& title,
                       const std::string& scenario) {
  output.write("consistency.json", consistency_json(report, title));
  output.write("consistency.md", consistency_row_head() + consistency_row(report, title));
  output.write("consistency.html", consistency_html(report, title, version(), scenario));
}

}  // namespace piste
