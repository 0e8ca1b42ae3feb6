#include "piste/study/ranking.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string_view>
#include <utility>

#include "piste/math/statistics.h"
#include "piste/study/study_tables.h"
#include "study/by_run.h"

namespace piste {
namespace {

constexpr double kInseparable = 10;  // inflation above which bias and scale cannot be separated

constexpr std::array kCriteria{&NavigationScore::position_rmse, &NavigationScore::velocity_rmse,
                               &NavigationScore::attitude_rmse, &NavigationScore::outage_drift};

const NavigationScore* score_of(const SensorRun& run, Method method) {
  const auto found = std::ranges::find(run.scores, method, &NavigationScore::method);
  return found == run.scores.end() ? nullptr : &*found;
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
  out.row.position_rmse = root_mean_square(values[0]);
  out.row.velocity_rmse = root_mean_square(values[1]);
  out.row.attitude_rmse = root_mean_square(values[2]);
  out.row.outage_drift = root_mean_square(values[3]);
  out.log_scores = mean_by_run(at, log_scores);
  out.row.score = std::exp(mean(out.log_scores));
  return out;
}

// Differences of the logarithms of two scores, paired by run.
std::vector<double> ahead(const Contestant& a, const Contestant& b) {
  std::vector<double> out;
  for (std::size_t i = 0; i < a.log_scores.size(); ++i) out.push_back(a.log_scores[i] - b.log_scores[i]);
  return out;
}

void hold_against(Contestant& c, const Contestant& winner) {
  const std::vector<double> behind = ahead(c, winner);
  const double middle = mean(behind);
  c.row.versus_winner = std::exp(middle);
  c.row.low = c.row.high = kNaN;
  if (behind.size() < 2) return;
  const double t = student_quantile(1 - kSignificance / 2, static_cast<double>(behind.size() - 1));
  c.row.low = std::exp(middle - t * standard_error(behind));
  c.row.high = std::exp(middle + t * standard_error(behind));
}

// The winner is chosen by the scores, so every pair of methods is a hypothesis of Holm's correction. Only the p-values
// of pairs with the winner are kept.
void add_p_values(std::vector<Contestant>& all, Method winner) {
  std::vector<double> p_values;
  std::vector<Contestant*> with_winner;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      p_values.push_back(zero_mean_p_value(ahead(all[i], all[j])));
      const bool first = all[i].row.method == winner, second = all[j].row.method == winner;
      with_winner.push_back(first ? &all[j] : second ? &all[i] : nullptr);
    }
  }
  p_values = holm(std::move(p_values));
  for (std::size_t pair = 0; pair < with_winner.size(); ++pair) {
    if (with_winner[pair]) with_winner[pair]->row.p_holm = p_values[pair];
  }
}

// A random number below n, with the same bytes on every platform.
std::size_t draw(std::mt19937_64& random, std::size_t n) {
  return static_cast<std::size_t>(((random() >> 32) * n) >> 32);
}

// Share of the resamplings of the runs in which the winner has the lowest score; a tie is shared.
double confidence(const std::vector<const Contestant*>& competitors, const Contestant& winner) {
  constexpr int kResamplings = 10000;
  const std::size_t n = winner.log_scores.size();
  if (n < 2) return kNaN;
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
      if (other == own) ++ties;  // `own` is in the list, too
    }
    if (!beaten) wins += 1.0 / ties;
  }
  return wins / kResamplings;
}

// ---- Remarks ----

std::string p_text(double p) { return p < 0.001 ? "p < 0.001" : fmt::format("p = {:.2g}", p); }

// Whether a row has the lowest score or ties with it: its own interval contains 1. So no correction for the number of
// pairs is needed to call it as good. With only one run there is no interval, and only the ratio counts.
bool ties(const RankingRow& row) {
  const bool same = std::round(100 * row.versus_winner) == 100;
  return same || (row.low <= 1 && 1 <= row.high);
}

