#include "piste/outputs/folders.h"

#include "piste/core/version.h"
#include "piste/files/consistency.h"
#include "piste/io/sensor_file.h"
#include "piste/report/consistency_page.h"
#include "piste/report/inspection_page.h"
#include "piste/report/inspection_text.h"

namespace piste {

std::string write_inspection(OutputFolder& output, const Inspection& found) {
  constexpr const char* kSensorFile = "sensor.yaml";
  const auto config = ready_config(found, output.folder().string(), kSensorFile);
  std::string text = inspection_text(found, config);
  output.write("inspection.txt", text);
  output.write("inspection.html", inspection_page(found, config, version()));
  if (config) {
    output.write("replay.yaml", *config);
    output.write(kSensorFile, sensor_text(guess_sensor(found)));
  } else {
    output.withdraw("replay.yaml");
    output.withdraw(kSensorFile);
  }
  return text;
}

void write_simulation(OutputFolder& output, const std::string& prefix, const Scenario& scenario,
                      const Simulation& simulation, std::uint64_t seed) {
  for (std::size_t i = 0; i < simulation.imus.size(); ++i) {
    const SimulatedImu& imu = simulation.imus[i];
    output.write(prefix + imu.recording.file, imu_csv(imu.recording));
    const std::string name = i == 0 ? "truth.csv" : "truth_" + imu.recording.file;
    output.write(prefix + name, truth_csv(simulation.bodies[i], imu.gps_time, scenario.truth_every));
  }
  for (const GnssRecording& gnss : simulation.gnss) output.write(prefix + gnss.file, gnss_csv(gnss));
  for (const AttitudeRecording& attitude : simulation.attitude) {
    output.write(prefix + attitude.file, attitude_csv(attitude));
  }
  const SimulatedAids& aids = simulation.aids;
  if (!aids.speed.fixes.empty()) output.write(prefix + aids.speed.file, speed_csv(aids.speed));
  if (!aids.height.fixes.empty()) output.write(prefix + aids.height.file, height_csv(aids.height));
  if (!aids.heading.fixes.empty()) output.write(prefix + aids.heading.file, heading_csv(aids.heading));
  output.write(prefix + "truth.json", truth_json(scenario, simulation, seed));
}

void write_consistency(OutputFolder& output, const ConsistencyReport& report, const std::string& title,
                       const std::string& scenario) {
  output.write("consistency.json", consistency_json(report, title));
  output.write("consistency.md", consistency_row_head() + consistency_row(report, title));
  output.write("consistency.html", consistency_html(report, title, version(), scenario));
}

}  // namespace piste
