#include "study/truth_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <array>

#include "piste/core/error.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// A required member. The YAML parser reads JSON too.
YAML::Node member(const YAML::Node& of, const std::string& name) {
  const YAML::Node found = of[name];
  if (!found) throw YAML::Exception(of.Mark(), fmt::format("there is no `{}`", name));
  return found;
}

Vector3d vector(const YAML::Node& node) {
  const auto values = node.as<std::array<double, 3>>();
  return {values[0], values[1], values[2]};
}

ImuTruth::Triad triad(const YAML::Node& node, const std::string& unit, double factor) {
  ImuTruth::Triad out;
  out.bias = vector(member(node, "bias_" + unit)) / factor;
  out.scale = 1e-6 * vector(member(node, "scale_ppm"));
  for (int row = 0; row < 3; ++row) out.misalignment.row(row) = vector(member(node, "misalignment")[row]);
  const auto phase = [&](const std::string& name) -> std::optional<ImuTruth::Phase> {
    const YAML::Node drift = member(node, "drift_" + name + "_" + unit);
    if (drift.IsNull()) return std::nullopt;
    const std::string mean = name == "run" ? "run_mean_" : "mean_" + name + "_";
    return ImuTruth::Phase{vector(drift) / factor, vector(member(node, mean + unit)) / factor};
  };
  out.before = phase("before");
  out.run = phase("run");
  out.after = phase("after");
  return out;
}

}  // namespace

ImuTruth read_truth(const std::filesystem::path& file, const std::string& name) {
  try {
    const YAML::Node imu = member(member(YAML::LoadFile(file.string()), "imus"), name);
    return {triad(member(imu, "gyro"), "deg_s", kDegreesPerRadian), triad(member(imu, "accel"), "m_s2", 1)};
  } catch (const YAML::BadFile&) {
    throw DataError(file.string(), "cannot be read; give the truth.json that `simulate` wrote next to the logs");
  } catch (const YAML::Exception& e) {
    throw DataError(fmt::format("{}:{}", file.string(), e.mark.line + 1),
                    fmt::format("{}; a truth.json that `simulate` wrote is expected", e.msg));
  }
}

}  // namespace piste
