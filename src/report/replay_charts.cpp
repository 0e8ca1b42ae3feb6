#include "report/replay_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

#include "core/time_search.h"
#include "io/quantity.h"
#include "io/row_rate.h"
#include "piste/io/solution_io.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/model/measurement_list.h"
#include "piste/model/strapdown.h"
#include "piste/replay/replay.h"
#include "report/packed_table.h"

namespace piste::page {
namespace {

constexpr std::array kLocalAxes{"north", "east", "down"};
constexpr std::array kEulerAxes{"roll", "pitch", "heading"};
constexpr std::array kBodyAxes{"x", "y", "z"};
constexpr double kMetreStep = 1e-5, kDegreeStep = 1e-7, kOtherStep = 1e-8;  // the last decimals of the files
constexpr double kTimeStep = 1e-6;
constexpr double kWholeTurn = 360;
constexpr std::size_t kBiasRows = 12000;

std::string words(std::string_view name) {
  std::string text(name);
  std::replace(text.begin(), text.end(), '_', ' ');
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

double finest(std::string_view column) {
  if (column.ends_with("_deg")) return kDegreeStep;
  return column.ends_with("_m") || column.ends_with("_m_s") ? kMetreStep : kOtherStep;
}

std::vector<double> column_of(const NumberTable& table, std::size_t column) {
  std::vector<double> out;
  for (std::size_t at = column; at < table.values.size(); at += table.names.size()) out.push_back(table.values[at]);
  return out;
}

// Adds the columns of a table but for latitude and longitude: values in steps of their sigmas.
void pack(PackedTable& packed, const NumberTable& table) {
  for (std::size_t k = 0; k < table.names.size(); ++k) {
    const std::string& name = table.names[k];
    if (name == "latitude_deg" || name == "longitude_deg") continue;
    const std::vector<double> values = column_of(table, k);
    if (name.starts_with("sigma_")) {
      packed.add_sigma(name, values);
      continue;
    }
    const std::string of_height = name == "height_m" ? "sigma_down_m" : "sigma_" + name;
    const auto sigma = std::ranges::find(table.names, of_height);
    const double step =
        name == "time_s" ? kTimeStep
        : sigma == table.names.end()
            ? finest(name)
            : step_below(column_of(table, static_cast<std::size_t>(sigma - table.names.begin())), finest(name));
    packed.add(name, values, step);
  }
}

/// The rows that the page has.
Solution thinned(const Solution& solution, double rate) {
  Solution out(solution.layout(), solution.world());
  out.fixed = solution.fixed;
  for (const std::size_t i : shown_rows(solution, rate)) out.append(solution.row(i));
  return out;
}

std::string navigation(const Solution& rows) {
  PackedTable packed;
  const NumberTable table = navigation_table(rows);
  pack(packed, table);
  const std::vector<double> times = column_of(table, 0);
  std::array<std::vector<double>, 2> place, sigma;
  std::size_t i = 0;
  for (const double time : times) {
    while (rows.time(i) < time) ++i;
    const Vector3d p = rows.position(i), s = rows.navigation_sigmas(i).position;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      place[axis].push_back(p[static_cast<Eigen::Index>(axis)]);
      sigma[axis].push_back(s[static_cast<Eigen::Index>(axis)]);
    }
  }
  packed.add("north_m", place[0], step_below(sigma[0], kMetreStep));
  packed.add("east_m", place[1], step_below(sigma[1], kMetreStep));
  return packed.json();
}

// A rate [Hz] at which there are not too many rows: at most the stated one.
double bias_rate(const Solution& rows, double stated) {
  const double length = rows.time(rows.size() - 1) - rows.time(0), most = kBiasRows / std::max(length, 1.0);
  return stated > 0 ? std::min(stated, most) : most;
}

std::string biases(const Solution& rows, double rate) {
  PackedTable packed;
  pack(packed, biases_table(rows, bias_rate(rows, rate)));
  return packed.json();
}

constexpr std::size_t kSignals = 6;

std::string signal_name(std::size_t k) { return fmt::format("{}_{}", k < 3 ? "rate" : "force", kBodyAxes[k % 3]); }

/// Corrected rate and force of the body.
void add_signals(Data& data, const Log& log, const Solution& solution) {
  if (log.imu.empty()) return;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < kSignals; ++k) names.push_back(signal_name(k));
  Envelope envelope(std::move(names), log.imu.size());
  std::size_t row = 0, last = solution.size();  // of the estimate that is at hand
  Estimate x;
  for (const ImuSample& s : log.imu) {
    while (row + 1 < solution.size() && solution.time(row) < s.time) ++row;
    if (row != last) x = solution.estimate(row);
    last = row;
    const ImuStep step = correct({s.interval, s.dtheta, s.dvel, Vector3d::Zero(), Vector3d::Zero()}, x);
    Eigen::Matrix<double, kSignals, 1> now;
    now << kDegreesPerRadian * step.dtheta / s.interval, step.dvel / s.interval;
    envelope.add(s.time, {now.data(), kSignals});
  }
  data.tables.emplace_back("motion", envelope.json());
  for (const bool rate : {true, false}) {
    Chart chart{.name = rate ? "angular_rate" : "specific_force",
                .title = rate ? "Angular rate of the body" : "Specific force on the body",
                .unit = rate ? "deg/s" : "m/s²",
                .group = "motion",
                .table = "motion",
                .curves = {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      chart.curves.push_back(
          envelope_curve(kBodyAxes[axis], signal_name(axis + (rate ? 0U : 3U)), envelope.has_extremes()));
    }
    data.charts.push_back(std::move(chart));
  }
}

// The fix behind an innovation of a receiver's position; null for others.
const GnssFix* fix_of(const Log& log, std::string_view source, const Innovation& v) {
  for (std::size_t k = 0; k < log.gnss.size(); ++k) {
    if (source != fmt::format("gnss[{}].position", k)) continue;
    const double stated = v.time + v.late;
    const auto fix = first_at_or_after(log.gnss[k], stated - kTimeStep);
    if (fix != log.gnss[k].end() && fix->time <= stated + kTimeStep) return &*fix;
  }
  return nullptr;
}

// The unit of a source's residuals in innovations.csv.
std::string unit_of(std::string_view source) {
  if (source.ends_with(".position") || source == "barometer") return "m";
  if (source.ends_with("velocity") || source.starts_with("vehicle") || source == "odometer") return "m/s";
  if (source.starts_with("attitude") || source == "heading") return "rad";
  return source == "rest.rate" ? "rad/s" : "SI";
}

/// The innovations of one source.
class Residuals {
 public:
  Residuals(const ReplayReport& report, std::size_t source) : name_(report.filtered->sources[source]) {
    const auto index = static_cast<int>(source);
    for (const Innovation& v : report.filtered->innovations) {
      if (v.source == index) add(v, fix_of(*report.log, name_, v));
    }
  }
  bool empty() const { return time_.empty(); }
  // Whether its log states them.
  bool has_quality() const { return any(quality_); }
  bool has_satellites() const { return any(satellites_); }

