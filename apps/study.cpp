/// study CAMPAIGN: estimates the errors of all IMUs in all runs by every method, and ranks the methods by navigation.

#include "piste/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "app.h"
#include "piste/core/error.h"
#include "piste/outputs/batch_folders.h"
#include "piste/report/study_text.h"
#include "piste/study/missing.h"

namespace piste {
namespace {

void run(const AppArguments& arguments, Progress& progress) {
  const StudyConfig config = read_study_config(arguments.input);
  OutputFolder output(arguments.output);
  StudyOptions options;
  options.jobs = static_cast<std::size_t>(arguments.integers.at("jobs"));
  const Study study = run_study(config, options, progress.counted("study", "steps"));
  progress.clear();
  const bool any = std::any_of(study.results.begin(), study.results.end(),
                               [](const SensorRun& result) { return result.failure.empty(); });
  if (!any) throw DataError(arguments.input, "no IMU of any run could be studied; " + missing(study).front());

  write_study(output, config, study);
  output.commit();
  say(arguments, study_text(study));
  say(arguments, "written to " + output.folder().string());
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  const auto cores = static_cast<long>(std::max(1U, std::thread::hardware_concurrency()));
  const piste::AppDescription description{
      .name = "study",
      .summary =
          "Compares methods of IMU calibration over a campaign. Estimates biases and scales of the IMUs against a "
          "reference by every method, with tables and figures, and ranks the methods by the navigation they lead to.",
      .input = "CAMPAIGN",
      .input_help = "campaign file (YAML), such as `simulate config/scenarios/campaign.yaml` writes",
      .integers = {{"jobs", "runs at a time; the results do not depend on it", cores, 1, "one for each core"}},
  };
  return piste::run_app(description, argc, argv, piste::run);
}
