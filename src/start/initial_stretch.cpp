#include "piste/start/initial_stretch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/time_search.h"
#include "filter/reference.h"
#include "piste/smoother/rts.h"
#include "start/merged_fixes.h"
#include "walker/fix_queue.h"

namespace piste {
namespace {

constexpr int kMostPasses = 4;
constexpr double kRestStep = 1;  // s of a rest that are one epoch until the trajectory has converged, and one fix
// Sigmas: a trajectory that moves by less everywhere is linearised well enough, as the next pass moves it by much less.
constexpr double kConverged = 0.5;
constexpr double kLastPass = 4;  // times that, where another pass follows: each moves it by a quarter of the one before

// The largest change of position, velocity or attitude from one smoothed run to another, in sigmas.
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

}  // namespace

std::size_t InitialStretch::rows_of(const Solution& filtered) const {
  std::size_t count = 0;
  const double end = rows.empty() ? -1e300 : rows.time(rows.size() - 1) + kSameInstant;
  while (count < filtered.size() && filtered.time(count) <= end) ++count;
  return count;
}

InitialStretch initial_stretch(const Log& log, const FilterOptions& options, const FoundStart& found) {
  if (!found.aligned) return {};
  const double end = *found.aligned + kSameInstant, rest_step = options.behaviour.start.rest_step;
  const Log part = with_merged_fixes(log, end, kRestStep);
  SmoothedState at_start;
  const auto smoothed = [&](InitialStretch& stretch, const Log& fixes, double step) {
    const Start start = stretch.about ? without_alignment(log.world, found) : found.start;
    stretch.run = run_filter(fixes, options, start, Keep::kHistory, {}, {.end = end, .rest_step = step}, stretch.about);
    return smooth_rts(stretch.run, {}, &at_start);
  };
  const bool one_more = !part.rest.empty();
  InitialStretch stretch;
  stretch.rows = smoothed(stretch, part, kRestStep);
  for (int pass = 0; pass < kMostPasses; ++pass) {
    stretch.about = trajectory_of(stretch.rows, at_start.x);
    Solution rows = smoothed(stretch, part, kRestStep);
    const double moved = farthest_moved(stretch.rows, rows);
    stretch.rows = std::move(rows);
    if (moved < (one_more ? kLastPass : 1) * kConverged) break;
  }
  if (one_more) {
    stretch.about = trajectory_of(stretch.rows, at_start.x);
    stretch.rows = smoothed(stretch, log, rest_step);
  }
  return stretch;
}

FilterRun filter_from(const InitialStretch& stretch, const Log& log, const FilterOptions& options,
                      const FoundStart& found, Keep keep, const ProgressCallback& progress, double end_time,
                      const RowTaker& rows, const std::filesystem::path& scratch) {
  const LogPart part{.end = end_time};
  if (!stretch.about) return run_filter(log, options, found.start, keep, progress, part, nullptr, rows, scratch);
  const double end = std::min(end_time, log.imu.empty() ? 0 : log.imu.back().time);
  const bool goes_on = stretch.about->size() > 0 && stretch.about->last_time() < end - kSameInstant;
  if (keep == Keep::kHistory && !goes_on) keep = Keep::kWholeHistory;
  RowTaker replaced;
  if (rows) {
    replaced = [&](Solution& filtered, std::size_t first) {
      replace_rows(filtered, stretch.rows);
      rows(filtered, first);
    };
  }
  FilterRun run = run_filter(log, options, goes_on ? without_alignment(log.world, found) : found.start, keep, progress,
                             part, goes_on ? stretch.about : nullptr, replaced, scratch);
  replace_rows(run.solution, stretch.rows);
  return run;
}

void replace_rows(Solution& filtered, const Solution& known) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < filtered.size() && !known.empty(); ++i) {
    const double time = filtered.time(i);
    if (time > known.time(known.size() - 1) + kSameInstant) return;
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

}  // namespace piste
