/// evaluate A B: how far a trajectory is from a reference, and whether its sigmas hold.

#include <fmt/format.h>

#include "app.h"
#include "piste/core/error.h"
#include "piste/evaluate/evaluation.h"
#include "piste/outputs/evaluation_folder.h"
#include "piste/report/evaluation_page.h"

namespace piste {
namespace {

std::optional<TrajectoryFormat> format_of(const std::string& name) {
  return name.empty() ? std::nullopt : std::optional(trajectory_format(name));
}

EvaluationOptions options_of(const AppArguments& arguments) {
  EvaluationOptions options{.align = alignment_kind(arguments.text("align"))};
  if (const auto& steps = arguments.texts.at("rpe"); !steps.empty()) options.steps.clear();
  for (const std::string& step : arguments.texts.at("rpe")) options.steps.push_back(relative_step(step));
  set_time_offset(options, arguments.text("time-offset"));
  return options;
}

void run(const AppArguments& arguments, Progress&) {
  if (arguments.inputs.size() != 2) throw ConfigError("", "two trajectories are expected: the estimate, the reference");
  const EvaluationOptions options = options_of(arguments);
  const Trajectory estimate = read_trajectory(
      {.path = arguments.inputs[0], .format = format_of(arguments.text("format-a")), .at = arguments.text("at")});
  const Trajectory reference =
      read_trajectory({.path = arguments.inputs[1], .format = format_of(arguments.text("format-b"))});
  OutputFolder output(arguments.output);
  const Evaluation found = evaluate(estimate, reference, options);
  write_evaluation(output, found);
  output.commit();
  say(arguments, fmt::format("{}\nwritten to {}", evaluation_text(found), output.folder().string()));
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  const std::string formats = "format of {}, one of " + piste::trajectory_format_names() + " (default: recognised)";
  return piste::run_app(
      {.name = "evaluate",
       .summary = "Compares a trajectory with a reference. Gives absolute and relative errors, and says whether the "
                  "sigmas of the first hold.",
       .input = "TRAJECTORY",
       .input_help = "A and the reference B: trajectories of any format, or folders of replays",
       .many_inputs = true,
       .texts = {{"align", "none, position, yaw, se3, or sim3: how A is moved onto B first", "KIND", "none"},
                 {"rpe", "step of the relative error, such as 100m or 1s; may be repeated (default: 100m and 1s)",
                  "STEP", "", true},
                 {"at", "take A at this point of its `output: {at}`", "NAME"},
                 {"time-offset", "seconds to add to the times of A, or auto: estimated", "S", "0"},
                 {"format-a", fmt::format(fmt::runtime(formats), "A"), "NAME"},
                 {"format-b", fmt::format(fmt::runtime(formats), "B"), "NAME"}}},
      argc, argv, piste::run);
}
