#include "piste/files/alignment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>

#include "files/alignment_members.h"
#include "io/csv.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

using Layout = AlignmentLayout;

constexpr double kPpm = 1e6;

/// A vector and its sigma; NaN where it is not determined.
struct Triad {
  Vector3d value, sigma;
};

Triad known(Triad t) {
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(t.sigma(i))) t.value(i) = kNaN;
  }
  return t;
}

Triad triad(const Alignment& a, const Vector3d& value, int block, double factor) {
  return known({factor * value, factor * a.sigma(block)});
}

// Roll, pitch and heading of R_rb [deg].
Triad boresight(const Alignment& a) {
  return known({kDegreesPerRadian * to_euler(a.q_rb), kDegreesPerRadian * a.boresight_sigma()});
}

void add(json::Members& members, const std::string& name, const Triad& t) {
  members.emplace_back(name, json::numbers(t.value));
  members.emplace_back("sigma_" + name, json::numbers(t.sigma));
}

void add(json::Members& members, const std::string& name, double value, double sigma) {
  members.emplace_back(name, std::isfinite(sigma) ? json::number(value, 12) : "null");
  members.emplace_back("sigma_" + name, json::number(sigma));
}

}  // namespace

json::Members alignment_members(const Alignment& a) {
  json::Members members;
  add(members, "clock_offset_s", a.clock_offset, std::sqrt(a.variance(Layout::kClockOffset)));
  add(members, "clock_drift_ppm", kPpm * a.clock_drift, kPpm * std::sqrt(a.variance(Layout::kClockDrift)));
  add(members, "boresight_deg", boresight(a));
  add(members, "lever_arm_m", triad(a, a.p_rb_r, Layout::kLeverArm, 1));
  add(members, "gyro_bias_deg_s", triad(a, a.gyro_bias, Layout::kGyroBias, kDegreesPerRadian));
  add(members, "accel_bias_m_s2", triad(a, a.accel_bias, Layout::kAccelBias, 1));
  add(members, "gyro_scale_ppm", triad(a, a.gyro_scale, Layout::kGyroScale, kPpm));
  add(members, "accel_scale_ppm", triad(a, a.accel_scale, Layout::kAccelScale, kPpm));
  members.emplace_back("undetermined", json::strings(a.undetermined));
  members.emplace_back("warnings", json::strings(a.warnings));
  members.emplace_back("correlation", json::object({{"peak", json::number(a.correlation.peak)},
                                                    {"rival", json::number(a.correlation.rival)}}));
  members.emplace_back("residual", json::object({{"gyro_deg_s", json::number(kDegreesPerRadian * a.gyro_residual)},
                                                 {"accel_m_s2", json::number(a.accel_residual)}}));
  return members;
}

std::string alignment_json(const Alignment& alignment) { return json::object(alignment_members(alignment), 0) + "\n"; }

std::string aligned_csv(const AlignedImus& imus) {
  constexpr int kTime = 6, kRate = 6, kForce = 6;
  std::vector<CsvColumn> columns{{"time_s", kTime}};
  for (const char* of : {"", "reference_"}) {
    for (const char axis : {'x', 'y', 'z'}) columns.push_back({fmt::format("{}gyro_{}_deg_s", of, axis), kRate});
    for (const char axis : {'x', 'y', 'z'}) columns.push_back({fmt::format("{}accel_{}_m_s2", of, axis), kForce});
  }
  columns.push_back({"usable", 0});
  CsvWriter csv(columns);
  std::vector<double> row;
  const auto append = [&row](const Vector3d& v, double factor) {
    row.insert(row.end(), {factor * v.x(), factor * v.y(), factor * v.z()});
  };
  for (std::size_t k = 0; k < imus.time.size(); ++k) {
    row.assign(1, imus.time[k]);
    append(imus.gyro[k], kDegreesPerRadian);
    append(imus.accel[k], 1);
    append(imus.reference_gyro[k], kDegreesPerRadian);
    append(imus.reference_accel[k], 1);
    row.push_back(imus.usable[k]);
    csv.row(row);
  }
  return std::move(csv).text();
}

}  // namespace piste
