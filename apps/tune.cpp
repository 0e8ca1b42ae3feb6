/// tune CONFIG: estimates the maximum-likelihood noise of the sensors from the innovations of a replay.

#include "piste/search/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "app.h"
#include "piste/configuration/replay_config.h"
#include "piste/files/tuning.h"
#include "piste/outputs/folders.h"

namespace piste {
namespace {

void run(const AppArguments& arguments, Progress& progress) {
  constexpr double kSteps = 100;
  const ReplayConfig config = read_replay_config(arguments.input);
  OutputFolder output(arguments.output);
  progress.start("tuning", static_cast<std::size_t>(kSteps), "%");
  TuneOptions how{.jobs = static_cast<std::size_t>(arguments.integers.at("jobs")),
                  .hold_out = static_cast<double>(arguments.integers.at("hold-out"))};
  for (const LogFile& log : config.gnss) how.stated.push_back(stated_before(log.sigma_scales));
  const Tuning found = tune(read_recording(config), replay_options(config), how,
                            [&](double part) { progress.update(static_cast<std::size_t>(kSteps * part)); });
  progress.clear();
  write_tune(output, config, found);
  output.commit();
  say(arguments, fmt::format("{}written to {}", tuning_text(found), output.folder().string()));
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  const auto cores = static_cast<long>(std::max(1U, std::thread::hardware_concurrency()));
  return piste::run_app(
      {.name = "tune",
       .summary = "Estimates the noise of IMU and GNSS from a run in motion. Finds the maximum-likelihood white noise, "
                  "drift and GNSS errors, given the innovations of the replay.",
       .integers = {{"jobs", "filter runs at a time; the results do not depend on it", cores, 1, "one for each core"},
                    {"hold-out", "of each two stretches of so many seconds the second is not fitted to, and judged",
                     0}}},
      argc, argv, piste::run);
}
