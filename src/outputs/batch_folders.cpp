#include "piste/outputs/batch_folders.h"

#include <fmt/format.h>

#include "piste/configuration/sensor_file.h"
#include "piste/core/version.h"
#include "piste/files/alignment.h"
#include "piste/files/allan.h"
#include "piste/files/findings.h"
#include "piste/files/study.h"
#include "piste/report/alignment_page.h"
#include "piste/report/allan_page.h"
#include "piste/report/study_figures.h"
#include "piste/report/study_page.h"

namespace piste {
namespace {

void write_figures(OutputFolder& output, const std::string& prefix, const std::vector<Figure>& figures) {
  for (const Figure& figure : figures) {
    output.write(fmt::format("{}figures/{}.svg", prefix, figure.name), figure.svg);
  }
}

}  // namespace

void write_alignment(OutputFolder& output, const AlignConfig& config, const AlignedPair& pair,
                     const Findings* findings) {
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
                                 .sensor = pair.imu.source.sensor,
                                 .findings = findings};
  output.write(pair.folder + "alignment.html", alignment_html(picture));
  write_figures(output, pair.folder, alignment_figures(picture));
  if (findings != nullptr) output.write(pair.folder + "findings.json", findings_json(*findings, pair.alignment));
}

void write_study(OutputFolder& output, const StudyConfig& config, const Study& study) {
  for (const StudyFile& file : study_csv(study)) output.write(file.name, file.content);
  output.write("summary.json", study_json(study));
  write_figures(output, "", study_figures(study));
  output.write("study.html", study_html(study, version(), config.echo));
}

void write_allan(OutputFolder& output, const AllanFindings& found) {
  const std::string sensor = sensor_text(found.sensor);
  output.write("sensor.yaml", sensor);
  output.write("allan.csv", allan_csv(found));
  output.write("allan.json", allan_json(found));
  output.write("allan.html", allan_page(found, sensor, version()));
}

}  // namespace piste
