/// align CONFIG: one clock, one boresight and one lever arm for two IMUs on one plate.

#include <fmt/format.h>

#include "app.h"
#include "piste/analyse/alignment_files.h"
#include "piste/condition/pipeline.h"
#include "piste/condition/time_sync.h"
#include "piste/core/error.h"
#include "piste/io/align_config.h"
#include "piste/io/output.h"
#include "piste/report/alignment_page.h"

namespace piste {
namespace {

void run(const AppArguments& arguments, Progress& progress) {
  const AlignConfig config = read_align_config(arguments.input);
  OutputFolder output(arguments.output);
  progress.start("align", config.imus.size(), "IMUs");
  const Log reference = condition_imu(read_imu(config.reference.source), config.reference.conditioning);
  std::string text;
  std::size_t done = 0;
  for (const MountedImu& imu : config.imus) {
    const Log body = condition_imu(read_imu(imu.source), imu.conditioning);
    const Alignment alignment = align(body.imu, reference.imu,
                                      {.sensor = imu.source.sensor,
                                       .reference = config.reference.source.sensor,
                                       .low_pass = config.low_pass,
                                       .name = imu.source.log.file});
    const std::string folder = config.imus.size() > 1 ? imu.name + "/" : "";
    output.write(folder + "alignment.json", alignment_json(alignment));
    const AlignedImus aligned = bring_together(body.imu, reference.imu, alignment);
    output.write(folder + "aligned.csv", aligned_csv(aligned));
    const AlignmentPicture picture{.title = imu.name,
                                   .version = PISTE_VERSION,
                                   .config_text = config.echo,
                                   .alignment = &alignment,
                                   .aligned = &aligned,
                                   .body = &body.imu,
                                   .reference = &reference.imu,
                                   .low_pass = alignment.low_pass,
                                   .sensor = imu.source.sensor};
    output.write(folder + "alignment.html", alignment_html(picture));
    for (const Figure& figure : alignment_figures(picture)) {
      output.write(fmt::format("{}figures/{}.svg", folder, figure.name), figure.svg);
    }
    progress.update(++done);
    text += fmt::format("{}\n{}\n", imu.name, alignment_text(alignment));
  }
  output.commit();
  progress.clear();
  say(arguments, fmt::format("{}written to {}", text, output.folder().string()));
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  return piste::run_app(
      {.name = "align",
       .summary = "Two IMUs on one plate: the offset and drift of their clocks, boresight and lever arm, with sigmas."},
      argc, argv, piste::run);
}
