#include "study/printed_tables.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>

#include "piste/math/statistics.h"
#include "piste/study/study_tables.h"

namespace piste {
namespace {

// A row for each sensor, without numbers yet.
PrintedTable named(std::string name, const Study& study) {
  return {std::move(name), std::vector<PrintedRow>(study.sensors.size())};
}

PrintedTable printed(std::string name, const Study& study, Method method, StudyQuantity quantity) {
  PrintedTable out = named(std::move(name), study);
  for (const AcrossRow& r : table_of(study, method, quantity)) {
    out.sensors[r.sensor][static_cast<std::size_t>(r.axis)] = {r.value.mean, r.value.std, 0};
  }
  return out;
}

ImpliedMean implied_mean(const Printed& joint, const Printed& scale, const Printed& alone) {
  ImpliedMean out{(alone.value - joint.value) / scale.value, std::nullopt};
  if (!(std::abs(scale.value) > scale.rounding)) return out;
  const double half = joint.rounding + alone.rounding, shift = alone.value - joint.value;
  std::vector<double> corners;
  for (const double numerator : {shift - half, shift + half}) {
    for (const double denominator : {scale.value - scale.rounding, scale.value + scale.rounding}) {
      corners.push_back(numerator / denominator);
    }
  }
  const auto [low, high] = std::ranges::minmax(corners);
  out.bounds = Band{low, high};
  return out;
}

std::optional<Band> intersection(const std::vector<std::array<ImpliedMean, kSignals>>& sensors, std::size_t axis) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Band out{-kInfinity, kInfinity};
  for (const auto& sensor : sensors) {
    const auto& bounds = sensor[axis].bounds;
    if (!bounds) continue;
    out.low = std::max(out.low, bounds->low);
    out.high = std::min(out.high, bounds->high);
  }
  if (std::isinf(out.low) || out.low > out.high) return std::nullopt;
  return out;
}

// The numbers that a table has.
std::vector<Printed> numbers(const PrintedTable& table) {
  std::vector<Printed> out;
  for (const PrintedRow& row : table.sensors) {
    std::ranges::copy_if(row, std::back_inserter(out), [](const Printed& p) { return std::isfinite(p.value); });
  }
  return out;
}

std::size_t significant(std::vector<double> p_values) {
  return static_cast<std::size_t>(
      std::ranges::count_if(holm(std::move(p_values)), [](double p) { return p < kSignificance; }));
}

}  // namespace

CampaignTables campaign_tables(const Study& study) {
  CampaignTables out{.rest = printed("Table 1", study, Method::kRest, StudyQuantity::kBias),
                     .before = named("Table 2", study),
                     .after = named("Table 2", study),
                     .joint_bias = printed("Table 3", study, Method::kJoint, StudyQuantity::kBias),
                     .joint_scale = printed("Table 4", study, Method::kJoint, StudyQuantity::kScale),
                     .correlation = named("Table 5", study),
                     .bias_only = printed("Table 6", study, Method::kBiasOnly, StudyQuantity::kBias)};
  for (const BeforeAfterRow& r : before_after(study)) {
    const auto axis = static_cast<std::size_t>(r.axis);
    out.before.sensors[r.sensor][axis].value = r.before;
    out.after.sensors[r.sensor][axis].value = r.after;
  }
  for (const CorrelationRow& r : correlations(study)) {
    out.correlation.sensors[r.sensor][static_cast<std::size_t>(r.axis)].value = r.correlation;
  }
  return out;
}

ImpliedMeans implied_means(const CampaignTables& tables) {
  ImpliedMeans out;
  for (std::size_t sensor = 0; sensor < tables.bias_only.sensors.size(); ++sensor) {
    std::array<ImpliedMean, kSignals> row;
    for (std::size_t axis = 0; axis < kSignals; ++axis) {
      row[axis] = implied_mean(tables.joint_bias.sensors[sensor][axis], tables.joint_scale.sensors[sensor][axis],
                               tables.bias_only.sensors[sensor][axis]);
    }
    out.sensors.push_back(row);
  }
  for (std::size_t axis = 0; axis < kSignals; ++axis) out.common[axis] = intersection(out.sensors, axis);
  return out;
}

ImpliedSpread implied_spread(double mean, double correlation) {
  const double rms = std::abs(mean / correlation);
  return {mean, rms, std::sqrt(rms * rms - mean * mean)};
}

std::vector<std::pair<std::size_t, int>> wrong_signs(const CampaignTables& tables, const ImpliedMeans& means) {
  std::vector<std::pair<std::size_t, int>> out;
  for (std::size_t sensor = 0; sensor < tables.correlation.sensors.size(); ++sensor) {
    for (int axis = 0; axis < kSignals; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      const auto& mean = means.common[at];
      if (!mean || mean->contains(0)) continue;
      if (tables.correlation.sensors[sensor][at].value * mean->low > 0) out.emplace_back(sensor, axis);
    }
  }
  return out;
}

