#include "piste/experiment/study_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <span>
#include <utility>

#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double square(double x) { return x * x; }

// ---- Over the runs ----

double mean(std::span<const double> values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

// Between the values; NaN of one.
double spread(std::span<const double> values) {
  if (values.size() < 2) return kNone;
  const double middle = mean(values);
  double sum = 0;
  for (const double v : values) sum += square(v - middle);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double rms(std::span<const double> values) {
  double sum = 0;
  for (const double v : values) sum += square(v);
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

// Of the mean of several values.
double standard_error(std::span<const double> values) {
  return spread(values) / std::sqrt(static_cast<double>(values.size()));
}

// Of a mean of zero, by Student's t; NaN of one value.
double p_value(std::span<const double> values) {
  const double error = standard_error(values), distance = std::abs(mean(values));
  if (std::isnan(error)) return kNone;
  if (error == 0) return distance == 0 ? 1 : 0;
  return student_two_sided(distance / error, static_cast<double>(values.size() - 1));
}

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
  out.std = spread(values);
  out.standard_error = one ? terms.front().total() : standard_error(values);
  out.p_value = one ? terms.front().p_value() : p_value(values);
  out.formal = rms(formal);
  out.within = rms(within);
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

// A row of each sensor and axis that has one: row(runs of the sensor, sensor, axis).
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

std::optional<Term> shown_of(const SensorRun& run, Method method, Quantity quantity, int axis) {
  const AxisEstimate* estimate = run.estimate(method, axis);
  return estimate ? shown(*estimate, quantity, axis) : std::nullopt;
}

// a − b as if they were independent.
Term minus(const Term& a, const Term& b) {
  Term out = difference(a, b);
  out.systematic = std::hypot(a.systematic, b.systematic);
  return out;
}

// After − before: what the reference adds to both cancels, and the findings know what of it is left.
Term change(const SensorRun& run, int axis, const Term& before, const Term& after) {
  Term out = minus(after, before);
  if (run.findings) {
    if (const auto& found = run.findings->axes[static_cast<std::size_t>(axis)].change) {
      out.systematic = signal_info(axis).factor * found->systematic;
    }
  }
  return out;
}

// a − b of one run, or a − what was put in, as a could see it.
std::optional<Term> difference_of(const SensorRun& run, Method a, Method b, Quantity quantity, int axis) {
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
  return minus(*left, *right);
}

// ---- Ranking ----

constexpr std::array kCriteria{&NavigationScore::position_rmse, &NavigationScore::velocity_rmse,
                               &NavigationScore::attitude_rmse, &NavigationScore::outage_drift};

const NavigationScore* score_of(const SensorRun& run, Method method) {
  const auto found = std::ranges::find(run.scores, method, &NavigationScore::method);
  return found == run.scores.end() ? nullptr : &*found;
}

// Logarithm of the geometric mean of the criteria over those of `nothing`; nothing where there is none to compare.
std::optional<double> log_score(const SensorRun& run, Method method) {
  const NavigationScore *score = score_of(run, method), *nothing = score_of(run, Method::kNothing);
  if (!score || !nothing) return std::nullopt;
  double sum = 0;
  int count = 0;
  for (const auto criterion : kCriteria) {
    if (!(score->*criterion > 0 && nothing->*criterion > 0)) continue;
    sum += std::log(score->*criterion / nothing->*criterion);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

// A sensor-run can be scored where its replay was run that knows nothing.
std::vector<const SensorRun*> scored(const Study& study) {
  std::vector<const SensorRun*> out;
  for (const SensorRun& r : study.results) {
    if (log_score(r, Method::kNothing)) out.push_back(&r);
  }
  return out;
}

// Mean over the sensors of each run, in the order of the runs.
std::vector<double> by_run(const std::vector<const SensorRun*>& at, const std::vector<double>& values) {
  std::map<std::size_t, std::vector<double>> runs;
  for (std::size_t i = 0; i < at.size(); ++i) runs[at[i]->run].push_back(values[i]);
  std::vector<double> out;
  out.reserve(runs.size());
  for (const auto& [run, of_sensors] : runs) out.push_back(mean(of_sensors));
  return out;
}

struct Contestant {
  RankingRow row;
  std::vector<double> log_scores;  // by run
};

std::optional<Contestant> contestant(const std::vector<const SensorRun*>& at, Method method) {
  Contestant out;
  out.row.method = method;
  out.row.count = at.size();
  std::vector<double> log_scores;
  std::array<std::vector<double>, kCriteria.size()> values;
  for (const SensorRun* r : at) {
    const auto found = log_score(*r, method);
    if (!found) return std::nullopt;
    log_scores.push_back(*found);
    for (std::size_t c = 0; c < kCriteria.size(); ++c) {
      const double value = score_of(*r, method)->*kCriteria[c];
      if (value > 0) values[c].push_back(value);
    }
  }
  out.row.position_rmse = rms(values[0]);
  out.row.velocity_rmse = rms(values[1]);
  out.row.attitude_rmse = rms(values[2]);
  out.row.outage_drift = rms(values[3]);
  out.log_scores = by_run(at, log_scores);
  out.row.score = std::exp(mean(out.log_scores));
  return out;
}

// Of the logarithms of two scores, paired by run.
std::vector<double> ahead(const Contestant& a, const Contestant& b) {
  std::vector<double> out;
  for (std::size_t i = 0; i < a.log_scores.size(); ++i) out.push_back(a.log_scores[i] - b.log_scores[i]);
  return out;
}

void hold_against(Contestant& c, const Contestant& winner) {
  const std::vector<double> behind = ahead(c, winner);
  const double middle = mean(behind);
  c.row.versus_winner = std::exp(middle);
  c.row.low = c.row.high = kNone;
  if (behind.size() < 2) return;
  const double t = student_quantile(1 - kSignificance / 2, static_cast<double>(behind.size() - 1));
  c.row.low = std::exp(middle - t * standard_error(behind));
  c.row.high = std::exp(middle + t * standard_error(behind));
}

// Which one wins is known from the scores alone, so every pair is a hypothesis, and those of the winner are told.
void add_p_values(std::vector<Contestant>& all, Method winner) {
  std::vector<double> p_values;
  std::vector<Contestant*> told;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      p_values.push_back(p_value(ahead(all[i], all[j])));
      const bool first = all[i].row.method == winner, second = all[j].row.method == winner;
      told.push_back(first ? &all[j] : second ? &all[i] : nullptr);
    }
  }
  p_values = holm(std::move(p_values));
  for (std::size_t pair = 0; pair < told.size(); ++pair) {
    if (told[pair]) told[pair]->row.p_holm = p_values[pair];
  }
}

// Below n, with the same bytes everywhere.
std::size_t draw(std::mt19937_64& random, std::size_t n) {
  return static_cast<std::size_t>(((random() >> 32) * n) >> 32);
}

// Share of the resamplings of the runs in which the winner has the lowest score; a tie is shared.
double confidence(const std::vector<const Contestant*>& competitors, const Contestant& winner) {
  constexpr int kResamplings = 10000;
  const std::size_t n = winner.log_scores.size();
  if (n < 2) return kNone;
  std::mt19937_64 random(20080113);
  std::vector<std::size_t> drawn(n);
  const auto sum = [&drawn](const Contestant& c) {
    double out = 0;
    for (const std::size_t i : drawn) out += c.log_scores[i];
    return out;
  };
  double wins = 0;
  for (int i = 0; i < kResamplings; ++i) {
    for (std::size_t& d : drawn) d = draw(random, n);
    const double own = sum(winner);
    int ties = 0;
    bool beaten = false;
    for (const Contestant* c : competitors) {
      const double other = sum(*c);
      beaten = beaten || other < own;
      if (other == own) ++ties;  // with itself, too
    }
    if (!beaten) wins += 1.0 / ties;
  }
  return wins / kResamplings;
}

// ---- What is missing ----

std::string name_of(const Study& study, const SensorRun& r) {
  return fmt::format("{} in {}", study.sensors[r.sensor], study.runs[r.run].name);
}

// Where a method is silent though the sensor-run went well: whole sensor-runs, or some axes of one.
std::vector<std::string> silent(const Study& study, Method method) {
  std::vector<std::string> out;
  for (const SensorRun& r : study.results) {
    if (!r.failure.empty()) continue;
    std::vector<std::string_view> axes;
    for (int axis = 0; axis < kSignals; ++axis) {
      if (!r.estimate(method, axis)) axes.push_back(signal_info(axis).name);
    }
    if (axes.empty()) continue;
    const bool whole = axes.size() == kSignals;
    out.push_back(whole ? name_of(study, r) : fmt::format("{} of {}", fmt::join(axes, " "), name_of(study, r)));
  }
  return out;
}

bool answers(const Study& study, Method method) {
  return std::ranges::any_of(study.results, [method](const SensorRun& r) {
    return std::ranges::any_of(r.estimates, [method](const MethodEstimate& e) { return e.method == method; });
  });
}

void add_failures(const Study& study, std::vector<std::string>& out) {
  for (std::size_t run = 0; run < study.runs.size(); ++run) {
    const StudyRun& r = study.runs[run];
    if (!r.failure.empty()) {
      out.push_back(fmt::format("{} failed: {}", r.name, r.failure));
      continue;
    }
    for (std::size_t sensor = 0; sensor < study.sensors.size(); ++sensor) {
      const auto found =
          std::ranges::find_if(study.results, [&](const SensorRun& s) { return s.run == run && s.sensor == sensor; });
      if (found == study.results.end()) {
        out.push_back(fmt::format("{} has no {}.", r.name, study.sensors[sensor]));
      } else if (!found->failure.empty()) {
        out.push_back(fmt::format("{} failed: {}", name_of(study, *found), found->failure));
      }
    }
  }
}

void add_silence(const Study& study, std::vector<std::string>& out) {
  for (const MethodInfo& m : kMethods) {
    if (m.estimates.empty() || m.method == Method::kTruth) continue;
    if (!answers(study, m.method)) {
      out.push_back(fmt::format("No run has an answer by {}.", m.name));
    } else if (const auto where = silent(study, m.method); !where.empty()) {
      out.push_back(fmt::format("There is no answer by {} for {}.", m.name, fmt::join(where, ", ")));
    }
  }
}

void add_unranked(const Study& study, std::vector<std::string>& out) {
  const auto at = scored(study);
  if (at.empty()) {
    out.emplace_back("No replay was scored, so that the methods are not ranked.");
    return;
  }
  for (const SensorRun& r : study.results) {
    if (!r.scores.empty() && !log_score(r, Method::kNothing)) {
      out.push_back(
          fmt::format("{} is not in the ranking: its replay that knows nothing has no score.", name_of(study, r)));
    }
  }
  for (const MethodInfo& m : kMethods) {
    std::vector<std::string> without;
    for (const SensorRun* r : at) {
      if (!log_score(*r, m.method)) without.push_back(name_of(study, *r));
    }
    if (without.empty() || without.size() == at.size()) continue;
    out.push_back(fmt::format("{} is not ranked: it has no score for {}.", m.name, fmt::join(without, ", ")));
  }
  for (const StudyRun& r : study.runs) {
    if (r.failure.empty() && r.outages == 0) {
      out.push_back(fmt::format("{} has no outage: it is scored without the drift in one.", r.name));
    }
  }
}

}  // namespace

std::vector<AcrossRow> table_of(const Study& study, Method method, Quantity quantity) {
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
    AcrossRow row{sensor, axis, across(terms), reverse.empty() ? kNone : mean(reverse), std::nullopt};
    if (truth.size() == terms.size()) row.truth = mean(truth);
    return row;
  });
  correct(std::span(out), &AcrossRow::value);
  return out;
}