// How much better or worse a score is, as a ratio of the smaller to the larger or the other way round.
std::string by_how_much(double ratio) {
  constexpr double kTwice = 2;
  const bool worse = ratio > 1;
  const double factor = worse ? ratio : 1 / ratio;
  if (factor >= kTwice) return fmt::format("{:.1f} times {}", factor, worse ? "worse" : "better");
  return fmt::format("{:.1f} % {}", 100 * std::abs(ratio - 1), worse ? "worse" : "better");
}

std::string lead(const Ranking& ranking) {
  const std::size_t first = leaders(ranking).size();
  std::string out = has_winner(ranking) ? "winner"
                    : first > 1         ? fmt::format("lowest score of {} that tie", first)
                                        : "lowest score";
  if (const RankingRow* next = second(ranking)) {
    out += fmt::format(": {} than {}", by_how_much(1 / next->versus_winner), info(next->method).name);
  }
  if (std::isfinite(ranking.confidence)) {
    out += fmt::format("; wins {:.0f} % of the resamplings of the runs", 100 * ranking.confidence);
  }
  return out;
}

std::string standing(const RankingRow& row, std::string_view best) {
  std::string out = row.versus_winner == 1 ? fmt::format("as good as {}", best)
                                           : fmt::format("{} than {}", by_how_much(row.versus_winner), best);
  if (std::isnan(row.p_holm)) return out;
  return out + fmt::format(" ({}{})", row.p_holm < kSignificance ? "" : "not significantly; ", p_text(row.p_holm));
}

// Where bias and scale of a method are most correlated.
std::optional<std::string> alike(const Study& study, Method method) {
  const auto rows = correlations(study, method);
  const auto worst =
      std::ranges::max_element(rows, {}, [](const CorrelationRow& r) { return std::abs(r.correlation); });
  if (worst == rows.end() || !(worst->inflation > kInseparable)) return std::nullopt;
  return fmt::format("correlation of bias and scale {:.2f} on {}", worst->correlation, signal_info(worst->axis).name);
}

}  // namespace

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

std::vector<const SensorRun*> scored(const Study& study) {
  std::vector<const SensorRun*> out;
  for (const SensorRun& r : study.results) {
    if (log_score(r, Method::kNothing)) out.push_back(&r);
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

const RankingRow* second(const Ranking& ranking) {
  const RankingRow* out = nullptr;
  for (const RankingRow& r : ranking.rows) {
    if (!info(r.method).competes || r.method == ranking.winner) continue;
    if (!out || r.score < out->score) out = &r;
  }
  return out;
}

std::vector<RankingRow> leaders(const Ranking& ranking) {
  std::vector<RankingRow> out;
  for (const RankingRow& row : ranking.rows) {
    if (ranking.winner && info(row.method).competes && ties(row)) out.push_back(row);
  }
  std::ranges::stable_sort(out, {}, &RankingRow::score);
  return out;
}

bool has_winner(const Ranking& ranking) {
  const std::vector<RankingRow> first = leaders(ranking);
  return first.size() == 1 && std::ranges::none_of(ranking.rows, [&](const RankingRow& row) {
           return info(row.method).competes && row.method != ranking.winner && row.p_holm >= kSignificance;
         });
}

std::vector<std::string> remarks(const Study& study, const Ranking& ranking) {
  std::vector<std::string> out;
  const std::string_view best = has_winner(ranking) ? "the winner" : "the best";
  for (const RankingRow& r : ranking.rows) {
    std::vector<std::string> parts;
    if (!info(r.method).competes) parts.emplace_back("does not compete");
    if (ranking.winner) parts.push_back(r.method == ranking.winner ? lead(ranking) : standing(r, best));
    if (const auto axis = alike(study, r.method)) parts.push_back(*axis);
    out.push_back(fmt::format("{}", fmt::join(parts, "; ")));
  }
  return out;
}

}  // namespace piste
