#include "files/points.h"

#include <fmt/format.h>

#include <array>

#include "io/row_rate.h"
#include "piste/io/solution_io.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr std::array<std::string_view, 9> kCovarianceAxes{
    "north_m",           "east_m",   "down_m",    "velocity_north_m_s", "velocity_east_m_s",
    "velocity_down_m_s", "roll_deg", "pitch_deg", "heading_deg"};

std::string covariance_head() {
  std::string text = "time_s";
  for (std::size_t i = 0; i < 9; ++i) {
    for (std::size_t k = i; k < 9; ++k)
      text += fmt::format(",covariance_{}_{}", kCovarianceAxes[i], kCovarianceAxes[k]);
  }
  return text + "\n";
}

// The upper triangle, row by row; angles in degrees.
std::string covariance_row(const PlacedPoint& point) {
  std::string text = fmt::format("{:.6f}", point.time);
  for (int i = 0; i < 9; ++i) {
    for (int k = i; k < 9; ++k) {
      const double factor = (i < 6 ? 1 : kDegreesPerRadian) * (k < 6 ? 1 : kDegreesPerRadian);
      fmt::format_to(std::back_inserter(text), ",{:.9g}", factor * point.covariance(i, k));
    }
  }
  return text + "\n";
}

std::string join_backwards(const std::string& head, const std::vector<std::string>& rows) {
  std::string text = head;
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) text += *row;
  return text;
}

}  // namespace

void write_points(OutputFolder& output, const Replay& run, const ReplayConfig& config, const RowExtras& extras) {
  const std::vector<OutputPoint>& points = config.output.points;
  if (points.empty() && !config.output.covariance) return;
  const std::string stem = run.smoothed ? "smoothed" : "filtered";
  // A solution of each point takes the columns of smoothed.csv, and is filled from its end.
  const std::vector<std::size_t> rows = rows_at(run.solution(), config.rates.navigation);
  std::vector<std::vector<PlacedPoint>> placed(points.size());
  std::vector<std::string> covariances;
  placed_rows(run, rows, [&](std::size_t, const PlacedState& state) {
    for (std::size_t i = 0; i < points.size(); ++i) placed[i].push_back(place(run.log.world, state, points[i]));
    if (config.output.covariance) covariances.push_back(covariance_row(place(run.log.world, state, {})));
  });
  for (std::size_t i = 0; i < points.size(); ++i) {
    output.stream(fmt::format("{}_{}.csv", stem, points[i].name), [&](const TextSink& sink) {
      RowExtras own = extras;  // those of a place; a rate is that of the body
      own.acceleration = own.rates = false;
      PlaceCsv csv(own, run.log.world, sink);
      for (auto point = placed[i].rbegin(); point != placed[i].rend(); ++point) {
        csv.add(point->time, point->navigation, sigmas_of(*point));
      }
      csv.finish();
    });
  }
  if (config.output.covariance) {
    output.write(fmt::format("covariance_{}.csv", stem), join_backwards(covariance_head(), covariances));
  }
}

}  // namespace piste
