/// simulate SCENARIO: what sensors would have recorded of a run that is known exactly.

#include <fmt/format.h>

#include "app.h"
#include "piste/io/output.h"
#include "piste/sim/simulation.h"

namespace piste {
namespace {

void run(const AppArguments& arguments, Progress& progress) {
  const Scenario scenario = read_scenario(arguments.input);
  const auto given = arguments.integers.find("seed");
  const std::uint64_t seed =
      given == arguments.integers.end() ? scenario.seed : static_cast<std::uint64_t>(given->second);

  progress.start("simulate", scenario.imus.size() + scenario.gnss.size() + scenario.attitude.size(), "sensors");
  const Simulation simulation = simulate(scenario, seed, [&](std::size_t done, std::size_t) { progress.update(done); });

  OutputFolder out(arguments.output);
  for (std::size_t i = 0; i < simulation.imus.size(); ++i) {
    const SimulatedImu& imu = simulation.imus[i];
    out.write(imu.recording.file, imu_csv(imu.recording));
    const std::string name = i == 0 ? "truth.csv" : "truth_" + imu.recording.file;
    out.write(name, truth_csv(simulation.bodies[i], imu.gps_time, scenario.truth_every));
  }
  for (const GnssRecording& gnss : simulation.gnss) out.write(gnss.file, gnss_csv(gnss));
  for (const AttitudeRecording& attitude : simulation.attitude) out.write(attitude.file, attitude_csv(attitude));
  out.write("truth.json", truth_json(scenario, simulation, seed));
  out.commit();
  progress.clear();
  say(arguments, fmt::format("{}: {:.0f} s, seed {}, in {}", arguments.input, scenario.motion.duration(), seed,
                             arguments.output.string()));
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  const piste::AppDescription description{
      .name = "simulate",
      .summary = "Simulates a run: the logs of its sensors, and the truth (truth.csv, truth.json).",
      .input = "SCENARIO",
      .input_help = "scenario file (YAML), such as config/scenarios/ski.yaml",
      .integers = {{"seed", "of all that is random; without it the scenario's"}},
  };
  return piste::run_app(description, argc, argv, piste::run);
}
