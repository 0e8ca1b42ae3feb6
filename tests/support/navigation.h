#pragma once
/// Reads output files, and compares a solution with the truth.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "math/numbers.h"
#include "piste/core/log.h"
#include "piste/math/earth.h"
#include "piste/math/units.h"
#include "support/text_file.h"

namespace piste::test {

/// A CSV file; a field that is no number reads as 0.
struct Table {
  std::string header;
  std::vector<std::string> names;
  std::map<std::string, std::vector<double>, std::less<>> columns;
  std::size_t rows = 0;

  const std::vector<double>& operator[](std::string_view name) const {
    const auto found = columns.find(name);
    if (found == columns.end()) throw std::runtime_error("no column " + std::string(name) + " in " + header);
    return found->second;
  }
};

inline Table read_table(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  Table table;
  std::string_view rest = text;
  const auto next_line = [&] {
    const auto end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return line;
  };
  const auto for_each_field = [](std::string_view line, auto&& take) {
    for (std::size_t i = 0, begin = 0; begin <= line.size(); ++i) {
      const auto end = std::min(line.find(',', begin), line.size());
      take(i, line.substr(begin, end - begin));
      begin = end + 1;
    }
  };
  table.header = next_line();
  for_each_field(table.header, [&](std::size_t, std::string_view name) { table.names.emplace_back(name); });
  std::vector<std::vector<double>*> places;
  for (const std::string& name : table.names) places.push_back(&table.columns[name]);
  while (!rest.empty()) {
    for_each_field(next_line(), [&](std::size_t i, std::string_view field) {
      double value = 0;
      read_number(field.data(), field.data() + field.size(), value);
      places.at(i)->push_back(value);
    });
    ++table.rows;
  }
  return table;
}

/// A column at t, interpolated linearly between rows; angles in degrees take the short way round.
inline double at(const Table& table, std::string_view column, double t) {
  const auto &time = table["time_s"], &value = table[column];
  const auto after = static_cast<std::size_t>(std::lower_bound(time.begin(), time.end(), t) - time.begin());
  if (after == 0) return value.front();
  if (after == time.size()) return value.back();
  const double part = (t - time[after - 1]) / (time[after] - time[after - 1]);
  double difference = value[after] - value[after - 1];
  if (column.ends_with("_deg")) difference = std::remainder(difference, 360.0);
  return value[after - 1] + part * difference;
}

/// Errors of a solution against the truth, at the truth's epochs.
struct Accuracy {
  double roll = 0, pitch = 0, heading = 0;            ///< RMSE [deg]
  double horizontal = 0, down = 0;                    ///< RMSE [m]
  double velocity = 0;                                ///< RMSE of the worst axis [m/s]
  Vector3d claimed_euler = Vector3d::Zero();          ///< RMS of the sigmas of roll, pitch and heading [deg]
  double claimed_horizontal = 0;                      ///< RMS of the horizontal sigmas [m]
  double attitude_nees = 0, velocity_nees = 0;        ///< mean of (error / sigma)² over epochs and axes
  double attitude_outside = 0, velocity_outside = 0;  ///< share of the errors beyond 3 sigma, of the worst axis
  double position_outside = 0;
  double largest_angle = 0, largest_horizontal = 0;  ///< error of any epoch [deg, m]
  std::size_t epochs = 0;
};

inline Accuracy accuracy(const Table& solution, const Table& truth, const Interval& during) {
  struct Sum {
    double squares = 0, variance = 0, normalised = 0, outside = 0;
  };
  std::map<std::string, Sum, std::less<>> sums;
  Accuracy result;
  for (std::size_t i = 0; i < truth.rows; ++i) {
    const double t = truth["time_s"][i];
    if (!during.contains(t) || t < solution["time_s"].front() || t > solution["time_s"].back()) continue;
    ++result.epochs;
    const auto add = [&](std::string_view name, double error, std::string_view column) {
      Sum& sum = sums[std::string(name)];
      const double sigma = at(solution, column, t);
      sum.squares += error * error;
      sum.variance += sigma * sigma;
      sum.normalised += error * error / (sigma * sigma);
      sum.outside += std::abs(error) > 3 * sigma ? 1 : 0;
    };
    const auto geodetic = [&](const auto& value) {
      return Geodetic{kDegree * value("latitude_deg"), kDegree * value("longitude_deg"), value("height_m")};
    };
    const World world(geodetic([&](std::string_view column) { return truth[column][i]; }));
    const Vector3d offset =
        world.from_geodetic(geodetic([&](std::string_view column) { return at(solution, column, t); }));
    result.largest_horizontal = std::max(result.largest_horizontal, std::hypot(offset.x(), offset.y()));
    int axis = 0;
    for (const char* name : {"north", "east", "down"}) {
      add(name, offset(axis++), fmt::format("sigma_{}_m", name));
      const std::string velocity = fmt::format("velocity_{}_m_s", name);
      add(velocity, at(solution, velocity, t) - truth[velocity][i], "sigma_" + velocity);
    }
    for (const char* name : {"roll", "pitch", "heading"}) {
      const std::string angle = fmt::format("{}_deg", name);
      const double error = std::remainder(at(solution, angle, t) - truth[angle][i], 360.0);
      add(name, error, "sigma_" + angle);
      result.largest_angle = std::max(result.largest_angle, std::abs(error));
    }
  }
  const auto count = static_cast<double>(result.epochs);
  const auto rmse = [&](std::string_view name) { return std::sqrt(sums.find(name)->second.squares / count); };
  const auto claimed = [&](std::string_view name) { return std::sqrt(sums.find(name)->second.variance / count); };
  const auto nees = [&](std::initializer_list<std::string_view> names) {
    double sum = 0;
    for (const auto name : names) sum += sums.find(name)->second.normalised / (3 * count);
    return sum;
  };
  const auto outside = [&](std::initializer_list<std::string_view> names) {
    double worst = 0;
    for (const auto name : names) worst = std::max(worst, sums.find(name)->second.outside / count);
    return worst;
  };
  if (result.epochs == 0) {
    ADD_FAILURE() << "no epoch in common with the truth";
    return result;
  }
  result.roll = rmse("roll");
  result.pitch = rmse("pitch");
  result.heading = rmse("heading");
  result.horizontal = std::hypot(rmse("north"), rmse("east"));
  result.down = rmse("down");
  result.velocity = std::max({rmse("velocity_north_m_s"), rmse("velocity_east_m_s"), rmse("velocity_down_m_s")});
  result.claimed_euler = {claimed("roll"), claimed("pitch"), claimed("heading")};
  result.claimed_horizontal = std::hypot(claimed("north"), claimed("east"));
  result.attitude_nees = nees({"roll", "pitch", "heading"});
  result.velocity_nees = nees({"velocity_north_m_s", "velocity_east_m_s", "velocity_down_m_s"});
  result.attitude_outside = outside({"roll", "pitch", "heading"});
  result.velocity_outside = outside({"velocity_north_m_s", "velocity_east_m_s", "velocity_down_m_s"});
  result.position_outside = outside({"north", "east", "down"});
  return result;
}

/// Over several runs of equal length: root mean squares of errors and sigmas, means of shares and NEES.
inline Accuracy pooled(std::span<const Accuracy> runs) {
  Accuracy all;
  const auto n = static_cast<double>(runs.size());
  const auto mean = [&](const auto& value) {
    double sum = 0;
    for (const Accuracy& a : runs) sum += value(a) / n;
    return sum;
  };
  for (const auto member : {&Accuracy::roll, &Accuracy::pitch, &Accuracy::heading, &Accuracy::horizontal,
                            &Accuracy::down, &Accuracy::velocity, &Accuracy::claimed_horizontal}) {
    all.*member = std::sqrt(mean([&](const Accuracy& a) { return a.*member * a.*member; }));
  }
  for (int i = 0; i < 3; ++i) {
    all.claimed_euler(i) = std::sqrt(mean([&](const Accuracy& a) { return a.claimed_euler(i) * a.claimed_euler(i); }));
  }
  for (const auto member : {&Accuracy::attitude_nees, &Accuracy::velocity_nees, &Accuracy::attitude_outside,
                            &Accuracy::velocity_outside, &Accuracy::position_outside}) {
    all.*member = mean([&](const Accuracy& a) { return a.*member; });
  }
  for (const Accuracy& a : runs) {
    all.largest_angle = std::max(all.largest_angle, a.largest_angle);
    all.largest_horizontal = std::max(all.largest_horizontal, a.largest_horizontal);
    all.epochs += a.epochs;
  }
  return all;
}

inline std::string text_of(const Accuracy& a) {
  return fmt::format(
      "roll {:.3f} pitch {:.3f} heading {:.3f} deg, horizontal {:.4f} down {:.4f} m, velocity {:.4f} m/s; "
      "beyond 3 sigma: attitude {:.1f} %, velocity {:.1f} %, position {:.1f} %; "
      "claimed: roll {:.3f} pitch {:.3f} heading {:.3f} deg, horizontal {:.4f} m; NEES of attitude {:.2f}, velocity "
      "{:.2f}",
      a.roll, a.pitch, a.heading, a.horizontal, a.down, a.velocity, 100 * a.attitude_outside, 100 * a.velocity_outside,
      100 * a.position_outside, a.claimed_euler.x(), a.claimed_euler.y(), a.claimed_euler.z(), a.claimed_horizontal,
      a.attitude_nees, a.velocity_nees);
}

}  // namespace piste::test