SignificantCount significant_count(const PrintedTable& table, std::size_t runs) {
  SignificantCount out;
  std::vector<double> of_mean, of_one;
  const auto n = static_cast<double>(runs);
  for (const Printed& p : numbers(table)) {
    if (!(p.std > 0)) continue;  // of one run
    const double size = std::abs(p.value), t = size / p.std;
    ++out.all;
    if (size > p.std) ++out.above_one_sigma;
    if (size == p.std) ++out.at_one_sigma;
    if (size > 2 * p.std) ++out.above_two_sigma;
    of_mean.push_back(student_two_sided(t * std::sqrt(n), n - 1));
    of_one.push_back(student_two_sided(t, n - 1));
  }
  out.expected_by_chance = static_cast<double>(out.all) * std::erfc(std::sqrt(0.5));
  out.holm_of_mean = significant(std::move(of_mean));
  out.holm_of_one = significant(std::move(of_one));
  return out;
}

SignTest sign_test(const PrintedTable& table) {
  SignTest out;
  for (const Printed& p : numbers(table)) {
    if (p.value == 0) continue;
    ++out.all;
    if (p.value < 0) ++out.negative;
  }
  // Probability of at most so many positive numbers: the binomial distribution with probability ½, summed from zero.
  double p = std::pow(0.5, static_cast<double>(out.all));
  out.p_value = 0;
  for (std::size_t positive = 0; positive <= out.all - out.negative; ++positive) {
    out.p_value += p;
    p *= static_cast<double>(out.all - positive) / static_cast<double>(positive + 1);
  }
  return out;
}

std::array<Shift, kSignals> shifts(const CampaignTables& tables) {
  std::array<Shift, kSignals> out;
  for (std::size_t axis = 0; axis < kSignals; ++axis) {
    Shift& s = out[axis];
    for (std::size_t sensor = 0; sensor < tables.rest.sensors.size(); ++sensor) {
      const Printed &rest = tables.rest.sensors[sensor][axis], &run = tables.bias_only.sensors[sensor][axis];
      s.value.push_back(run.value - rest.value);
      s.in_sigma.push_back(std::abs(s.value.back()) / std::hypot(run.std, rest.std));
    }
    const auto sign = [&s](auto is) { return std::ranges::all_of(s.value, is); };
    s.same_sign = sign([](double v) { return v > 0; }) || sign([](double v) { return v < 0; });
  }
  return out;
}

double table_correlation(const PrintedTable& a, const PrintedTable& b, bool gyro) {
  std::vector<std::pair<double, double>> points;
  for (std::size_t sensor = 0; sensor < std::min(a.sensors.size(), b.sensors.size()); ++sensor) {
    for (std::size_t axis = gyro ? 3 : 0; axis < (gyro ? 6 : 3); ++axis) {
      const double x = a.sensors[sensor][axis].value, y = b.sensors[sensor][axis].value;
      if (std::isfinite(x) && std::isfinite(y)) points.emplace_back(x, y);
    }
  }
  double mean_x = 0, mean_y = 0, xx = 0, yy = 0, xy = 0;
  const auto n = static_cast<double>(points.size());
  for (const auto& [x, y] : points) mean_x += x / n, mean_y += y / n;
  for (const auto& [x, y] : points) {
    xx += (x - mean_x) * (x - mean_x);
    yy += (y - mean_y) * (y - mean_y);
    xy += (x - mean_x) * (y - mean_y);
  }
  return xy / std::sqrt(xx * yy);
}

double axis_mean(const PrintedTable& table, int axis) {
  std::vector<double> values;
  for (const PrintedRow& row : table.sensors) {
    const double value = row[static_cast<std::size_t>(axis)].value;
    if (std::isfinite(value)) values.push_back(value);
  }
  return values.empty() ? kNaN : mean(values);
}

std::vector<std::array<double, kSignals>> std_ratios(const PrintedTable& a, const PrintedTable& b) {
  std::vector<std::array<double, kSignals>> out(std::min(a.sensors.size(), b.sensors.size()));
  for (std::size_t sensor = 0; sensor < out.size(); ++sensor) {
    for (std::size_t axis = 0; axis < kSignals; ++axis) {
      out[sensor][axis] = a.sensors[sensor][axis].std / b.sensors[sensor][axis].std;
    }
  }
  return out;
}

std::vector<std::pair<int, int>> equal_std(const PrintedTable& table) {
  std::vector<std::pair<int, int>> out;
  for (int i = 0; i < kSignals; ++i) {
    for (int j = i + 1; j < kSignals; ++j) {
      std::size_t alike = 0, all = 0;
      for (const PrintedRow& row : table.sensors) {
        const double a = row[static_cast<std::size_t>(i)].std, b = row[static_cast<std::size_t>(j)].std;
        if (!std::isfinite(a) || !std::isfinite(b)) continue;
        ++all;
        if (a == b) ++alike;
      }
      if (all > 0 && alike == all) out.emplace_back(i, j);
    }
  }
  return out;
}

}  // namespace piste
