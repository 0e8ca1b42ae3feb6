/// align CONFIG: estimates clock offset and drift, boresight and lever arm between two IMUs on one plate.

#include <fmt/format.h>

#include "app.h"
#include "piste/outputs/batch_folders.h"
#include "piste/report/alignment_text.h"

namespace piste {
namespace {

void run(const AppArguments& arguments, Progress& progress) {
  const AlignConfig config = read_align_config(arguments.input);
  OutputFolder output(arguments.output);
  std::string text;
  for_each_pair(config, progress.counted("align", "IMUs"), [&](const AlignedPair& pair) {
    write_alignment(output, config, pair);
    text += fmt::format("{}\n{}\n", pair.imu.name, alignment_text(pair.alignment));
  });
  progress.clear();
  output.commit();
  say(arguments, fmt::format("{}written to {}", text, output.folder().string()));
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  return piste::run_app(
      {.name = "align",
       .summary =
           "Estimates clock, boresight and lever arm between two IMUs. Both are on one plate; their logs alone give "
           "the offset and drift of the clock, the boresight and the lever arm, with sigmas."},
      argc, argv, piste::run);
}