  std::string json() const {
    PackedTable packed;
    packed.add("time_s", time_, kTimeStep);
    for (std::size_t k = 0; k < rows(); ++k) {
      packed.add(fmt::format("residual_{}", k + 1), residual_[k], step_below(sigma_[k], kOtherStep));
      packed.add_sigma(fmt::format("sigma_{}", k + 1), sigma_[k]);
    }
    packed.add_sigma("nis", nis_);
    packed.add_sigma("gate", gate_);
    packed.add("outcome", outcome_, 1);
    packed.add("rows", dof_, 1);
    if (placed_) {
      packed.add("north_m", north_, kMetreStep);
      packed.add("east_m", east_, kMetreStep);
    }
    if (has_quality()) packed.add("quality", quality_, 1);
    if (has_satellites()) packed.add("satellites", satellites_, 1);
    return packed.json();
  }

  /// Residuals in their own unit and in sigmas, and NIS.
  std::vector<Chart> charts(const std::string& table) const {
    const auto axes = innovation_axes(name_);
    Chart plain{.name = "residual_" + name_,
                .title = name_ + ": residual",
                .unit = "",
                .group = "residuals",
                .table = table,
                .curves = {},
                .points = true};
    Chart ratio = plain;
    ratio.name = "ratio_" + name_;
    ratio.title = name_ + ": residual over its sigma";
    for (std::size_t k = 0; k < std::min<std::size_t>(rows(), axes.size()); ++k) {
      const std::string column = fmt::format("residual_{}", k + 1), sigma = fmt::format("sigma_{}", k + 1);
      plain.curves.push_back({.label = std::string(axes[k]), .value = column});
      ratio.curves.push_back({.label = std::string(axes[k]), .value = fmt::format("over:{},{}", column, sigma)});
    }
    plain.unit = unit_of(name_);
    Chart nis{.name = "nis_" + name_,
              .title = name_ + ": NIS over its number of rows",
              .unit = "",
              .group = "residuals",
              .table = table,
              .curves = {{.label = "NIS", .value = "over:nis,rows"}, {.label = "gate", .value = "over:gate,rows"}},
              .points = true,
              .log = true};
    return {plain, ratio, nis};
  }

