#include "report/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>

#include "io/json.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/model/measurement_list.h"
#include "plot/thin.h"

namespace piste::charts {
namespace {

constexpr std::array<const char*, 3> kLocalAxes{"north", "east", "down"};
constexpr std::array<const char*, 3> kEulerAxes{"roll", "pitch", "heading"};
constexpr std::size_t kAngles = kEulerAxes.size();

/// A chart that takes one row at a time, with sigmas or without.
class Builder {
 public:
  Builder(std::string title, std::string unit, std::vector<std::string> labels) {
    chart_.title = std::move(title);
    chart_.unit = std::move(unit);
    for (auto& label : labels) chart_.curves.push_back({std::move(label), {}});
  }
  void add(double time, const Eigen::Ref<const Eigen::VectorXd>& value) {
    chart_.time.push_back(time);
    for (std::size_t k = 0; k < chart_.curves.size(); ++k) {
      chart_.curves[k].value.push_back(value[static_cast<Eigen::Index>(k)]);
    }
  }
  void add(double time, const Eigen::Ref<const Eigen::VectorXd>& value,
           const Eigen::Ref<const Eigen::VectorXd>& sigma) {
    add(time, value);
    for (std::size_t k = 0; k < chart_.curves.size(); ++k) {
      chart_.curves[k].sigma.push_back(sigma[static_cast<Eigen::Index>(k)]);
    }
  }
  Chart& chart() { return chart_; }

