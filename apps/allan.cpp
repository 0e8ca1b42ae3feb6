/// allan LOG…: the noise of an IMU from recordings at rest, and the sensor file with it.

#include "piste/recordings/allan.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "app.h"
#include "piste/configuration/sensor_file.h"
#include "piste/outputs/batch_folders.h"
#include "piste/report/allan_text.h"

namespace piste {
namespace {

AllanRequest request_of(const AppArguments& arguments) {
  AllanRequest request = read_allan_request(arguments.inputs);
  AllanOptions& options = request.options;
  options.robust = options.robust || arguments.flags.at("robust");
  options.at_rest = options.at_rest || arguments.flags.at("at-rest");
  if (const auto sensor = arguments.files.find("sensor"); sensor != arguments.files.end()) {
    options.base_file = sensor->second;
    options.base = read_sensor(options.base_file);
  }
  if (const auto tuned = arguments.files.find("tuned"); tuned != arguments.files.end()) {
    options.tuned = read_tuned(tuned->second);
  }
  options.jobs = static_cast<std::size_t>(arguments.integers.at("jobs"));
  return request;
}

void run(const AppArguments& arguments, Progress& progress) {
  const AllanRequest request = request_of(arguments);
  OutputFolder output(arguments.output);
  constexpr double kSteps = 100;
  progress.start("allan", static_cast<std::size_t>(kSteps), "%");
  const AllanFindings found =
      find_noise(request, [&](double part) { progress.update(static_cast<std::size_t>(kSteps * part)); });
  progress.clear();
  write_allan(output, found);
  output.commit();
  say(arguments, fmt::format("{}\nwritten to {}", allan_text(found), output.folder().string()));
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  const auto cores = static_cast<long>(std::max(1U, std::thread::hardware_concurrency()));
  return piste::run_app(
      {.name = "allan",
       .summary =
           "Estimates the noise of an IMU from recordings at rest. Writes Allan and wavelet variance, the model that "
           "fits them, and a sensor file for replay. Several recordings are taken as IMUs of one type.",
       .input = "LOG",
       .input_help = "logs of an IMU at rest, of any format that piste reads, or one configuration (YAML)",
       .many_inputs = true,
       .integers = {{"jobs", "fits at a time", cores, 1, "one for each core"}},
       .flags = {{"robust", "bound what outliers and knocks do"}, {"at-rest", "take all rows as at rest"}},
       .files = {{"sensor", "sensor file from which bias, scale and range are taken"},
                 {"tuned", "tune.json of `tune`: its noise in motion is shown for comparison"}}},
      argc, argv, piste::run);
}