 private:
  std::size_t rows() const { return rows_; }
  static bool any(const std::vector<double>& values) {
    return std::ranges::any_of(values, [](double v) { return std::isfinite(v); });
  }
  void add(const Innovation& v, const GnssFix* fix) {
    time_.push_back(v.time);
    for (int k = 0; k < 3; ++k) {
      const auto row = static_cast<std::size_t>(k);
      residual_[row].push_back(v.has(k) ? v.residual[k] : kNaN);
      sigma_[row].push_back(v.has(k) ? v.sigma[k] : kNaN);
      if (v.has(k)) rows_ = std::max(rows_, row + 1);
    }
    nis_.push_back(v.outcome == Outcome::kRepeated ? kNaN : v.nis);
    gate_.push_back(v.gate > 0 ? v.gate : kNaN);
    outcome_.push_back(static_cast<double>(v.outcome));
    dof_.push_back(v.dof);
    north_.push_back(fix != nullptr ? fix->position.x() : kNaN);
    east_.push_back(fix != nullptr ? fix->position.y() : kNaN);
    placed_ = placed_ || fix != nullptr;
    const bool kind = fix != nullptr && fix->quality != FixQuality::kUnknown;
    quality_.push_back(kind ? static_cast<double>(fix->quality) : kNaN);
    satellites_.push_back(fix != nullptr && fix->satellites > 0 ? fix->satellites : kNaN);
  }
  std::string name_;
  std::size_t rows_ = 0;
  bool placed_ = false;
  std::vector<double> time_, nis_, gate_, outcome_, dof_, north_, east_, quality_, satellites_;
  std::array<std::vector<double>, 3> residual_, sigma_;
};

Chart one(std::string name, std::string title, std::string unit, std::string group, Curve curve) {
  return {.name = std::move(name),
          .title = std::move(title),
          .unit = std::move(unit),
          .group = std::move(group),
          .table = "solution",
          .curves = {std::move(curve)}};
}

// A quantity of the solution: its column and that of its sigma, and how charts of it are named.
struct Shown {
  std::string name, title, unit, column, sigma;
  double turn = 0;
};

std::vector<Shown> navigation_quantities() {
  std::vector<Shown> out{{"height", "Height above the ellipsoid", "m", "height_m", "sigma_down_m"}};
  for (const char* axis : kLocalAxes) {
    const std::string name = fmt::format("velocity_{}", axis);
    out.push_back({name, fmt::format("Velocity {}", axis), "m/s", name + "_m_s", fmt::format("sigma_{}_m_s", name)});
  }
  for (const char* axis : kEulerAxes) {
    out.push_back({axis, words(axis), "deg", fmt::format("{}_deg", axis), fmt::format("sigma_{}_deg", axis),
                   std::string_view(axis) == "pitch" ? 0 : kWholeTurn});
  }
  return out;
}

void add_motion(std::vector<Chart>& charts) {
  charts.push_back(one("height", "Height above the ellipsoid", "m", "",
                       {.label = "height", .value = "height_m", .sigma = "sigma_down_m"}));
  charts.push_back(one("speed", "Speed", "m/s", "",
                       {.label = "speed", .value = "hypot:velocity_north_m_s,velocity_east_m_s,velocity_down_m_s"}));
  for (const Shown& q : navigation_quantities()) {
    if (q.name == "height") continue;
    charts.push_back(one(q.name, q.title, q.unit, "motion", {.label = q.name, .value = q.column, .sigma = q.sigma}));
    charts.back().turn = q.turn;
  }
}

// Whether a sigma is below a hundredth of the range: only then the curve hides its band.
bool hides_band(const Solution& solution, const Shown& q) {
  constexpr double kPart = 0.01;
  const NumberTable table = navigation_table(solution);
  const auto of = [&](const std::string& name) {
    return column_of(table, static_cast<std::size_t>(std::ranges::find(table.names, name) - table.names.begin()));
  };
  std::vector<double> sigma = of(q.sigma);
  const std::vector<double> value = of(q.column);
  const auto [low, high] = std::ranges::minmax_element(value);
  return median(std::move(sigma)) < kPart * (*high - *low);
}

void add_accuracy(std::vector<Chart>& charts, const Solution& solution) {
  const auto sigmas = [&](std::string name, std::string title, std::string unit, const auto& axes,
                          std::string_view form) {
    Chart chart = one(std::move(name), std::move(title), std::move(unit), "accuracy", {});
    chart.curves.clear();
    for (const char* axis : axes)
      chart.curves.push_back({.label = axis, .value = fmt::format(fmt::runtime(form), axis)});
    chart.log = true;
    charts.push_back(std::move(chart));
  };
  sigmas("sigma_of_position", "Sigma of position", "m", kLocalAxes, "sigma_{}_m");
  sigmas("sigma_of_velocity", "Sigma of velocity", "m/s", kLocalAxes, "sigma_velocity_{}_m_s");
  sigmas("sigma_of_attitude", "Sigma of attitude", "deg", kEulerAxes, "sigma_{}_deg");
  for (const Shown& q : navigation_quantities()) {
    if (!hides_band(solution, q)) continue;
    charts.push_back(one("detail_of_" + q.name, q.title + ", less its running mean", q.unit, "accuracy",
                         {.label = q.name, .value = "detail:" + q.column, .sigma = q.sigma}));
    charts.back().turn = q.turn;
  }
}

void add_changes(std::vector<Chart>& charts) {
  for (const Shown& q : navigation_quantities()) {
    charts.push_back(one("change_of_" + q.name, q.title + ": filtered less smoothed", q.unit, "changes",
                         {.label = q.name, .value = "change:" + q.column, .sigma = "filtered:" + q.sigma}));
    charts.back().turn = q.turn;
  }
}

// ± the prior of a constant, if all of its axes have the same.
std::vector<double> prior_levels(const ReplayReport& report, const Quantity& q) {
  const BlockInfo& row = info(q.block);
  if (report.options == nullptr || q.total || row.prior == nullptr) return {};
  const BlockValues prior = row.factor * row.prior(*report.options),
                    value = row.factor * stated_value(*report.options, q.block);
  for (int k = 1; k < row.size; ++k) {
    if (prior[k] != prior[0] || value[k] != value[0]) return {};
  }
  return {value[0] - prior[0], value[0] + prior[0]};
}

void add_biases(std::vector<Chart>& charts, const ReplayReport& report, const NumberTable& first_row) {
  std::size_t column = 1;
  for (const Quantity& q : quantities_of(best_of(report).layout())) {
    const BlockInfo& row = info(q.block);
    const auto size = static_cast<std::size_t>(q.size());
    Chart chart{.name = "estimate_of_" + q.name,
                .title = words(q.name),
                .unit = std::string(row.unit),
                .group = "errors",
                .table = "biases",
                .curves = {},
                .levels = prior_levels(report, q)};
    for (std::size_t k = 0; k < size; ++k) {
      chart.curves.push_back({.label = std::string(row.axes[k]),
                              .value = first_row.names[column + k],
                              .sigma = first_row.names[column + size + k]});
    }
    column += 2 * size;
    charts.push_back(std::move(chart));
  }
}

// The noise that an adapting filter estimated.
void add_adapted(Data& data, const AdaptedNoise& adapted) {
  if (adapted.names.empty()) return;
  PackedTable packed;
  packed.add("time_s", adapted.time, kTimeStep);
  Chart chart{.name = "learned_noise",
              .title = "Learned noise, over the stated",
              .unit = "",
              .group = "residuals",
              .table = "adapted",
              .curves = {},
              .log = true};
  for (std::size_t k = 0; k < adapted.names.size(); ++k) {
    std::vector<double> factors;
    for (std::size_t row = 0; row < adapted.time.size(); ++row) factors.push_back(adapted.factor(row, k));
    packed.add_sigma(adapted.names[k], factors);
    chart.curves.push_back({.label = adapted.names[k], .value = adapted.names[k]});
  }
  data.tables.emplace_back("adapted", packed.json());
  data.charts.push_back(std::move(chart));
}

}  // namespace

std::vector<std::size_t> shown_rows(const Solution& solution, double rate) {
  const std::vector<std::size_t> at_rate = rows_at(solution, rate);
  std::vector<std::size_t> out;
  const std::size_t every = rows_apart(at_rate.size());
  for (std::size_t k = 0; k < at_rate.size(); k += every) out.push_back(at_rate[k]);
  return out;
}

Data replay_data(const ReplayReport& report) {
  const Solution& best = best_of(report);
  Data data;
  data.rest = report.log->rest;
  data.outages = report.outages;
  data.sources = report.filtered->sources;
  data.groups = {
      {"motion", "Motion", "Rate and force are those of the body, corrected for the estimated errors.", true},
      {"accuracy", "Accuracy",
       "Where a sigma is too small to be seen next to its curve, the curve is shown less its running mean."},
      {"changes", "Filter less smoother", "What the later fixes changed, with the filter's sigma."},
      {"residuals", "Residuals",
       "Measured less predicted, of the filter. NIS over its number of rows should be 1 in the mean; what is beyond "
       "the gate is rejected."},
      {"errors", "Errors of the IMU and other estimates", "With 1-sigma bands. Dashed: ± the prior."},
      {"sources", "Sources",
       "A strip for each source: what became of its measurements; kind and satellites of fixes, where a log states "
       "them."}};
  if (best.empty()) return data;
  data.start = best.time(0);
  data.end = best.time(best.size() - 1);
  data.origin = best.world().origin();
  data.week = report.week;
  const auto add_solution = [&](const std::string& name, const Solution& solution) {
    const Solution rows = thinned(solution, report.rate);
    data.tables.emplace_back(name, navigation(rows));
    data.tables.emplace_back("biases_" + name, biases(rows, report.bias_rate));
  };
  if (report.smoothed != nullptr) add_solution("smoothed", *report.smoothed);
  add_solution("filtered", *report.filtered);
  add_motion(data.charts);
  add_signals(data, *report.log, best);
  add_accuracy(data.charts, best);
  if (report.smoothed != nullptr) add_changes(data.charts);
  bool with_quality = false;
  Chart satellites{.name = "satellites",
                   .title = "Satellites of each fix",
                   .unit = "",
                   .group = "sources",
                   .table = "",
                   .curves = {}};
  for (std::size_t k = 0; k < report.filtered->sources.size(); ++k) {
    const Residuals residuals(report, k);
    if (residuals.empty()) continue;
    const std::string table = fmt::format("source_{}", k);
    with_quality = with_quality || residuals.has_quality();
    if (residuals.has_satellites()) {
      satellites.curves.push_back({.label = report.filtered->sources[k], .value = "satellites", .table = table});
    }
    data.tables.emplace_back(table, residuals.json());
    for (Chart& chart : residuals.charts(table)) data.charts.push_back(std::move(chart));
  }
  add_adapted(data, report.filtered->adapted);
  Solution first(best.layout(), best.world());
  first.fixed = best.fixed;
  first.append(best.row(0));
  add_biases(data.charts, report, biases_table(first));
  const auto strip = [&data](const char* name, const char* title, const char* table) {
    data.charts.push_back(
        {.name = name, .title = title, .unit = "", .group = "sources", .table = table, .curves = {}, .points = true});
  };
  strip("outcome", "Outcome of every measurement", "sources");
  if (with_quality) strip("quality", "Kind of every fix, as its receiver states it", "qualities");
  if (!satellites.curves.empty()) {
    satellites.table = satellites.curves.front().table;
    data.charts.push_back(std::move(satellites));
  }
  return data;
}

}  // namespace piste::page
