#include "piste/study/study_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "piste/math/statistics.h"
#include "study/by_run.h"

namespace piste {
namespace {

Across across(const std::vector<Term>& terms) {
  std::vector<double> values, formal, within;
  for (const Term& t : terms) {
    values.push_back(t.value);
    formal.push_back(t.sigma);
    within.push_back(t.total());
  }
  const bool one = terms.size() == 1;
  Across out;
  out.runs = terms.size();
  out.mean = mean(values);
  out.std = standard_deviation(values);
  out.standard_error = one ? terms.front().total() : standard_error(values);
  out.p_value = one ? terms.front().p_value() : zero_mean_p_value(values);
  out.formal = root_mean_square(formal);
  out.within = root_mean_square(within);
  return out;
}

// Holm's correction over the numbers of a table.
void correct(const std::vector<Across*>& table) {
  std::vector<double> p_values;
  p_values.reserve(table.size());
  for (const Across* a : table) p_values.push_back(a->p_value);
  p_values = holm(std::move(p_values));
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i]->p_holm = p_values[i];
    table[i]->significant = p_values[i] < kSignificance;
  }
}

template <class Row>
void correct(std::span<Row> rows, Across Row::*value) {
  std::vector<Across*> table;
  for (Row& row : rows) table.push_back(&(row.*value));
  correct(table);
}

std::vector<const SensorRun*> runs_of(const Study& study, std::size_t sensor) {
  std::vector<const SensorRun*> out;
  for (const SensorRun& r : study.results) {
    if (r.sensor == sensor) out.push_back(&r);
  }
  return out;
}

// One row for each sensor and axis that has data: row(runs of the sensor, sensor, axis).
template <class Row, class F>
std::vector<Row> rows_of(const Study& study, F&& row) {
  std::vector<Row> out;
  for (std::size_t sensor = 0; sensor < study.sensors.size(); ++sensor) {
    const auto runs = runs_of(study, sensor);
    for (int axis = 0; axis < kSignals; ++axis) {
      if (const std::optional<Row> found = row(runs, sensor, axis)) out.push_back(*found);
    }
  }
  return out;
}

std::optional<Term> shown_of(const SensorRun& run, Method method, StudyQuantity quantity, int axis) {
  const AxisEstimate* estimate = run.estimate(method, axis);
  return estimate ? shown(*estimate, quantity, axis) : std::nullopt;
}

// a − b with both treated as independent.
Term minus(const Term& a, const Term& b) {
  Term out = difference(a, b);
  out.systematic = std::hypot(a.systematic, b.systematic);
  return out;
}

// After − before. Errors of the reference that are common to both cancel; the findings have the residual error.
Term change(const SensorRun& run, int axis, const Term& before, const Term& after) {
  Term out = minus(after, before);
  if (run.findings) {
    if (const auto& found = run.findings->axes[static_cast<std::size_t>(axis)].change) {
      out.systematic = signal_info(axis).factor * found->systematic;
    }
  }
  return out;
}

// a − b of one run; for the truth, a minus the true value of the quantity that a estimates.
std::optional<Term> difference_of(const SensorRun& run, Method a, Method b, StudyQuantity quantity, int axis) {
  const auto left = shown_of(run, a, quantity, axis);
  if (!left) return std::nullopt;
  if (b == Method::kTruth) {
    const auto truth = shown_truth(*run.estimate(a, axis), quantity, axis);
    if (!truth) return std::nullopt;
    Term out = *left;
    out.value -= *truth;
    return out;
  }
  const auto right = shown_of(run, b, quantity, axis);
  if (!right) return std::nullopt;
  return paired_difference(*left, *right);
}

const NavigationScore* own_score(const SensorRun& run) {
  const auto found = std::ranges::find(run.scores, Method::kInTheFilter, &NavigationScore::method);
  return found == run.scores.end() ? nullptr : &*found;
}

// Summarises those of the runs in which the IMU has a score.
ImuCompared imu_row(std::string name, const std::vector<const SensorRun*>& runs) {
  std::vector<double> position, velocity, attitude, drift;
  for (const SensorRun* run : runs) {
    const NavigationScore* score = own_score(*run);
    if (!score) continue;
    position.push_back(score->position_rmse);
    velocity.push_back(score->velocity_rmse);
    attitude.push_back(score->attitude_rmse);
    if (score->outage_drift > 0) drift.push_back(score->outage_drift);
  }
  return {.name = std::move(name),
          .runs = position.size(),
          .position_rmse = root_mean_square(position),
          .velocity_rmse = root_mean_square(velocity),
          .attitude_rmse = root_mean_square(attitude),
          .outage_drift = drift.empty() ? kNaN : root_mean_square(drift),
          .attitude_over_single = kNaN,
          .drift_over_single = kNaN};
}

}  // namespace