 private:
  Chart chart_;
};

Builder three(std::string title, std::string unit, const std::array<const char*, 3>& axes) {
  return {std::move(title), std::move(unit), {axes[0], axes[1], axes[2]}};
}

std::string words(std::string_view name) {
  std::string text(name);
  std::replace(text.begin(), text.end(), '_', ' ');
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

/// Unwraps an angle beyond ± 180 deg, up to ± 200 deg. There the curve breaks and continues a turn nearer to 0. The
/// margin keeps a curve near 180 deg in one piece. At a break the chart gets a row without a value.
void break_turns(Chart& chart) {
  constexpr double kFurthest = 200, kTurn = 360;
  Curve& angle = chart.curves.front();
  Chart out = chart;
  out.time.clear();
  Curve& shown = out.curves.front();
  shown.value.clear();
  shown.sigma.clear();
  double turns = 0;
  for (std::size_t i = 0; i < chart.time.size(); ++i) {
    if (i > 0) turns += kTurn * std::round((angle.value[i - 1] - angle.value[i]) / kTurn);
    if (std::abs(angle.value[i] + turns) > kFurthest) {
      turns -= kTurn * std::round((angle.value[i] + turns) / kTurn);
      if (i > 0) {
        out.time.push_back((chart.time[i - 1] + chart.time[i]) / 2);
        shown.value.push_back(kNaN);
        shown.sigma.push_back(kNaN);
      }
    }
    out.time.push_back(chart.time[i]);
    shown.value.push_back(angle.value[i] + turns);
    shown.sigma.push_back(angle.sigma[i]);
  }
  chart = std::move(out);
}

/// Whether there is nothing to see: on a logarithmic scale only values above zero are visible.
bool shows_nothing(const Chart& chart) {
  return std::all_of(chart.curves.begin(), chart.curves.end(), [&](const Curve& c) {
    return std::none_of(c.value.begin(), c.value.end(),
                        [&](double v) { return std::isfinite(v) && (v > 0 || !chart.log_scale); });
  });
}

/// Digits of the largest value with which steps are invisible. A step is a tenth of the least sigma, or a
/// hundred-thousandth of the curve's range if that is less, but at least a thousandth of the sigma.
int digits_of(const Curve& curve) {
  constexpr int kFewest = 5, kMost = 12;
  double largest = 0, low = kNaN, high = kNaN, sigma = kNaN;
  for (const double v : curve.value) {
    if (!std::isfinite(v)) continue;
    largest = std::max(largest, std::abs(v));
    low = std::fmin(low, v);
    high = std::fmax(high, v);
  }
  for (const double s : curve.sigma) {
    if (s > 0) sigma = std::fmin(sigma, s);
  }
  const double step = std::fmax(std::fmin(1e-5 * (high - low), 0.1 * sigma), 1e-3 * sigma);
  if (!(step > 0) || largest == 0) return kFewest;
  return std::clamp(static_cast<int>(std::ceil(std::log10(largest / step))), kFewest, kMost);
}

/// Distance of the epochs that are converted, before thinning: of an hour at 100 Hz every eighth. Events between them
/// last less than 0.1 s.
std::size_t epochs_apart(const Solution& solution) {
  constexpr std::size_t kEpochs = 40000;
  return 1 + solution.size() / kEpochs;
}

Builder block_builder(Block block) {
  const BlockInfo& row = info(block);
  std::vector<std::string> labels;
  labels.reserve(static_cast<std::size_t>(row.size));
  for (int i = 0; i < row.size; ++i) labels.emplace_back(row.axes[static_cast<std::size_t>(i)]);
  return {words(row.name), std::string(row.unit), std::move(labels)};
}

Eigen::VectorXd block_value(const Estimate& x, Block block) {
  return info(block).factor * shown_value(x, block).head(info(block).size);
}

/// Whether bias and drift are both estimated. Only then is their sum shown.
bool has_total(const StateLayout& layout, Block bias, Block drift) { return layout.has(bias) && layout.has(drift); }

/// The noise that an adapting filter estimated.
Chart of_adapted(const AdaptedNoise& adapted, double start) {
  Builder factors("Learned noise, over the stated", "", adapted.names);
  const auto count = static_cast<Eigen::Index>(adapted.names.size());
  for (std::size_t row = 0; row < adapted.time.size(); ++row) {
    factors.add(adapted.time[row] - start,
                Eigen::Map<const Eigen::VectorXd>(adapted.factors.data() + row * adapted.names.size(), count));
  }
  factors.chart().log_scale = true;
  return std::move(factors.chart());
}

}  // namespace

std::vector<Chart> of_solution(const Solution& solution, double start) {
  const StateLayout& layout = solution.layout();
  Builder speed("Speed", "m/s", {"speed"});
  Builder height("Height above the ellipsoid", "m", {"height"});
  // One chart for each angle: a heading that turns would flatten the others.
  std::vector<Builder> attitude{{"Attitude: roll", "deg", {"roll"}},
                                {"Attitude: pitch", "deg", {"pitch"}},
                                {"Attitude: heading", "deg", {"heading"}}};
  Builder velocity = three("Velocity", "m/s", kLocalAxes);
  Builder sigma_position = three("Sigma of position", "m", kLocalAxes);
  Builder sigma_velocity = three("Sigma of velocity", "m/s", kLocalAxes);
  Builder sigma_attitude = three("Sigma of attitude", "deg", kEulerAxes);
  Builder gyro_total = three("Gyro bias and drift together", "deg/s", {"x", "y", "z"});
  Builder accel_total = three("Accel bias and drift together", "m/s^2", {"x", "y", "z"});
  std::vector<Block> blocks;
  std::vector<Builder> block_charts;
  for (const Block block : layout.blocks()) {
    if (is_navigation(block)) continue;
    blocks.push_back(block);
    block_charts.push_back(block_builder(block));
  }
  const std::size_t every = epochs_apart(solution);
  for (std::size_t i = 0; i < solution.size(); i += every) {
    const double t = solution.time(i) - start;
    const Estimate x = solution.estimate(i);
    const Sigmas s = solution.sigmas(i);
    const auto navigation = solution.navigation(i);
    speed.add(t, Eigen::Matrix<double, 1, 1>(navigation.velocity.norm()));
    height.add(t, Eigen::Matrix<double, 1, 1>(navigation.position.height), s.position.tail<1>());
    for (std::size_t k = 0; k < kAngles; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      attitude[k].add(t, kDegreesPerRadian * navigation.euler.segment<1>(axis),
                      kDegreesPerRadian * s.euler.segment<1>(axis));
    }
    velocity.add(t, navigation.velocity, s.velocity);
    sigma_position.add(t, s.position);
    sigma_velocity.add(t, s.velocity);
    sigma_attitude.add(t, kDegreesPerRadian * s.euler);
    gyro_total.add(t, kDegreesPerRadian * (x.gyro_bias + x.gyro_drift), kDegreesPerRadian * s.gyro_total_bias);
    accel_total.add(t, x.accel_bias + x.accel_drift, s.accel_total_bias);
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const BlockInfo& row = info(blocks[k]);
      block_charts[k].add(t, block_value(x, blocks[k]),
                          row.factor * s.blocks.segment(full_offset(blocks[k]), row.size));
    }
  }
  for (Builder& angle : attitude) break_turns(angle.chart());