std::vector<BeforeAfterRow> before_after(const Study& study) {
  auto out = rows_of<BeforeAfterRow>(
      study, [](const auto& runs, std::size_t sensor, int axis) -> std::optional<BeforeAfterRow> {
        std::vector<double> before, after;
        std::vector<Term> changes;
        for (const SensorRun* r : runs) {
          const auto first = shown_of(*r, Method::kRest, Quantity::kBias, axis),
                     second = shown_of(*r, Method::kRestAfter, Quantity::kBias, axis);
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

std::vector<Comparison> comparisons(const Study& study, Quantity quantity) {
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
    for (const Quantity quantity : {Quantity::kBias, Quantity::kScale}) {
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

Ranking ranking(const Study& study) {
  const auto at = scored(study);
  Ranking out;
  if (at.empty()) return out;
  std::vector<Contestant> all;
  for (const MethodInfo& m : kMethods) {
    if (auto c = contestant(at, m.method)) all.push_back(std::move(*c));
  }
  std::vector<const Contestant*> competitors;
  for (const Contestant& c : all) {
    if (info(c.row.method).competes) competitors.push_back(&c);
  }
  if (!competitors.empty()) {
    const Contestant winner = **std::ranges::min_element(competitors, {}, [](const auto* c) { return c->row.score; });
    out.winner = winner.row.method;
    out.confidence = confidence(competitors, winner);
    for (Contestant& c : all) {
      if (c.row.method != out.winner) hold_against(c, winner);
    }
    add_p_values(all, winner.row.method);
  }
  for (Contestant& c : all) out.rows.push_back(c.row);
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
      const auto forward = by_run(c.at, c.forward[axis]), reverse = by_run(c.at, c.reverse[axis]);
      row.forward[axis] = mean(forward);
      row.reverse[axis] = mean(reverse);
      row.forward_error[axis] = standard_error(forward);
      row.reverse_error[axis] = standard_error(reverse);
    }
    out.push_back(row);
  }
  return out;
}

std::vector<std::string> missing(const Study& study) {
  std::vector<std::string> out;
  add_failures(study, out);
  if (study.runs.size() == 1) out.emplace_back("One run: nothing can be said of the spread between runs.");
  add_silence(study, out);
  add_unranked(study, out);
  return out;
}

}  // namespace piste
