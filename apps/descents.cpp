/// descents [NAME=]RUN…: where one run of a course gained on another, and how sure that is.

#include "piste/descents/descents.h"

#include <fmt/format.h>

#include "app.h"
#include "piste/core/error.h"
#include "piste/io/config.h"
#include "piste/outputs/descents_folder.h"
#include "piste/report/descents_page.h"

namespace piste {
namespace {

// `NAME=RUN` or `RUN`.
Descent descent_of_argument(const std::string& argument, const std::string& at) {
  const std::size_t equals = argument.find('=');
  const bool named = equals != std::string::npos && !std::filesystem::exists(argument);
  const std::string name = named ? argument.substr(0, equals) : "",
                    run = named ? argument.substr(equals + 1) : argument;
  if (std::filesystem::is_directory(run)) return descent_of(std::filesystem::path(run), at, name);
  return descent_of(read_replay_config(run), at, name);
}

double common_of(const std::string& text) {
  if (text.empty()) return 0;
  return Config::parse(fmt::format("common: {}\n", text), "--common", {}, [](const std::string&) { return "--common"; })
      .magnitude("common", dimension::kLength);
}

void run(const AppArguments& arguments, Progress& progress) {
  const DescentOptions options{.line = arguments.text("line"), .common = common_of(arguments.text("common"))};
  std::vector<Gate> gates;
  if (const auto file = arguments.files.find("gates"); file != arguments.files.end()) gates = read_gates(file->second);
  OutputFolder output(arguments.output);
  std::vector<Descent> runs;
  progress.start("replaying", arguments.inputs.size(), "runs");
  for (const std::string& input : arguments.inputs) {
    runs.push_back(descent_of_argument(input, arguments.text("at")));
    progress.update(runs.size());
  }
  progress.clear();
  const DescentReport report = compare_descents(runs, gates, options);
  write_descents(output, report);
  output.commit();
  for (const std::string& name : report.without_sigma) {
    fmt::print(
        stderr,
        "warning: {} is a folder, which has no covariance between two crossings: its times gained have no sigma; "
        "name its configuration instead\n",
        name);
  }
  say(arguments, fmt::format("{}\nwritten to {}", descents_text(report), output.folder().string()));
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  return piste::run_app(
      {.name = "descents",
       .summary =
           "Compares runs of one course. Gives crossing times at gates, and the time gained in sections and along "
           "a line, each with its sigma.",
       .input = "RUN",
       .input_help = "configurations of replay, which are run, or folders of replays; NAME=RUN names one; of a single "
                     "RUN its laps are compared",
       .many_inputs = true,
       .files = {{"gates",
                  "gates in the order passed: name,latitude_deg,longitude_deg[,heading_deg] (default: the "
                  "apexes of turns)"}},
       .texts = {{"line", "the run whose path is the line, or mean (default: the first run)", "NAME"},
                 {"common",
                  "1-sigma along the line that all runs share, such as \"0.01 m\": in times, not in gained "
                  "times",
                  "LENGTH"},
                 {"at", "take the runs at this point of `output: {at}`", "NAME"}}},
      argc, argv, piste::run);
}