  std::vector<Chart> out;
  for (Builder* b : {&speed, &height, attitude.data(), &attitude[1], &attitude[2], &velocity})
    out.push_back(std::move(b->chart()));
  if (has_total(layout, Block::kGyroBias, Block::kGyroDrift)) out.push_back(std::move(gyro_total.chart()));
  if (has_total(layout, Block::kAccelBias, Block::kAccelDrift)) out.push_back(std::move(accel_total.chart()));
  for (Builder& b : block_charts) out.push_back(std::move(b.chart()));
  for (Builder* b : {&sigma_position, &sigma_velocity, &sigma_attitude}) {
    b->chart().log_scale = true;
    out.push_back(std::move(b->chart()));
  }
  std::erase_if(out, shows_nothing);
  return out;
}

std::vector<Chart> of_innovations(const Solution& solution, double start) {
  std::vector<Chart> out;
  if (!solution.adapted.names.empty()) out.push_back(of_adapted(solution.adapted, start));
  for (std::size_t source = 0; source < solution.sources.size(); ++source) {
    const std::string& name = solution.sources[source];
    const auto axes = innovation_axes(name);
    Builder residual(name + ": residual over its sigma", "", {axes.begin(), axes.end()});
    Builder nis(name + ": NIS", "", {"used", "rejected", "readmitted", "disputed", "gate"});
    for (const Innovation& z : solution.innovations) {
      if (z.source != static_cast<int>(source) || z.outcome == Outcome::kRepeated) continue;
      const double t = z.time - start;
      Vector3d ratio;
      for (int i = 0; i < 3; ++i) ratio[i] = z.has(i) && z.sigma[i] > 0 ? z.residual[i] / z.sigma[i] : kNaN;
      residual.add(t, ratio);
      Eigen::Vector<double, 5> row = Eigen::Vector<double, 5>::Constant(kNaN);
      row[static_cast<Eigen::Index>(z.outcome)] = z.nis;
      if (z.gate > 0) row[4] = z.gate;
      nis.add(t, row);
    }
    for (Builder* b : {&residual, &nis}) {
      Chart& chart = b->chart();
      chart.points = true;
      chart.log_scale = b == &nis;
      // No curve for an axis that the source lacks, or for an outcome that did not occur.
      std::erase_if(chart.curves, [](const Curve& c) {
        return std::none_of(c.value.begin(), c.value.end(), [](double v) { return std::isfinite(v); });
      });
      if (!chart.curves.empty() && !shows_nothing(chart)) out.push_back(std::move(chart));
    }
  }
  return out;
}

std::string json(const Chart& chart, std::size_t limit) {
  std::vector<std::vector<double>> columns;
  for (const Curve& c : chart.curves) columns.push_back(c.value);
  const std::vector<std::size_t> rows = chart.points ? sample(columns, limit) : thin(columns, limit);
  const auto array = [&rows](const std::vector<double>& values, int digits) {
    std::string out = "[";
    for (const std::size_t i : rows) {
      if (out.size() > 1) out += ',';
      out += json::number(values[i], digits);
    }
    return out + ']';
  };
  std::string out =
      fmt::format(R"({{"title":{},"unit":{},"points":{},"log":{},"time":{},"curves":[)", json::string(chart.title),
                  json::string(chart.unit), chart.points, chart.log_scale, array(chart.time, 8));
  for (const Curve& c : chart.curves) {
    if (&c != chart.curves.data()) out += ',';
    out += fmt::format(R"({{"label":{},"value":{})", json::string(c.label), array(c.value, digits_of(c)));
    if (!c.sigma.empty()) out += fmt::format(R"(,"sigma":{})", array(c.sigma, 4));
    out += '}';
  }
  return out + "]}\n";
}

}  // namespace piste::charts