std::vector<ImuCompared> imus_compared(const Study& study) {
  std::vector<ImuCompared> out;
  std::vector<double> attitude, drift;  // of the single IMUs, in the runs of the fused IMU
  std::vector<const SensorRun*> together;
  for (const SensorRun& run : study.as_one) {
    if (own_score(run)) together.push_back(&run);
  }
  for (std::size_t sensor = 0; sensor < study.sensors.size(); ++sensor) {
    auto runs = runs_of(study, sensor);
    if (ImuCompared row = imu_row(study.sensors[sensor], runs); row.runs > 0) out.push_back(std::move(row));
    std::erase_if(runs, [&](const SensorRun* single) {
      return std::ranges::none_of(together, [&](const SensorRun* run) { return run->run == single->run; });
    });
    const ImuCompared in_same_runs = imu_row("", runs);
    if (in_same_runs.runs == 0) continue;
    attitude.push_back(in_same_runs.attitude_rmse);
    if (std::isfinite(in_same_runs.outage_drift)) drift.push_back(in_same_runs.outage_drift);
  }
  if (together.empty()) return out;
  ImuCompared row = imu_row(std::string(kAsOne), together);
  if (!attitude.empty()) row.attitude_over_single = row.attitude_rmse / mean(attitude);
  if (!drift.empty()) row.drift_over_single = row.outage_drift / mean(drift);
  out.push_back(std::move(row));
  return out;
}

std::vector<AcrossRow> table_of(const Study& study, Method method, StudyQuantity quantity) {
  auto out = rows_of<AcrossRow>(study, [&](const auto& runs, std::size_t sensor, int axis) -> std::optional<AcrossRow> {
    std::vector<Term> terms;
    std::vector<double> reverse, truth;
    for (const SensorRun* r : runs) {
      const auto term = shown_of(*r, method, quantity, axis);
      if (!term) continue;
      terms.push_back(*term);
      if (const auto t = shown_truth(*r->estimate(method, axis), quantity, axis)) truth.push_back(*t);
      if (method != Method::kJoint) continue;
      if (const auto t = shown_of(*r, Method::kJointReverse, quantity, axis)) reverse.push_back(t->value);
    }
    if (terms.empty()) return std::nullopt;
    AcrossRow row{sensor, axis, across(terms), reverse.empty() ? kNaN : mean(reverse), std::nullopt};
    if (truth.size() == terms.size()) row.truth = mean(truth);
    return row;
  });
  correct(std::span(out), &AcrossRow::value);
  return out;
}

std::vector<CrossAxisRow> cross_axis(const Study& study) {
  static constexpr std::array<std::string_view, 9> kElements{"xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"};
  // The sum or the difference of two gains, as a correction to add.
  const auto correction_of = [](const Term& gain, const Term& turned, double sign) {
    Term out = minus(gain, turned);
    out.value = -(gain.value + sign * turned.value);
    return out;
  };
  // The element (i, j) of a triad in a run, nothing if it has none.
  const auto element = [&](const SensorRun& run, bool gyro, int i, int j) -> std::optional<Term> {
    if (!run.findings || !run.findings->accel_matrix || !run.findings->gyro_matrix) return std::nullopt;
    const MatrixFit& accel = *run.findings->accel_matrix;
    if (!gyro) return correction_of(accel.gain(i, j), accel.gain(j, i), 1);
    const MatrixFit& found = *run.findings->gyro_matrix;
    return i < j ? correction_of(found.gain(i, j), accel.gain(i, j), -1)
                 : correction_of(found.gain(i, j), accel.gain(j, i), 1);
  };
  std::vector<CrossAxisRow> out;
  for (std::size_t sensor = 0; sensor < study.sensors.size(); ++sensor) {
    const auto runs = runs_of(study, sensor);
    for (int axis = 0; axis < kSignals; ++axis) {
      const bool gyro = axis >= 3;
      for (int j = 0; j < 3; ++j) {
        const int i = axis % 3;
        if (i == j || (!gyro && j > i)) continue;
        std::vector<Term> terms;
        for (const SensorRun* run : runs) {
          if (const auto term = element(*run, gyro, i, j)) terms.push_back(*term);
        }
        const auto place = 3 * static_cast<std::size_t>(i) + static_cast<std::size_t>(j);
        if (!terms.empty()) out.push_back({sensor, axis, kElements[place], across(terms)});
      }
    }
  }
  correct(std::span(out), &CrossAxisRow::value);
  return out;
}

std::vector<ScaleScatter> scale_scatter(const Study& study) {
  return rows_of<ScaleScatter>(
      study, [](const auto& runs, std::size_t sensor, int axis) -> std::optional<ScaleScatter> {
        std::vector<double> alone, with;
        for (const SensorRun* r : runs) {
          const auto first = shown_of(*r, Method::kJoint, StudyQuantity::kScale, axis),
                     second = shown_of(*r, Method::kMisalignment, StudyQuantity::kScale, axis);
          if (!first || !second) continue;
          alone.push_back(first->value);
          with.push_back(second->value);
        }
        if (alone.size() < 2) return std::nullopt;
        ScaleScatter row{sensor, axis, alone.size(), standard_deviation(alone), standard_deviation(with)};
        const double ratio = row.with_cross_axis / row.alone;
        row.explained = 1 - ratio * ratio;
        return row;
      });
}

