#pragma once
/// A shipped scenario simulated with its first MT-9A alone and replayed, both by the programs.

#include <yaml-cpp/yaml.h>

#include <string>

#include "support/navigation.h"
#include "support/places.h"
#include "support/program.h"

namespace piste::test {

class Mt9aRun {
 public:
  /// Omitting the other IMUs changes no row of this one, and takes a quarter of the time.
  Mt9aRun(const std::string& scenario, int seed) {
    const std::string config = source_folder() + "/config/";
    folder_.write("alone.yaml", fmt::format("base: {0}scenarios/{1}.yaml\n"
                                            "imus:\n"
                                            "  - name: mt9a_1\n"
                                            "    sensor: {0}sensors/xsens_mt9a.yaml\n"
                                            "    boresight: 1.9 -2.4 2.1 deg\n"
                                            "    position: 0.06 0.05 -0.03 m\n"
                                            "    rate: 100 Hz\n"
                                            "    clock: {{offset: 12.3456 s, drift: 18 ppm}}\n",
                                            config, scenario));
    const Said said = run_program(
        program("simulate"), {"alone.yaml", "--output", "run", "--seed", std::to_string(seed), "--quiet"}, folder_);
    if (said.code != 0) throw std::runtime_error(said.err);
    truth_ = YAML::LoadFile(folder_ / "run/truth.json");
  }

  /// The true errors of the IMU.
  YAML::Node imu() const { return truth_["imus"]["mt9a_1"]; }
  Interval under_way() const { return {truth_["run_s"][0].as<double>(), truth_["run_s"][1].as<double>()}; }

  /// Replays with a receiver and an unknown heading. `gnss` is added to the receiver's entry, `sources` to the
  /// configuration, `blocks` to the estimated blocks.
  void replay(const std::string& receiver, const std::string& gnss = "", const std::string& sources = "",
              const std::string& blocks = "") const {
    const YAML::Node clock = imu(), lever_arm = clock["lever_arm_m"][receiver];
    folder_.write(
        "run.yaml",
        fmt::format("imu: {{file: run/mt9a_1.csv, sensor: {}/config/sensors/xsens_mt9a.yaml, clock: {{offset: {} s, "
                    "drift: {} ppm}}}}\n"
                    "gnss: {{file: run/{}.csv, lever_arm: {} {} {} m{}}}\n{}"
                    "initial: {{heading: auto}}\n"
                    "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale{}]\n",
                    source_folder(), clock["clock_offset_s"].as<std::string>(),
                    clock["clock_drift_ppm"].as<std::string>(), receiver, lever_arm[0].as<std::string>(),
                    lever_arm[1].as<std::string>(), lever_arm[2].as<std::string>(), gnss, sources, blocks));
    const Said said = run_program(program("replay"), {"run.yaml", "--output", "result", "--quiet"}, folder_);
    if (said.code != 0) throw std::runtime_error(said.err);
  }

  /// Accuracy of an output such as "filtered", while under way.
  Accuracy accuracy_of(const std::string& output) const {
    return accuracy(read_table(folder_ / fmt::format("result/{}.csv", output)), read_table(folder_ / "run/truth.csv"),
                    under_way());
  }
  YAML::Node summary() const { return YAML::LoadFile(folder_ / "result/summary.json"); }

 private:
  TemporaryFolder folder_;
  YAML::Node truth_;
};

}  // namespace piste::test
