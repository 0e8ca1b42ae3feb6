/// simulate SCENARIO: simulates the recordings of all sensors in a run, or in all runs of a campaign, with the truth.

#include <fmt/format.h>

#include "app.h"
#include "piste/outputs/folders.h"
#include "piste/sim/campaign.h"
#include "piste/sim/simulation.h"

namespace piste {
namespace {

std::size_t sensors_of(const Scenario& s) { return s.imus.size() + s.gnss.size() + s.attitude.size(); }

std::uint64_t seed_of(const AppArguments& arguments, std::uint64_t fallback) {
  const auto given = arguments.integers.find("seed");
  return given == arguments.integers.end() ? fallback : static_cast<std::uint64_t>(given->second);
}

// Simulates one run, and writes its files with `folder` before their names. Returns its length [s].
double write_run(OutputFolder& out, const std::string& folder, const Scenario& scenario, std::uint64_t seed,
                 const SimulationProgress& progress) {
  const Simulation simulation = simulate(scenario, seed, progress);
  write_simulation(out, folder, scenario, simulation, seed);
  return simulation.trunk.end_time() - simulation.trunk.start_time();
}

void run_scenario(const AppArguments& arguments, Progress& progress) {
  const Scenario scenario = read_scenario(arguments.input);
  const std::uint64_t seed = seed_of(arguments, scenario.seed);
  progress.start("simulate", sensors_of(scenario), "sensors");
  OutputFolder out(arguments.output);
  const double length =
      write_run(out, "", scenario, seed, [&](std::size_t done, std::size_t) { progress.update(done); });
  out.commit();
  progress.clear();
  say(arguments, fmt::format("{}: {:.0f} s, seed {}, in {}", arguments.input, length, seed, arguments.output.string()));
}

void run_campaign(const AppArguments& arguments, Progress& progress) {
  const Campaign campaign = read_campaign(arguments.input);
  const std::uint64_t seed = seed_of(arguments, campaign.seed);
  std::size_t total = 0, before = 0;
  for (const CampaignRun& run : campaign.runs) total += sensors_of(run.scenario);
  OutputFolder out(arguments.output);
  for (const CampaignRun& run : campaign.runs) {
    progress.start(run.name, total, "sensors", before);
    write_run(out, run.name + "/", run.scenario, run_seed(seed, run.name),
              [&](std::size_t done, std::size_t) { progress.update(before + done); });
    before += sensors_of(run.scenario);
  }
  for (const auto& [name, text] : campaign.files) out.write(name, text);
  out.write("campaign.yaml", campaign_text(campaign, seed));
  out.commit();
  progress.clear();
  say(arguments, fmt::format("{}: {} runs, seed {}, for study in {}", arguments.input, campaign.runs.size(), seed,
                             (arguments.output / "campaign.yaml").string()));
}

void run(const AppArguments& arguments, Progress& progress) {
  if (is_campaign(arguments.input)) {
    run_campaign(arguments, progress);
  } else {
    run_scenario(arguments, progress);
  }
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  const piste::AppDescription description{
      .name = "simulate",
      .summary =
          "Simulates logs of IMUs and GNSS receivers, with the truth. Takes a run or a campaign; the truth is in "
          "truth.csv and truth.json. A campaign comes with the campaign.yaml that study takes.",
      .input = "SCENARIO",
      .input_help =
          "scenario file (YAML), such as config/scenarios/ski.yaml, or a campaign of several: campaign.yaml "
          "there",
      .integers = {{"seed", "of all that is random; without it the scenario's"}},
  };
  return piste::run_app(description, argc, argv, piste::run);
}
