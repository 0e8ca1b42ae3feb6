#include "aligned_pair.h"

#include <fmt/format.h>

#include "piste/condition/pipeline.h"
#include "piste/core/version.h"
#include "piste/files/alignment.h"
#include "piste/report/alignment_page.h"

namespace piste {

void for_each_pair(const AlignConfig& config, Progress& progress, const std::function<void(const AlignedPair&)>& take) {
  progress.start("align", config.imus.size(), "IMUs");
  const Log reference = condition_imu(read_imu(config.reference.source), config.reference.conditioning);
  std::size_t done = 0;
  for (const MountedImu& imu : config.imus) {
    AlignedPair pair{.imu = imu,
                     .body = condition_imu(read_imu(imu.source), imu.conditioning).imu,
                     .reference = reference.imu,
                     .alignment = {},
                     .aligned = {},
                     .folder = config.imus.size() > 1 ? imu.name + "/" : ""};
    pair.alignment = align(pair.body, pair.reference,
                           {.sensor = imu.source.sensor,
                            .reference = config.reference.source.sensor,
                            .low_pass = config.low_pass,
                            .name = imu.source.log.file});
    pair.aligned = bring_together(pair.body, pair.reference, pair.alignment);
    take(pair);
    progress.update(++done);
  }
  progress.clear();
}

void write_alignment(OutputFolder& output, const AlignConfig& config, const AlignedPair& pair) {
  output.write(pair.folder + "alignment.json", alignment_json(pair.alignment));
  output.write(pair.folder + "aligned.csv", aligned_csv(pair.aligned));
  const AlignmentPicture picture{.title = pair.imu.name,
                                 .version = version(),
                                 .config_text = config.echo,
                                 .alignment = &pair.alignment,
                                 .aligned = &pair.aligned,
                                 .body = &pair.body,
                                 .reference = &pair.reference,
                                 .low_pass = pair.alignment.low_pass,
                                 .sensor = pair.imu.source.sensor};
  output.write(pair.folder + "alignment.html", alignment_html(picture));
  for (const Figure& figure : alignment_figures(picture)) {
    output.write(fmt::format("{}figures/{}.svg", pair.folder, figure.name), figure.svg);
  }
}

}  // namespace piste
