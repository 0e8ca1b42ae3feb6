/// compare CONFIG: aligns an IMU with a better one, and estimates its errors at rest and in the run.

#include <fmt/format.h>

#include "app.h"
#include "piste/outputs/batch_folders.h"
#include "piste/report/alignment_text.h"
#include "piste/report/findings_text.h"

namespace piste {
namespace {

void run(const AppArguments& arguments, Progress& progress) {
  const AlignConfig config = read_align_config(arguments.input);
  OutputFolder output(arguments.output);
  std::string text;
  for_each_pair(config, progress.counted("align", "IMUs"), [&](const AlignedPair& pair) {
    const Findings found = findings_of(config, pair);
    write_alignment(output, config, pair, &found);
    text += fmt::format("{}\n{}\n{}\n", pair.imu.name, alignment_text(pair.alignment), findings_text(found));
  });
  progress.clear();
  output.commit();
  say(arguments, fmt::format("{}written to {}", text, output.folder().string()));
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  return piste::run_app(
      {.name = "compare",
       .summary =
           "Estimates bias and scale of an IMU against a better IMU. Aligns the two first, and estimates at rest "
           "and in the run."},
      argc, argv, piste::run);
}
