/// Columns as replay and simulate write them.

#include "io/csv.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "piste/math/units.h"
#include "trajectory/formats.h"

namespace piste::trajectory_formats {
namespace {

using Triad = std::optional<std::array<std::size_t, 3>>;

Triad find_three(CsvReader& csv, const std::array<std::string, 3>& names) {
  const auto first = csv.find(names[0]);
  if (!first) return std::nullopt;
  return {{*first, csv.column(names[1]), csv.column(names[2])}};
}

Vector3d three(const CsvReader& csv, const Triad& columns) {
  return {csv[(*columns)[0]], csv[(*columns)[1]], csv[(*columns)[2]]};
}

const std::array<std::string, 3> kVelocity{"velocity_north_m_s", "velocity_east_m_s", "velocity_down_m_s"},
    kAngles{"roll_deg", "pitch_deg", "heading_deg"}, kSigma{"sigma_north_m", "sigma_east_m", "sigma_down_m"},
    kSigmaVelocity{"sigma_velocity_north_m_s", "sigma_velocity_east_m_s", "sigma_velocity_down_m_s"},
    kSigmaAngles{"sigma_roll_deg", "sigma_pitch_deg", "sigma_heading_deg"};

// The upper triangles of covariance_STEM.csv, next to STEM.csv, if it is there and of the same rows.
void add_covariances(Trajectory& track, const std::filesystem::path& file) {
  const std::filesystem::path covariances = file.parent_path() / ("covariance_" + file.filename().string());
  if (!std::filesystem::exists(covariances)) return;
  CsvReader csv(covariances.string());
  const auto time = csv.column("time_s");
  std::vector<std::size_t> columns;
  for (const std::string& name : csv.names()) {
    if (name.starts_with("covariance_")) columns.push_back(csv.column(name));
  }
  RowFaults skipped;
  csv.finish_header(&skipped);
  constexpr std::size_t kTriangle = 45;
  if (columns.size() != kTriangle) csv.fail("45 columns of covariances are expected");
  std::vector<Eigen::Matrix<double, 9, 9>> all;
  constexpr double kSameTime = 1e-6;
  while (csv.next()) {
    if (all.size() >= track.size() || std::abs(csv[time] - track.time[all.size()]) > kSameTime) return;
    Eigen::Matrix<double, 9, 9>& P = all.emplace_back();
    std::size_t next = 0;
    for (int i = 0; i < 9; ++i) {
      for (int k = i; k < 9; ++k) {
        P(i, k) = P(k, i) = csv[columns[next++]] * (i < 6 ? 1 : kDegree) * (k < 6 ? 1 : kDegree);
      }
    }
  }
  if (all.size() == track.size()) track.covariance = std::move(all);
}

}  // namespace

bool is_csv(const FileStart& start) { return start.commas && start.first_row.find("time_s") != std::string_view::npos; }

Trajectory read_csv(const std::string& file) {
  CsvReader csv(file);
  const auto time = csv.column("time_s"), latitude = csv.column("latitude_deg"),
             longitude = csv.column("longitude_deg"), height = csv.column("height_m");
  const Triad velocity = find_three(csv, kVelocity), angles = find_three(csv, kAngles), sigma = find_three(csv, kSigma),
              sigma_velocity = find_three(csv, kSigmaVelocity), sigma_angles = find_three(csv, kSigmaAngles);
  RowFaults skipped;  // lists columns of other quantities
  csv.finish_header(&skipped);
  Trajectory track;
  IncreasingTime increasing;
  while (csv.next()) {
    track.time.push_back(increasing.next(csv[time], csv.text()));
    track.place.push_back({kDegree * csv[latitude], kDegree * csv[longitude], csv[height]});
    if (velocity) track.velocity.push_back(three(csv, velocity));
    if (angles) track.attitude.push_back(from_euler(kDegree * three(csv, angles)));
    if (sigma) track.sigma_position.push_back(three(csv, sigma));
    if (sigma_velocity) track.sigma_velocity.push_back(three(csv, sigma_velocity));
    if (sigma_angles) track.sigma_euler.emplace_back(kDegree * three(csv, sigma_angles));
  }
  add_covariances(track, file);
  return track;
}

}  // namespace piste::trajectory_formats
