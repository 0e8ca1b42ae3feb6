#include "piste/solve/look_back.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "piste/solve/fix_queue.h"
#include "piste/solve/rts.h"

namespace piste {
namespace {

constexpr int kMostPasses = 4;
// Sigmas: a trajectory that moves by less anywhere is linearised well enough, as the next pass moves it by much less.
constexpr double kStill = 0.5;

// The farthest that position, velocity or attitude has moved from one smoothed run to another, in its sigmas.
double farthest_moved(const Solution& from, const Solution& to) {
  constexpr std::size_t kEvery = 10;  // rows
  double farthest = 0;
  for (std::size_t i = 0; i < std::min(from.size(), to.size()); i += kEvery) {
    const Estimate x = from.estimate(i), y = to.estimate(i);
    const Sigmas sigmas = to.sigmas(i);
    const auto look = [&](const Vector3d& moved, const Vector3d& sigma) {
      if (sigma.minCoeff() > 0) farthest = std::max(farthest, moved.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    };
    const Matrix3d R_nw = to.world().rotation_wn(y.p_wb).transpose();
    look(R_nw * (y.p_wb - x.p_wb), sigmas.position);
    look(R_nw * (y.v_wb - x.v_wb), sigmas.velocity);
    const Vector3d turned = to_euler(R_nw * y.R_wb()) - to_euler(R_nw * x.R_wb());
    look(turned.unaryExpr([](double angle) { return std::remainder(angle, 2 * std::numbers::pi); }), sigmas.euler);
  }
  return farthest;
}

std::shared_ptr<const Reference> trajectory_of(const Solution& rows, const Estimate& start) {
  auto trajectory = std::make_shared<Reference>(rows.layout());
  trajectory->start = start;
  for (std::size_t i = 0; i < rows.size(); ++i) trajectory->add(rows.time(i), rows.estimate(i));
  trajectory->close();
  return trajectory;
}

// How many rows of a run are not after the last one of another.
std::size_t rows_until_end(const Solution& run, const Solution& other) {
  std::size_t count = 0;
  while (!other.empty() && count < run.size() && run.time(count) <= other.time(other.size() - 1) + kSameInstant)
    ++count;
  return count;
}

}  // namespace

LookedBack looked_back(const Log& log, const FilterOptions& options, const FoundStart& found) {
  if (!found.aligned) return {};
  const LogPart part{.end = *found.aligned + kSameInstant, .rest_step = options.behaviour.start.rest_step};
  LookedBack back;
  back.run = run_filter(log, options, found.start, Keep::kHistory, {}, part);
  SmoothedState at_start;
  back.rows = smooth_rts(back.run, {}, &at_start);
  for (int pass = 0; pass < kMostPasses; ++pass) {
    back.about = trajectory_of(back.rows, at_start.x);
    back.run = run_filter(log, options, without_alignment(log.world, found), Keep::kHistory, {}, part, back.about);
    Solution rows = smooth_rts(back.run, {}, &at_start);
    const double moved = farthest_moved(back.rows, rows);
    back.rows = std::move(rows);
    if (moved < kStill) break;
  }
  return back;
}

FilterRun filter_from(const LookedBack& back, const Log& log, const FilterOptions& options, const FoundStart& found,
                      Keep keep, const ProgressCallback& progress, double end_time, const RowTaker& rows,
                      const std::filesystem::path& scratch) {
  const double end = std::min(end_time, log.imu.empty() ? 0 : log.imu.back().time);
  const bool goes_on = back.about && back.about->size() > 0 && back.about->last_time() < end - kSameInstant;
  return goes_on ? run_filter(log, options, without_alignment(log.world, found), keep, progress, {.end = end_time},
                              back.about, rows, scratch)
                 : run_filter(log, options, found.start, keep, progress, {.end = end_time}, nullptr, rows, scratch);
}

void put_rows(const Solution& known, Solution& filtered) {
  const std::size_t count = rows_until_end(filtered, known);
  std::size_t next = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double time = filtered.time(i);
    while (next + 1 < known.size() && known.time(next) < time - kSameInstant) ++next;
    Estimate x = known.estimate(next);
    if (const double after = known.time(next) - time; next > 0 && after > kSameInstant) {
      const Estimate before = known.estimate(next - 1);
      const double step = known.time(next) - known.time(next - 1);
      x = boxplus(x, known.layout(), after / step * boxminus(before, x, known.layout()));
    }
    filtered.set(i, time, x, known.sigmas(next));
  }
}

void put_rows(const Solution& known, FilterRun& filtered) {
  Solution& rows = filtered.solution;
  filtered.replaced = Solution(rows.layout(), rows.world());
  filtered.replaced.fixed = rows.fixed;
  filtered.replaced.append(rows.rows().first(rows_until_end(rows, known) * rows.stride()));
  put_rows(known, rows);
}

}  // namespace piste