std::vector<BeforeAfterRow> before_after(const Study& study) {
  auto out = rows_of<BeforeAfterRow>(
      study, [](const auto& runs, std::size_t sensor, int axis) -> std::optional<BeforeAfterRow> {
        std::vector<double> before, after;
        std::vector<Term> changes;
        for (const SensorRun* r : runs) {
          const auto first = shown_of(*r, Method::kRest, StudyQuantity::kBias, axis),
                     second = shown_of(*r, Method::kRestAfter, StudyQuantity::kBias, axis);
          if (!first || !second) continue;
          before.push_back(first->value);
          after.push_back(second->value);
          changes.push_back(change(*r, axis, *first, *second));
        }
        if (changes.empty()) return std::nullopt;
        return BeforeAfterRow{sensor, axis, mean(before), mean(after), across(changes)};
      });
  correct(std::span(out), &BeforeAfterRow::difference);
  return out;
}

std::vector<CorrelationRow> correlations(const Study& study, Method method) {
  return rows_of<CorrelationRow>(
      study, [method](const auto& runs, std::size_t sensor, int axis) -> std::optional<CorrelationRow> {
        std::vector<double> found, magnitude;
        for (const SensorRun* r : runs) {
          const AxisEstimate* estimate = r->estimate(method, axis);
          if (!estimate || !estimate->line) continue;
          found.push_back(estimate->line->correlation());
          magnitude.push_back(std::abs(found.back()));
        }
        if (found.empty()) return std::nullopt;
        const double c = std::copysign(mean(magnitude), mean(found));
        const auto [lowest, highest] = std::ranges::minmax(found);
        return CorrelationRow{sensor, axis, c, lowest, highest, 1 / (1 - square(c))};
      });
}

std::vector<Comparison> comparisons(const Study& study, StudyQuantity quantity) {
  std::vector<Comparison> out;
  for (const MethodInfo& a : kMethods) {
    for (const MethodInfo& b : kMethods) {
      if (a.method >= b.method) continue;
      auto pair =
          rows_of<Comparison>(study, [&](const auto& runs, std::size_t sensor, int axis) -> std::optional<Comparison> {
            std::vector<Term> terms;
            for (const SensorRun* r : runs) {
              if (const auto t = difference_of(*r, a.method, b.method, quantity, axis)) terms.push_back(*t);
            }
            if (terms.empty()) return std::nullopt;
            return Comparison{sensor, axis, quantity, a.method, b.method, across(terms)};
          });
      correct(std::span(pair), &Comparison::difference);
      out.insert(out.end(), pair.begin(), pair.end());
    }
  }
  return out;
}

std::vector<Coverage> coverage(const Study& study) {
  std::vector<Coverage> out;
  if (!study.simulated) return out;
  for (const MethodInfo& m : kMethods) {
    if (m.method == Method::kTruth) continue;
    for (const StudyQuantity quantity : {StudyQuantity::kBias, StudyQuantity::kScale}) {
      for (const bool gyro : {false, true}) {
        Coverage c{m.method, quantity, gyro};
        for (const SensorRun& r : study.results) {
          for (int axis = gyro ? 3 : 0; axis < (gyro ? 6 : 3); ++axis) {
            const auto error = difference_of(r, m.method, Method::kTruth, quantity, axis);
            if (!error) continue;
            const double distance = std::abs(error->value);
            ++c.all;
            if (distance <= error->half_width(1 - kSignificance)) ++c.inside;
            if (distance > 0) c.worst = std::max(c.worst, distance / error->total());
          }
        }
        if (c.all > 0) out.push_back(c);
      }
    }
  }
  return out;
}

std::vector<TimingRow> timing(const Study& study) {
  const auto correction_of = [](double scale) { return -scale / (1 + scale); };
  struct Changes {
    std::vector<const SensorRun*> at;
    std::array<std::vector<double>, kSignals> forward, reverse;
  };
  std::map<double, Changes> delays;
  for (const SensorRun& r : study.results) {
    const auto none = std::ranges::find(r.timing, 0.0, &TimingEffect::delay);
    if (none == r.timing.end()) continue;
    for (const TimingEffect& t : r.timing) {
      Changes& c = delays[t.delay];
      c.at.push_back(&r);
      for (std::size_t axis = 0; axis < kSignals; ++axis) {
        c.forward[axis].push_back(correction_of(t.forward[axis]) - correction_of(none->forward[axis]));
        c.reverse[axis].push_back(correction_of(t.reverse[axis]) - correction_of(none->reverse[axis]));
      }
    }
  }
  std::vector<TimingRow> out;
  for (const auto& [delay, c] : delays) {
    TimingRow row;
    row.delay = delay;
    for (std::size_t axis = 0; axis < kSignals; ++axis) {
      const auto forward = mean_by_run(c.at, c.forward[axis]), reverse = mean_by_run(c.at, c.reverse[axis]);
      row.forward[axis] = mean(forward);
      row.reverse[axis] = mean(reverse);
      row.forward_error[axis] = standard_error(forward);
      row.reverse_error[axis] = standard_error(reverse);
    }
    out.push_back(row);
  }
  return out;
}

}  // namespace piste
