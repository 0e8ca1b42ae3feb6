#include "piste/report/study_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "piste/study/missing.h"
#include "piste/study/ranking.h"
#include "piste/study/study_tables.h"

namespace piste {
namespace {

std::string trimmed(std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

// Value and spread with as many decimals as are significant.
std::string spread_text(const Across& v) {
  const double size = std::isfinite(v.std) ? v.std : v.standard_error;
  const int decimals = size > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(size))), 0, 9) : 6;
  return fmt::format("{:.{}f} ± {:.{}f}{}", v.mean, decimals, size, decimals, v.significant ? " *" : "");
}

std::string biases_of(const Study& study) {
  const auto rows = table_of(study, Method::kRest, StudyQuantity::kBias);
  std::string out;
  for (std::size_t sensor = 0; sensor < study.sensors.size(); ++sensor) {
    std::string line = fmt::format("{:<12}", study.sensors[sensor]);
    for (int axis = 0; axis < kSignals; ++axis) {
      const auto row =
          std::ranges::find_if(rows, [&](const AcrossRow& r) { return r.sensor == sensor && r.axis == axis; });
      line += fmt::format("{:<20}", row == rows.end() ? "-" : spread_text(row->value));
    }
    out += trimmed(line);
  }
  return out;
}

std::string biases_text(const Study& study) {
  std::string head = fmt::format("{:<12}", "");
  for (int axis = 0; axis < kSignals; ++axis) {
    head += fmt::format("{:<20}", fmt::format("{} {}", signal_info(axis).name, signal_info(axis).unit));
  }
  std::string out = trimmed(head) + biases_of(study);
  if (!study.as_one.empty()) out += biases_of(of_all_as_one(study));
  return out;
}

std::string ranking_text(const Study& study) {
  const Ranking found = ranking(study);
  if (!found.winner) return "";
  const std::vector<std::string> said = remarks(study, found);
  std::string out = fmt::format("{:<32}{:>7}{:>12}{:>14}{:>14}{:>11}\n", "errors fed to a replay", "score",
                                "position m", "velocity m/s", "attitude deg", "outage m");
  for (std::size_t i = 0; i < found.rows.size(); ++i) {
    const RankingRow& r = found.rows[i];
    out += trimmed(fmt::format("{:<32}{:>7.3f}{:>12.3f}{:>14.3f}{:>14.3f}{:>11.2f}  {}", info(r.method).name, r.score,
                               r.position_rmse, r.velocity_rmse, kDegreesPerRadian * r.attitude_rmse, r.outage_drift,
                               said[i]));
  }
  return out;
}

std::string imus_text(const Study& study) {
  const std::vector<ImuCompared> rows = imus_compared(study);
  if (rows.empty()) return "";
  std::string out = fmt::format("{:<32}{:>7}{:>12}{:>14}{:>14}{:>11}\n", "each IMU, errors estimated", "runs",
                                "position m", "velocity m/s", "attitude deg", "outage m");
  for (const ImuCompared& r : rows) {
    const auto drift = std::isfinite(r.outage_drift) ? fmt::format("{:.2f}", r.outage_drift) : std::string("-");
    out += fmt::format("{:<32}{:>7}{:>12.3f}{:>14.3f}{:>14.3f}{:>11}", r.name, r.runs, r.position_rmse, r.velocity_rmse,
                       kDegreesPerRadian * r.attitude_rmse, drift);
    if (std::isfinite(r.attitude_over_single)) {
      out += fmt::format("  attitude {:.2f} of the mean of the single ones", r.attitude_over_single);
    }
    if (std::isfinite(r.drift_over_single)) out += fmt::format(", drift {:.2f}", r.drift_over_single);
    out += "\n";
  }
  return out;
}

}  // namespace

std::string study_text(const Study& study) {
  const auto well = std::ranges::count_if(study.results, [](const SensorRun& r) { return r.failure.empty(); });
  std::string out = fmt::format("{}: {} IMUs in {} runs, {} of {} went well; low-pass {:g} Hz{}\n", study.name,
                                study.sensors.size(), study.runs.size(), well, study.sensors.size() * study.runs.size(),
                                study.low_pass, study.simulated ? "; simulated, so that the truth is known" : "");
  for (const std::string& m : missing(study)) out += "  " + m + "\n";
  if (const std::string table = ranking_text(study); !table.empty()) out += "\n" + table;
  if (const std::string table = imus_text(study); !table.empty()) out += "\n" + table;
  out += "\nBias at rest before the start, a correction to add: mean ± spread between the runs; * significant\n";
  return out + biases_text(study);
}

}  // namespace piste
