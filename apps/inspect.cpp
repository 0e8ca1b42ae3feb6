/// inspect FILE…: shows the contents of logs and their faults.

#include "piste/search/inspect.h"

#include <fmt/format.h>

#include <algorithm>

#include "app.h"
#include "piste/core/error.h"
#include "piste/outputs/folders.h"

namespace piste {
namespace {

void run(const AppArguments& arguments, Progress& progress) {
  for (const std::string& file : arguments.inputs) {
    if (!std::filesystem::exists(file)) throw ConfigError(file, "there is no such file");
  }
  OutputFolder output(arguments.output);
  progress.start_work();
  constexpr double kLooking = 0.9;  // of the work
  Inspection found =
      inspect(arguments.inputs, [&](std::string_view stage, double part) { progress.go_on(stage, kLooking * part); });
  const std::string text = write_inspection(output, found, [&](double part) {
    progress.go_on("replay of what is written", kLooking + (1 - kLooking) * part);
  });
  progress.clear();
  output.commit();
  say(arguments, fmt::format("{}\nwritten to {}", text, output.folder().string()));
  const auto unreadable = std::find_if(found.suspicions.begin(), found.suspicions.end(),
                                       [](const Suspicion& s) { return s.fault == LogFault::kUnreadable; });
  if (unreadable != found.suspicions.end()) throw DataError("", unreadable->what);
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  return piste::run_app(
      {.name = "inspect",
       .summary =
           "Checks logs of IMUs and GNSS, and writes a configuration. Prints what they contain and what looks wrong.",
       .input = "FILE",
       .input_help = "logs of IMUs, receivers and reference attitudes, of any format that piste reads",
       .many_inputs = true},
      argc, argv, piste::run);
}
